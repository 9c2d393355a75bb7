"""Table and figures, computed from outcomes."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from experiments.common.comparing import share, within
from experiments.common.outcomes import Outcomes, read
from experiments.common.tables import rounded, table
from gcm_learn.evaluation import difference, stratified
from gcm_learn.maps import CognitiveMap, build_map
from gcm_learn.plots import (
    draw_bodies,
    draw_courses,
    draw_targets,
    draw_workspace,
    plot_map,
    style,
)
from gcm_learn.recall import path_of
from gcm_learn.wave import MarchingParams

STRATA = ("L", "W", "Q")
CHECKS = (1, 5, 20)
BASE = "dynamic"
TWINS = ("twins, one pose", "twins, five poses")
COLOURS = {
    BASE: "#0b6e4f",
    f"{BASE}, those of the twins": "#68a691",
    TWINS[0]: "#c1666b",
    TWINS[1]: "#d4a017",
    "static as drawn": "#7d8597",
}
INDEXES = ("learned", "raw", "random", "learned, unchanged")
"""Names of how memories are found; unchanged paths are adapted to the ends and not changed."""


def results(folder: Path) -> dict[str, str]:
    """Return the table of the outcomes."""
    found, twins = (read(folder / f"outcomes{end}.csv.gz") for end in ("", "-twins"))
    return {"table.md": tabled(found, twins)}


def tabled(found: Outcomes, twins: Outcomes) -> str:
    """Return shares caught, their differences to the dynamic memory, and the twins."""
    asked = [(s, k) for s in STRATA for k in CHECKS]
    shares, less = [], []
    for index in INDEXES:
        for method in COLOURS:
            rows = {s: found.where(index=index, method=method, stratum=s) for s in STRATA}
            base = {s: found.where(index=index, method=BASE, stratum=s) for s in STRATA}
            shares.append([method, index, *(share(rows[s], checks=k) for s, k in asked)])
            gaps = [
                difference(within(rows[s], k), within(base[s], k), rows[s]["family"])
                for s, k in asked
            ]
            if method != BASE:
                less.append([method, index, *map(rounded, gaps)])
    head = ["memory", "found by", *(f"{s}, {k}" for s, k in asked)]
    one = found.where(index=INDEXES[0], method=BASE)
    counts = ", ".join(f"{len(one.where(stratum=s))} {s}" for s in STRATA)
    parts = [
        table(head, shares),
        "Less the memory of dynamic situations, found by the same index [points]:",
        table(head, less),
        made_of(twins),
        f"Caught [%] of planar situations with an obstacle that moves ({counts}) with at most 1, "
        "5, 20 checked paths; 95 % intervals, bootstrapped within families, of differences over "
        "pairs.",
    ]
    return "\n\n".join(parts) + "\n"


def made_of(twins: Outcomes) -> str:
    """Return the table of twins: how many there are, and which cells of the map they keep."""
    head = ["twin", "of stratum", "made", "caught by first arrival",
            "effective cells that stay shut", "reached cells that stay open"]  # fmt: skip
    rows = []
    for name in TWINS:
        for s in STRATA:
            some = twins.where(method=name, stratum=s)
            kept = (some["caught"].mean(), np.nanmean(some["shut"]), np.nanmean(some["open"]))
            rows.append([name, s, len(some), *(f"{100 * x:.0f} %" for x in kept)])
    return table(head, rows)


def write_figure(file: Path, found: Outcomes) -> None:
    """Draw catches with the learned index, by changed paths and by unchanged ones."""
    figure, axes = plt.subplots(2, 3, figsize=(12.0, 6.6), sharey="row", sharex=True,
                                layout="constrained")  # fmt: skip
    for row, index in zip(axes, (INDEXES[0], INDEXES[-1]), strict=True):
        for ax, stratum in zip(row, STRATA, strict=True):
            for b, (method, colour) in enumerate(COLOURS.items()):
                some = found.where(index=index, method=method, stratum=stratum)
                for i, k in enumerate(CHECKS):
                    value, low, high = stratified(within(some, k), some["family"])
                    at, label = i + 0.16 * (b - 2), method if i == 0 else None
                    ax.bar(at, 100 * value, 0.15, color=colour, label=label)
                    ax.plot([at, at], [100 * low, 100 * high], color="k", lw=0.9)
            ax.set_xticks(range(3), [f"{k} check{'s' * (k > 1)}" for k in CHECKS])
            ax.set(title=f"{stratum}, found by {index}", ylim=(0, 101))
            ax.grid(alpha=0.25, axis="y")
        row[0].set_ylabel("caught [%]")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=5, frameon=False, fontsize=9)
    figure.savefig(file, dpi=110)
    plt.close(figure)


def write_example(file: Path, record: Any, made: CognitiveMap, twins: Mapping[str, Any]) -> None:
    """Draw a situation and its twins, each above its map."""
    figure = style.new_figure(3.2 * (1 + len(twins)), 6.6)
    panels = figure.subplots(2, 1 + len(twins))
    plan = min((p for p in record.plans.values() if p.caught), key=lambda p: p.catch_time)
    draw_workspace(panels[0, 0], record.situation)
    draw_bodies(panels[0, 0], record.situation, plan.catch_time, 0.3)
    draw_courses(panels[0, 0], record.situation, plan.catch_time)
    style.title(panels[0, 0], f"dynamic: {record.family}")
    plot_map(made, panels[1, 0], plan.trajectory.hand)
    draw_targets(panels[1, 0], record.situation, plan.catch_time)
    for column, (name, twin) in zip(panels.T[1:], twins.items(), strict=True):
        draw_workspace(column[0], twin.situation)
        style.title(column[0], name)
        made = build_map(twin.situation, MarchingParams(n=record.n))
        plot_map(made, column[1], path_of(twin.trace, twin.situation.arm)[1])
        draw_targets(column[1], twin.situation, 0.0)
    figure.savefig(file, dpi=90)
