"""Tables and the figure of catches with and without experience, from the outcomes."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from experiments.common.outcomes import Outcomes, read
from experiments.common.tables import percent, points, sections, table
from gcm_learn.evaluation import chance, hierarchical, hierarchical_difference, holm

LIMIT = 1000.0  # time that counts for an answer without a catch [ms]
DRAWS = 2000  # of the bootstrap of ratios
PAIRS = {
    "short": (
        ("stored, learned", "synthetic, learned"),
        ("stored, shipped", "synthetic, shipped"),
        ("stored, random", "synthetic, random"),
        ("stored, learned", "stored, random"),
        ("synthetic, learned", "synthetic, random"),
        ("stored, learned", "search"),
        ("synthetic, learned", "search"),
    ),
    "half": (
        ("stored, learned", "search"),
        ("stored, learned", "synthetic, learned"),
        ("stored, learned", "stored, random"),
        ("synthetic, learned", "search"),
    ),
}
FRONTS = ("synthetic, random", "synthetic, learned", "stored, random", "stored, learned")
TITLES = {"space, limits": "space, limits of acceleration", "plane": "plane", "space": "space",
          "panda": "Panda", "panda, limits": "Panda, limits of acceleration"}  # fmt: skip
COLOURS = {"stored": "#20639b", "synthetic": "#e08e2b", "search": "#777777"}


def results(folder: Path) -> dict[str, str]:
    """Return the tables of the outcomes."""
    found = read(folder / "outcomes.csv.gz")
    tables = {
        "Differences within 20 ms": differences(found, "short"),
        "Differences within half the median time of the search": differences(found, "half"),
        "Time to the first catch": times(found),
    }
    for world in worlds(found):
        mine = found.where(world=world, budget="short")
        tables[f"{world}: ready within 20 ms"] = caught(mine)
    return {"table.md": sections(tables)}


def worlds(found: Outcomes) -> list[str]:
    """Return the worlds, that of the hypothesis first."""
    return sorted(set(found["world"].tolist()), key=list(TITLES).index)


def by_seed(some: Outcomes, column: str, name: str) -> np.ndarray:
    """Return a method's values (seeds, n), situations in the same order for all methods."""
    mine = some.where(method=name)
    rows = []
    for seed in np.unique(mine["seed"]):
        one = mine.where(mine["seed"] == seed)
        order = np.argsort(one["situation"].astype(int))
        rows.append(one[column][order])
    return np.array(rows)


def ready(some: Outcomes, name: str) -> np.ndarray:
    """Return whether a method's catches were there in time (seeds, n)."""
    took, budget = (by_seed(some, column, name) for column in ("ms", "budget_ms"))
    in_time = np.isnan(took) | (took <= budget)  # without a time the arm rested into it
    return np.asarray(by_seed(some, "caught", name) & in_time)


def spent(some: Outcomes, name: str) -> np.ndarray:
    """Return times to a catch (seeds, n) [ms], LIMIT without one; only where all were asked."""
    took = np.minimum(by_seed(some, "ms", name), LIMIT)
    took[~by_seed(some, "caught", name)] = LIMIT
    asked = ~np.isnan(by_seed(some, "ms", name)[0])
    return np.asarray(took[:, asked])


def caught(some: Outcomes) -> str:
    """Return how much each method catches in time and in the end, with complaints."""
    head = ["method", "seeds", "W [%]", "Q [%]", "W and Q [%]", "in the end [%]",
            "median [ms]", "90 % [ms]", "complaints"]  # fmt: skip
    lines = []
    for name in some.methods():
        strata = [some.where(stratum=stratum) for stratum in ("W", "Q")]
        shares = [
            percent(hierarchical(ready(one, name).astype(float)), 1) for one in (*strata, some)
        ]
        took, mine = spent(some, name), some.where(method=name)
        end = f"{100 * by_seed(some, 'caught', name).mean():.1f}"
        spread = [f"{np.quantile(took, share):.1f}" for share in (0.5, 0.9)]
        faults = f"{int(np.nansum(mine['complaints']))} of {int(mine['caught'].sum())}"
        lines.append([name, len(took), *shares, end, *spread, faults])
    situations = len(some.where(method="search"))
    return f"{situations} situations.\n\n{table(head, lines)}"


