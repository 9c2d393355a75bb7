"""Table and figure."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from experiments.common.tables import percent, rounded, table
from gcm_learn.evaluation import Interval, difference, stratified

CHECKS = (1, 5, 20)
BASE = "raw neighbours"
PAIRS = (("map", "raw, learned"), ("map", "way"), ("way and map", "way"))
COLOURS = {
    "way": "#0b6e4f", "map": "#2b6cb0", "way and map": "#6b46c1", "raw, learned": "#dd6b20",
    "raw neighbours": "#c1666b", "components of maps": "#d4a017", "codes of maps": "#8a5a00",
    "random": "#7d8597",
}  # fmt: skip
Line = dict[str, Any]


def chosen(lines: list[Line], **wanted: object) -> list[Line]:
    """Lines with these values."""
    return [x for x in lines if all(x[key] == value for key, value in wanted.items())]


def caught(lines: list[Line], checks: int) -> np.ndarray:
    """Which were caught within so many checks."""
    return np.array([x["caught"] and x["checks"] <= checks for x in lines])


def families(lines: list[Line]) -> np.ndarray:
    """Their families."""
    return np.array([x["family"] for x in lines])


def values(lines: list[Line], key: str) -> list:
    """Different values of a key, in order."""
    return list(dict.fromkeys(x[key] for x in lines))


def gap(lines: list[Line], name: str, base: str, checks: int, extra: int) -> Interval:
    """Return the lead of one index over another, with so many obstacles added."""
    mine, less = (chosen(lines, index=k, extra=extra) for k in (name, base))
    return difference(caught(mine, checks), caught(less, checks), families(mine))


def growth(lines: list[Line], name: str, against: str, checks: int, extra: int) -> Interval:
    """Return the growth of that lead from no added obstacles to so many."""
    gaps = []
    for number in (extra, 0):
        mine, base = (chosen(lines, index=k, extra=number) for k in (name, against))
        gaps.append(caught(mine, checks).astype(float) - caught(base, checks))
    return difference(gaps[0], gaps[1], families(chosen(lines, index=name, extra=0)))


def gaps(lines: list[Line], name: str, base: str, checks: int) -> list[str]:
    """A gap with no and with most obstacles added, and how much it grew."""
    ends = (min(values(lines, "extra")), max(values(lines, "extra")))
    found = [gap(lines, name, base, checks, extra) for extra in ends]
    found.append(growth(lines, name, base, checks, ends[1]))
    return [rounded(interval) for interval in found]


def write_table(file: Path, lines: list[Line], told: str) -> None:
    """Catches, and gaps to raw neighbours."""
    extras = values(lines, "extra")
    ends = (extras[0], extras[-1])
    head = ["added", "stratum", "checks", "found by", *(f"+{e}" for e in extras),
            *(f"less raw neighbours, +{e}" for e in ends), "that gap grew by"]  # fmt: skip
    less = ["added", "stratum", "checks", "gap of", *(f"+{e}" for e in ends), "grew by"]
    counts, shares, differences = [], [], []
    for added in values(lines, "added"):
        for stratum in values(lines, "stratum"):
            some = chosen(lines, added=added, stratum=stratum)
            counts.append(f"{len(values(some, 'case'))} {stratum} ({added})")
            for checks in CHECKS:
                for name in values(some, "index"):
                    rows = [chosen(some, index=name, extra=e) for e in extras]
                    cells = [percent(stratified(caught(r, checks), families(r))) for r in rows]
                    cells += ["", "", ""] if name == BASE else gaps(some, name, BASE, checks)
                    shares.append([added, stratum, checks, name, *cells])
                for name, base in PAIRS:
                    which = [added, stratum, checks, f"{name} less {base}"]
                    differences.append([*which, *gaps(some, name, base, checks)])
    note = (
        f"Caught [%] of planar test situations with so many obstacles added: {', '.join(counts)}. "
        f"{told}. 95 % intervals, bootstrapped within families; gaps over the same situations."
    )
    text = "\n\n".join([table(head, shares), table(less, differences), note])
    file.write_text(text + "\n", encoding="utf-8")


def write_figure(file: Path, lines: list[Line]) -> None:
    """Catches against obstacles added."""
    extras = values(lines, "extra")
    panels = [(a, s, k) for a in values(lines, "added") for s in values(lines, "stratum")
              for k in (1, 20)]  # fmt: skip
    figure, axes = plt.subplots(2, 4, figsize=(14.0, 6.8), sharey="col", sharex=True,
                                layout="constrained")  # fmt: skip
    for ax, (added, stratum, checks) in zip(axes.flat, panels, strict=True):
        for name, colour in COLOURS.items():
            rows = [chosen(lines, added=added, stratum=stratum, index=name, extra=e)
                    for e in extras]  # fmt: skip
            rates = np.array([stratified(caught(r, checks), families(r)) for r in rows])
            ax.plot(extras, 100 * rates[:, 0], "o-", ms=3, color=colour, label=name)
            ax.fill_between(extras, *(100 * rates[:, 1:].T), color=colour, alpha=0.08, lw=0)
        ax.set_title(f"{stratum}, {checks} check{'s' * (checks > 1)}: {added}", fontsize=10)
        ax.grid(alpha=0.25)
    for ax in axes[1]:
        ax.set(xlabel="obstacles added", xticks=extras)
    for ax in axes[:, 0]:
        ax.set_ylabel("caught [%]")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=7, frameon=False, fontsize=9)
    figure.savefig(file, dpi=110)
    plt.close(figure)
