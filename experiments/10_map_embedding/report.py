"""Tables and figure, computed from outcomes."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise, product
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from experiments.common.comparing import STRATA, within
from experiments.common.outcomes import Outcomes, read
from experiments.common.tables import percent, rounded, sections, table
from gcm_learn.evaluation import hierarchical

CHECKS = (1, 5, 20)
BASE = "raw neighbours"
ADDED = ("map unchanged", "catch unchanged")
PAIRS = (
    ("map", BASE), ("raw, learned", BASE), ("map", "raw, learned"), ("map", "path"),
    ("path and map", "path"),
)  # fmt: skip
COLOURS = {
    "path": "#0b6e4f", "map": "#2b6cb0", "path and map": "#6b46c1", "raw, learned": "#dd6b20",
    "raw neighbours": "#c1666b", "components of maps": "#d4a017", "codes of maps": "#8a5a00",
    "random": "#7d8597",
}  # fmt: skip
BARS = ("path", "map", "path and map", "raw, learned", "raw neighbours", "random")


def results(folder: Path) -> dict[str, str]:
    """Return the tables of the outcomes."""
    found = read(folder / "outcomes.csv.gz")
    plane, space = (found.where(world=world) for world in ("plane", "space"))
    parts = {
        "As drawn, by world": as_drawn(found),
        "Differences as drawn, by world": differences(found),
        "Obstacles added, in the plane": added(plane),
        "Growth of differences with 8 obstacles, in the plane": growth(plane),
    }
    note = (
        f"Caught [%] of {counted(plane)} in the plane and {counted(space)} in space. Intervals of "
        "95 % by drawing seeds and situations again; differences over the same situations. "
        "Encoders have three seeds of training; the others have none."
    )
    return {"table.md": sections(parts) + "\n" + note + "\n"}


def counted(rows: Outcomes) -> str:
    """Return the numbers of situations by stratum."""
    sizes = [len(set(rows.where(stratum=name)["situation"].tolist())) for name in STRATA]
    return " and ".join(f"{size} {name}" for size, name in zip(sizes, STRATA, strict=True))


def over_seeds(rows: Outcomes, method: str, checks: int) -> np.ndarray:
    """Return the catches (seeds, situations) of a method, situations in the same order."""
    mine = rows.where(method=method)
    seeds = sorted(set(mine["seed"].tolist()))
    each = [mine.where(seed=int(seed)) for seed in seeds]
    order = [np.argsort(one["situation"]) for one in each]
    caught = [within(one, checks)[rank] for one, rank in zip(each, order, strict=True)]
    return np.array(caught, float)


def gap(rows: Outcomes, first: str, second: str, checks: int) -> np.ndarray:
    """Return differences (seeds, situations) of two methods."""
    return over_seeds(rows, first, checks) - over_seeds(rows, second, checks)


def as_drawn(found: Outcomes) -> str:
    """Return catches in both worlds with nothing added."""
    lines = []
    for world, stratum, checks in product(("plane", "space"), STRATA, CHECKS):
        some = nothing_added(found, world, stratum)
        known = some.methods()
        cells = [
            percent(hierarchical(over_seeds(some, name, checks))) if name in known else ""
            for name in COLOURS
        ]
        lines.append([world, stratum, checks, *cells])
    return table(["world", "stratum", "checks", *COLOURS], lines)


def nothing_added(found: Outcomes, world: str, stratum: str) -> Outcomes:
    """Return the rows of a world and a stratum with nothing added."""
    return found.where(
        world=world, stratum=stratum, added=(ADDED[0], "nothing"), extra=0
    )  # both additions start from the same situations


def differences(found: Outcomes) -> str:
    """Return differences of methods in both worlds, those of all and those of each seed."""
    lines = []
    for world, stratum, checks in product(("plane", "space"), STRATA, (1, 20)):
        some = nothing_added(found, world, stratum)
        for first, second in PAIRS:
            apart = gap(some, first, second, checks)
            each = 100 * apart.mean(axis=1)
            span = f"{each.min():+.1f} to {each.max():+.1f}"
            lines.append(
                [world, stratum, checks, f"{first} less {second}",
                 rounded(hierarchical(apart)), span]
            )  # fmt: skip
    return table(["world", "stratum", "checks", "gap of", "all seeds", "of the seeds"], lines)


def added(plane: Outcomes) -> str:
    """Return catches with the first choice and with 20 checks, as obstacles are added."""
    extras = extras_of(plane)
    lines = []
    for what, stratum, checks, name in product(ADDED, STRATA, (1, 20), COLOURS):
        rows = [plane.where(added=what, stratum=stratum, extra=e) for e in extras]
        cells = [percent(hierarchical(over_seeds(one, name, checks))) for one in rows]
        lines.append([what, stratum, checks, name, *cells])
    return table(["added", "stratum", "checks", "found by", *(f"+{e}" for e in extras)], lines)


def extras_of(plane: Outcomes) -> list[int]:
    """Return the numbers of obstacles that are added."""
    return sorted({int(extra) for extra in plane["extra"]})


def growth(plane: Outcomes) -> str:
    """Return how differences change from none to most obstacles."""
    extras, lines = extras_of(plane), []
    for what, stratum, checks, (first, second) in product(ADDED, STRATA, (1, 20), PAIRS):
        ends = [plane.where(added=what, stratum=stratum, extra=e) for e in (extras[0], extras[-1])]
        none, most = (gap(rows, first, second, checks) for rows in ends)
        cells = [rounded(hierarchical(one)) for one in (none, most, most - none)]
        lines.append([what, stratum, checks, f"{first} less {second}", *cells])
    head = ["added", "stratum", "checks", "gap of", "+0", f"+{extras[-1]}", "grew by"]
    return table(head, lines)


def write_figure(file: Path, found: Outcomes) -> None:
    """Draw catches as drawn in both worlds, and against obstacles added in the plane."""
    figure, axes = plt.subplots(2, 3, figsize=(13.0, 7.0), sharey="row", layout="constrained")
    for row, stratum in zip(axes, STRATA, strict=True):
        for ax, world in zip(row, ("plane", "space"), strict=False):
            draw_bars(ax, nothing_added(found, world, stratum))
            ax.set_title(f"{world}, {stratum}: first choice", fontsize=10)
        draw_added(row[2], found.where(world="plane", stratum=stratum, added=ADDED[0]))
        row[2].set_title(f"plane, {stratum}: obstacles added, map unchanged", fontsize=10)
        row[0].set_ylabel("caught [%]")
    axes[1, 2].set_xlabel("obstacles added")
    figure.savefig(file, dpi=110)
    plt.close(figure)


def draw_bars(ax: plt.Axes, some: Outcomes) -> None:
    """Draw catches of the first choice as bars with intervals."""
    for k, name in enumerate(BARS):
        value, low, high = 100 * np.array(hierarchical(over_seeds(some, name, 1)))
        ax.bar(k, value, color=COLOURS[name], width=0.75)
        ax.errorbar(k, value, [[value - low], [high - value]], color="black", lw=1, capsize=3)
    ax.set_xticks(range(len(BARS)), [name.replace(", ", ",\n").replace(" ", "\n", 1)
                                     for name in BARS], fontsize=8)  # fmt: skip
    ax.grid(axis="y", alpha=0.25)
    ax.set_ylim(0, 100)


def draw_added(ax: plt.Axes, some: Outcomes) -> None:
    """Draw catches of the first choice against obstacles added."""
    extras = extras_of(some)
    ends = []
    for name in BARS:
        shares = [100 * over_seeds(some.where(extra=e), name, 1).mean() for e in extras]
        ax.plot(extras, shares, "o-", ms=3, color=COLOURS[name], label=name)
        ends.append(shares[-1])
    for name, y in zip(BARS, apart(ends), strict=True):
        ax.text(extras[-1] + 0.3, y, name, color=COLOURS[name], fontsize=8, va="center")
    ax.set(xticks=extras, xlim=(-0.3, 12.5))
    ax.grid(alpha=0.25)


def apart(heights: Sequence[float], least: float = 4.0) -> list[float]:
    """Move heights of labels apart, in their order."""
    order = np.argsort(heights)
    out = np.array(heights, float)
    for below, above in pairwise(order):
        out[above] = max(out[above], out[below] + least)
    return [float(one) for one in out]