def differences(found: Outcomes, budget: str) -> str:
    """Return differences of shares that are ready in time, Holm within each world."""
    head = ["world", "budget [ms]", "pair", "points", "p", "p (Holm)"]
    lines = []
    for world in worlds(found):
        mine = found.where(world=world, budget=budget)
        pairs = [*compared(mine, budget)]
        corrected = holm([p for _, _, p in pairs])
        for (pair, apart, p), q in zip(pairs, corrected, strict=True):
            ms = f"{mine['budget_ms'][0]:g}"
            lines.append([world, ms, pair, apart, chance(p), chance(q)])
    return table(head, lines)


def compared(mine: Outcomes, budget: str) -> Iterator[tuple[str, str, float]]:
    """Yield pairs of methods with their difference and its probability."""
    for first, second in PAIRS[budget]:
        one, other = (ready(mine, name) for name in (first, second))
        seeds = max(len(one), len(other))
        one, other = (np.repeat(x, seeds, axis=0) if len(x) == 1 else x for x in (one, other))
        apart, p = hierarchical_difference(one, other)
        yield f"{first} less {second}", points(apart), p


def times(found: Outcomes) -> str:
    """Return times to the first catch with movements before the search, and without."""
    head = ["world", "before the search", "90 % [ms]", "alone: 90 % [ms]", "ratio", "median ratio",
            "caught in the end", "alone"]  # fmt: skip
    lines = []
    for world in worlds(found):
        mine = found.where(world=world, budget="short")
        alone = spent(mine, "search")
        for name in FRONTS:
            took = spent(mine, name)
            tail, middle = (ratio(took, alone, share) for share in (0.9, 0.5))
            ends = [f"{100 * by_seed(mine, 'caught', who).mean():.1f}" for who in (name, "search")]
            spread = [f"{np.quantile(times, 0.9):.1f}" for times in (took, alone)]
            lines.append([world, name, *spread, tail, middle, *ends])
    return table(head, lines)


def ratio(took: np.ndarray, alone: np.ndarray, share: float) -> str:
    """Return a ratio of quantiles with its 95 % interval; situations are drawn again."""
    rng, count = np.random.default_rng(0), took.shape[1]
    drawn = rng.integers(count, size=(DRAWS, count))
    again = [np.quantile(took[:, k], share) / np.quantile(alone[:, k], share) for k in drawn]
    low, high = np.quantile(again, [0.025, 0.975])
    value = np.quantile(took, share) / np.quantile(alone, share)
    return f"{value:.2f} ({low:.2f} to {high:.2f})"


def write_figure(file: Path, found: Outcomes) -> None:
    """Draw the share that is caught against the time to think, in each world."""
    names = worlds(found)
    figure, axes = plt.subplots(
        1, len(names), figsize=(3.6 * len(names), 4.0), sharey=True, layout="constrained"
    )
    for ax, world in zip(np.atleast_1d(axes), names, strict=True):
        mine, at = found.where(world=world, budget="short"), np.geomspace(0.3, 300.0, 120)
        for name in ("search", *FRONTS):
            source, _, order = name.partition(", ")
            took = spent(mine, name)
            shares = [100.0 * (took[..., None] <= at).mean(axis=(0, 1))][0]
            style = "-" if order in ("", "learned") else ":"
            ax.plot(at, shares, style, color=COLOURS[source], label=name)
        ax.axvline(20.0, color="black", lw=0.6)
        ax.set(xscale="log", title=TITLES[world], xlabel="time to think [ms]", ylim=(0, 100))
        ax.grid(alpha=0.25)
    np.atleast_1d(axes)[0].set_ylabel("first catch is there [%]")
    np.atleast_1d(axes)[-1].legend(fontsize=8, loc="lower right")
    figure.savefig(file, dpi=110)
    plt.close(figure)
