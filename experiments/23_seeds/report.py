"""Tables and the figure of seeds, from the outcomes."""

from __future__ import annotations

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from experiments.common.outcomes import Outcomes, read
from experiments.common.tables import percent, points, sections, table
from gcm_learn.evaluation import chance, difference, holm, mcnemar, wilson

LIMITS = (5.0, 10.0, 20.0, 50.0)
"""Times to think [ms]; the second is that of the hypothesis, and all that is charged."""
HYPOTHESIS = LIMITS[1]
SEARCH = "search"
PAIRS = (
    ("recalled, shipped order", SEARCH),
    ("recalled, shipped order", "model of postures"),
    ("recalled, order of seeds", SEARCH),
    ("recalled, order of seeds", "model of postures"),
    ("recalled, order of seeds", "recalled, no gates"),
    ("recalled, order of seeds", "stored, random"),
    ("stored, random", SEARCH),
    ("model of postures", SEARCH),
    ("whole movements", SEARCH),
)
COLOURS = {
    SEARCH: "black",
    "recalled, shipped order": "#20639b",
    "recalled, order of seeds": "#3caea3",
    "stored, random": "#999999",
    "model of postures": "#e08e2b",
    "whole movements": "#a05195",
}


def results(folder: Path) -> dict[str, str]:
    """Return the tables of the outcomes."""
    found = read(folder / "outcomes.csv.gz")
    count = len(found.where(method=SEARCH))
    tables = {
        f"Catches that are there in time, of {count} situations": caught(found),
        f"Differences within {HYPOTHESIS:g} ms": differences(found),
    }
    return {"table.md": sections(tables)}


def in_time(found: Outcomes, name: str, limit: float) -> np.ndarray:
    """Return whether a method's catches (n,) are there by a time [ms]."""
    mine = found.where(method=name)
    took = np.nan_to_num(mine["ms"])  # without a time the arm rested into the catch
    order = np.argsort(mine["situation"].astype(int))
    return np.asarray((mine["caught"] & (took <= limit))[order])


def caught(found: Outcomes) -> str:
    """Return how much each method catches by several times."""
    head = ["method", *(f"{limit:g} ms" for limit in LIMITS), "in the end"]
    head += ["by seeds alone", "median [ms]", "complaints"]
    lines = []
    for name in COLOURS | {"recalled, no gates": ""}:
        mine, shares = found.where(method=name), []
        for limit in (*LIMITS, np.inf):
            ready = in_time(found, name, limit)
            shares.append(percent(wilson(int(ready.sum()), len(ready)), 1))
        alone = f"{100 * np.mean(mine['alone']):.1f}" if "whole" not in name else ""
        took = np.where(mine["caught"], mine["ms"], np.inf)
        faults = f"{int(np.nansum(mine['complaints']))} of {int(mine['caught'].sum())}"
        lines.append([name, *shares, alone, f"{np.median(took):.1f}", faults])
    return table(head, lines)


def differences(found: Outcomes) -> str:
    """Return differences of shares that are there in time, Holm over all that is shown."""
    lines, chances = [], []
    for pair in PAIRS:
        first, second = (in_time(found, name, HYPOTHESIS) for name in pair)
        apart = difference(first, second, np.zeros(len(first)))
        only, other, p = mcnemar(first, second)
        lines.append([f"{pair[0]} less {pair[1]}", points(apart), str(only), str(other)])
        chances.append(p)
    head = ["pair", "points", "only the first", "only the second", "p (Holm)"]
    corrected = zip(lines, holm(chances), strict=True)
    return table(head, [[*line, chance(p)] for line, p in corrected])


def write_figure(file: Path, found: Outcomes) -> None:
    """Draw the share that is caught against the time to think."""
    figure, axes = plt.subplots(figsize=(5.6, 3.8), layout="constrained")
    at = np.geomspace(1.0, 200.0, 150)
    for name, colour in COLOURS.items():
        shares = [100.0 * in_time(found, name, limit).mean() for limit in at]
        axes.plot(at, shares, color=colour, lw=2.0 if name == SEARCH else 1.4, label=name)
    axes.axvline(HYPOTHESIS, color="black", lw=0.6)
    axes.set(xscale="log", xlabel="time to think [ms]", ylabel="first catch is there [%]")
    axes.set_xticks(
        [1, 2, 5, 10, 20, 50, 100, 200], ["1", "2", "5", "10", "20", "50", "100", "200"]
    )
    axes.set_ylim(0, 100)
    axes.grid(alpha=0.25)
    axes.legend(fontsize=8, loc="lower right")
    figure.savefig(file, dpi=110)
    plt.close(figure)
