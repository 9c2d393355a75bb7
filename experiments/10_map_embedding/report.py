"""Table and figure, computed from outcomes."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from experiments.common.comparing import STRATA, share, within
from experiments.common.outcomes import Outcomes, read
from experiments.common.tables import rounded, table
from gcm_learn.evaluation import difference, stratified

CHECKS = (1, 5, 20)
BASE = "raw neighbours"
ADDED = ("map unchanged", "catch unchanged")
PAIRS = (("map", "raw, learned"), ("map", "path"), ("path and map", "path"))
COLOURS = {
    "path": "#0b6e4f", "map": "#2b6cb0", "path and map": "#6b46c1", "raw, learned": "#dd6b20",
    "raw neighbours": "#c1666b", "components of maps": "#d4a017", "codes of maps": "#8a5a00",
    "random": "#7d8597",
}  # fmt: skip


def results(folder: Path) -> dict[str, str]:
    """Return the table of the outcomes."""
    return {"table.md": tabled(read(folder / "outcomes.csv.gz"))}


def leads(rows: Outcomes, name: str, base: str, checks: int, ends: Sequence[int]) -> list[str]:
    """Return the lead of one index over another with none and most obstacles added, and growth."""
    caught = {
        (one, extra): within(rows.where(method=one, extra=extra), checks)
        for one, extra in product((name, base), ends)
    }
    families = rows.where(method=name, extra=ends[0])["family"]
    found = [difference(caught[name, e], caught[base, e], families) for e in ends]
    gaps = [caught[name, e].astype(float) - caught[base, e] for e in ends]
    return [rounded(one) for one in (*found, difference(gaps[1], gaps[0], families))]


def tabled(found: Outcomes) -> str:
    """Return catches, and leads over raw neighbours."""
    extras = sorted({int(extra) for extra in found["extra"]})
    ends = (extras[0], extras[-1])
    counts, shares, differences = [], [], []
    for added, stratum in product(ADDED, STRATA):
        some = found.where(added=added, stratum=stratum)
        counts.append(f"{len(set(some['situation'].tolist()))} {stratum} ({added})")
        for checks in CHECKS:
            for name in COLOURS:
                rows = [some.where(method=name, extra=e) for e in extras]
                cells = [share(one, checks=checks) for one in rows]
                cells += ["", "", ""] if name == BASE else leads(some, name, BASE, checks, ends)
                shares.append([added, stratum, checks, name, *cells])
            for name, base in PAIRS:
                which = [added, stratum, checks, f"{name} less {base}"]
                differences.append([*which, *leads(some, name, base, checks, ends)])
    head = ["added", "stratum", "checks", "found by", *(f"+{e}" for e in extras),
            *(f"less raw neighbours, +{e}" for e in ends), "that gap grew by"]  # fmt: skip
    less = ["added", "stratum", "checks", "gap of", *(f"+{e}" for e in ends), "grew by"]
    note = (
        f"Caught [%] of planar situations with so many obstacles added: {', '.join(counts)}. "
        "95 % intervals, bootstrapped within families; gaps over the same situations."
    )
    return "\n\n".join([table(head, shares), table(less, differences), note]) + "\n"


def write_figure(file: Path, found: Outcomes) -> None:
    """Draw catches against obstacles added."""
    extras = sorted({int(extra) for extra in found["extra"]})
    figure, axes = plt.subplots(2, 4, figsize=(14.0, 6.8), sharey="col", sharex=True,
                                layout="constrained")  # fmt: skip
    panels = product(ADDED, STRATA, (1, 20))
    for ax, (added, stratum, checks) in zip(axes.flat, panels, strict=True):
        some = found.where(added=added, stratum=stratum)
        for name, colour in COLOURS.items():
            rows = [some.where(method=name, extra=e) for e in extras]
            rates = np.array([stratified(within(r, checks), r["family"]) for r in rows])
            ax.plot(extras, 100 * rates[:, 0], "o-", ms=3, color=colour, label=name)
            ax.fill_between(extras, *(100 * rates[:, 1:].T), color=colour, alpha=0.08, lw=0)
        ax.set_title(f"{stratum}, {checks} check{'s' * (checks > 1)}: {added}", fontsize=10)
        ax.grid(alpha=0.25)
    for ax in axes[1]:
        ax.set(xlabel="obstacles added", xticks=extras)
    for ax in axes[:, 0]:
        ax.set_ylabel("caught [%]")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=8, frameon=False, fontsize=9)
    figure.savefig(file, dpi=110)
    plt.close(figure)
