"""Table and figures."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from experiments.common.tables import percent, rounded, table
from gcm_learn.evaluation import difference, stratified
from gcm_learn.maps import build_map
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
COLOURS = ("#0b6e4f", "#68a691", "#c1666b", "#d4a017", "#7d8597")
Line = dict[str, Any]


def caught(lines: list[Line], bank: str, index: str, stratum: str, checks: int) -> np.ndarray:
    """Return whether each situation of a stratum was caught within so many checks."""
    some = [x for x in lines if (x["bank"], x["index"], x["stratum"]) == (bank, index, stratum)]
    return np.array([x["caught"] and x["checks"] <= checks for x in some])


def families(lines: list[Line], stratum: str) -> np.ndarray:
    """Family of each situation of a stratum."""
    first = (lines[0]["bank"], lines[0]["index"])
    some = [x for x in lines if (x["bank"], x["index"]) == first and x["stratum"] == stratum]
    return np.array([x["family"] for x in some])


def _names(lines: list[Line], what: str) -> list[str]:
    return list(dict.fromkeys(line[what] for line in lines))


def write_table(file: Path, lines: list[Line], twins: list[Line], key: str) -> None:
    """Write shares caught, their differences to the dynamic memory, and the twins."""
    asked = [(s, k) for s in STRATA for k in CHECKS]
    ways = [(bank, index) for index in _names(lines, "index") for bank in _names(lines, "bank")]
    head = ["memory", "found by", *(f"{s}, {k}" for s, k in asked)]
    shares, less = [], []
    for way in ways:
        hits = [caught(lines, *way, s, k) for s, k in asked]
        groups = [families(lines, s) for s, _ in asked]
        shares.append([*way, *map(percent, map(stratified, hits, groups))])
        if way[0] != BASE:
            base = [caught(lines, BASE, way[1], s, k) for s, k in asked]
            less.append([*way, *map(rounded, map(difference, hits, base, groups))])
    counts = ", ".join(f"{len(families(lines, s))} {s}" for s in STRATA)
    parts = [
        table(head, shares),
        "Less the memory of dynamic situations, found by the same index [points]:",
        table(head, less),
        made_of(twins),
        f"Caught [%] of planar test situations with an obstacle that moves ({counts}) with "
        f"at most 1, 5, 20 checked paths; {lines[0]['size']} memories each; encoder `{key}`; "
        "95 % intervals, bootstrapped within families, of differences over pairs.",
    ]
    file.write_text("\n\n".join(parts) + "\n", encoding="utf-8")


def made_of(twins: list[Line]) -> str:
    """Return the table of twins: how many there are, and which cells of the map they keep."""
    head = ["twin", "of stratum", "made", "caught by first arrival",
            "effective cells that stay shut", "reached cells that stay open"]  # fmt: skip
    rows = []
    for name in _names(twins, "twin"):
        for s in STRATA:
            some = [x for x in twins if (x["twin"], x["stratum"]) == (name, s)]
            if not some:
                continue
            shut, open_ = np.nanmean([x["agreement"] for x in some], axis=0)
            share = np.mean([x["caught"] for x in some])
            rows.append([name, s, len(some), *(f"{100 * x:.0f} %" for x in (share, shut, open_))])
    return table(head, rows)


def write_figure(file: Path, lines: list[Line]) -> None:
    """Catches with the learned and the raw index."""
    banks, indexes = _names(lines, "bank"), _names(lines, "index")[:2]
    figure, axes = plt.subplots(len(indexes), 3, figsize=(12.0, 6.6), sharey="row", sharex=True,
                                layout="constrained")  # fmt: skip
    for row, index in zip(axes, indexes, strict=True):
        for ax, stratum in zip(row, STRATA, strict=True):
            groups = families(lines, stratum)
            for b, bank in enumerate(banks):
                for i, k in enumerate(CHECKS):
                    value, low, high = stratified(caught(lines, bank, index, stratum, k), groups)
                    at = i + 0.16 * (b - 2)
                    ax.bar(at, 100 * value, 0.15, color=COLOURS[b], label=bank if i == 0 else None)
                    ax.plot([at, at], [100 * low, 100 * high], color="k", lw=0.9)
            ax.set_xticks(range(3), [f"{k} check{'s' * (k > 1)}" for k in CHECKS])
            ax.set(title=f"{stratum}, found by {index}", ylim=(0, 101))
            ax.grid(alpha=0.25, axis="y")
        row[0].set_ylabel("caught [%]")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=5, frameon=False, fontsize=9)
    figure.savefig(file, dpi=110)
    plt.close(figure)


def write_example(file: Path, record: Any, twins: Mapping[str, Any]) -> None:
    """A situation and its twins, each above its map."""
    figure = style.new_figure(3.2 * (1 + len(twins)), 6.6)
    panels = figure.subplots(2, 1 + len(twins))
    plan = min((p for p in record.plans.values() if p.caught), key=lambda p: p.catch_time)
    draw_workspace(panels[0, 0], record.situation)
    draw_bodies(panels[0, 0], record.situation, plan.catch_time, 0.3)
    draw_courses(panels[0, 0], record.situation, plan.catch_time)
    style.title(panels[0, 0], f"dynamic: {record.family}")
    plot_map(record.map, panels[1, 0], plan.trajectory.hand)
    draw_targets(panels[1, 0], record.situation, plan.catch_time)
    for column, (name, twin) in zip(panels.T[1:], twins.items(), strict=True):
        draw_workspace(column[0], twin.situation)
        style.title(column[0], name)
        made = build_map(twin.situation, MarchingParams(n=record.n))
        plot_map(made, column[1], path_of(twin.trace, twin.situation.arm)[1])
        draw_targets(column[1], twin.situation, 0.0)
    figure.savefig(file, dpi=90)
