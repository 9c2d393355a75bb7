"""Tables and pictures of covers, from results.json; the cells are grown anew for their picture."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.patches import Rectangle

from gcm_learn.arms import elbow_position
from gcm_learn.cover import Budget, Cover, grow, parametric_family
from gcm_learn.evaluation import Table
from gcm_learn.plots import draw_bodies, style
from gcm_learn.processes import Here
from gcm_learn.storage import write_whole

HERE = Path(__file__).resolve().parent
FREE = (2, 3, 4, 5)
TITLES = {"belt": "planar arm", "belt-space": "spatial arm", "belt-chain": "Panda"}  # of the curve
COLOURS = dict(zip(FREE, (style.GOOD, style.FRONT, style.EXTENDED, style.EFFECTIVE), strict=True))


def results(folder: Path) -> dict[str, str]:
    """Return the tables of the results."""
    found = json.loads((folder / "results.json").read_text("utf-8"))
    parts = ["## Growth", growth(found["growth"])]
    parts += ["## Draws from proven cells, 3 parameters", drawn(found)]
    parts += ["## Time of an answer", times(found.get("times", {}))]
    return {"table.md": "\n\n".join(parts) + "\n"}


def growth(rows: dict[str, Any]) -> str:
    """Return what was covered, with how many catches."""
    head = ["family", "free", "covered [%]", "catches", "cells examined", "time [s]", "not covered"]
    made = []
    for name, row in rows.items():
        family, free = name.rsplit("-", 1)
        missing = ", ".join(f"{reason} {100 * x:.1f} %" for reason, x in row["missing"].items())
        made.append(
            [family, free, f"{100 * row['share']:.1f}", row["catches"], row["cells"],
             row["seconds"], missing or "-"]
        )  # fmt: skip
    return str(Table(head, made))


def drawn(found: dict[str, Any]) -> str:
    """Return how many draws were checked by whom, and how many broke a promise."""
    rows = [
        [family, judge, row["draws"], row["broken"]]
        for judge, part in (
            ("verify", "verified"),
            ("verify, in corners", "corners"),
            ("referee", "judged"),
        )
        for family, row in found.get(part, {}).items()
    ]
    return str(Table(["family", "checked by", "draws", "broken"], rows))


def times(rows: dict[str, Any]) -> str:
    """Return how long answers took."""
    head = [
        "cover", "answers", "processor time, median / 99 % / 99.9 % [ms]", "within 0.2 ms [%]",
        "time on the wall, the same [ms]",
    ]  # fmt: skip
    made = [
        [name, row["answers"], _three(row["ms"]), f"{100 * row['within_0.2_ms']:.2f}",
         _three(row["wall_ms"])]
        for name, row in rows.items()
    ]  # fmt: skip
    return str(Table(head, made))


def _three(values: dict[str, float]) -> str:
    return " / ".join(f"{value:.3f}" for value in values.values())


def draw_cells(path: Path) -> None:
    """Draw the cells of two parameters, and the movements that are stored for them."""
    family = parametric_family("belt").free(2)
    cover = Cover(family)
    grow(cover, Budget(1.0, cells=400), Here())
    number = {index: k for k, index in enumerate(sorted(cover.used))}
    palette = colormaps["tab20"].colors  # type: ignore[attr-defined]
    figure = style.new_figure(9.6, 4.4)
    plane, box = figure.subplots(1, 2)
    for cell in cover.leaves():
        if cell.held >= 0:
            _cell(box, cell.low, cell.high, palette[number[cell.held] % 20], number[cell.held] + 1)
    _parameters(box, family)
    style.frame(plane)
    plane.set(xlim=(-1.6, 1.6), ylim=(-1.0, 1.6))
    situation = family.situation(family.centre)
    draw_bodies(plane, situation, 0.0, alpha=0.5)
    hand = np.array(situation.arm.hand)
    limb = np.stack([np.zeros(2), elbow_position(hand), hand])
    plane.plot(*limb.T, color=style.ARM, lw=5.0, solid_capstyle="round", alpha=0.6)
    for index, k in number.items():
        catch = cover.catches[index]
        plane.plot(*catch.way.T, color=palette[k % 20], lw=1.6)
    for body in situation.bodies:
        x, y = body.motion.position
        style.label(plane, (x, y + 0.17), body.name)
        if body.motion.velocity[0]:
            end = (x + 0.35 * body.motion.velocity[0], y)
            plane.annotate("", end, (x, y), arrowprops={"arrowstyle": "->", "color": style.INK})
    style.title(plane, "arm and bodies at t = 0, stored movements of the hand")
    figure.savefig(path, dpi=90)


def _cell(ax: Axes, low: np.ndarray, high: np.ndarray, colour: Any, number: int) -> None:
    ax.add_patch(Rectangle(low, *(high - low), fc=colour, ec="white", lw=1.0, alpha=0.75))
    ax.text(*(0.5 * (low + high)), str(number), ha="center", va="center", fontsize=style.SMALL)


def _parameters(ax: Axes, family: Any) -> None:
    """Set up the box of two parameters."""
    first, second = family.parameters
    ax.set(xlim=(first.low, first.high), ylim=(second.low, second.high))
    ax.set_xlabel(f"{first.name}: place along the belt [{first.unit}]", fontsize=style.LABEL)
    ax.set_ylabel(f"{second.name}: place across it [{second.unit}]", fontsize=style.LABEL)
    style.plain(ax)
    style.title(ax, "proven cells, each with the number of its movement")


def draw_curve(path: Path, rows: dict[str, Any]) -> None:
    """Draw how many catches are stored for how much of the box."""
    families = [name for name in TITLES if any(row.rsplit("-", 1)[0] == name for row in rows)]
    figure = style.new_figure(3.4 * len(families), 3.4)
    axes = figure.subplots(1, len(families), sharey=True, squeeze=False)[0]
    for ax, family in zip(axes, families, strict=True):
        for free in FREE:
            row = rows.get(f"{family}-{free}")
            if row is None:
                continue
            curve = np.array([[100.0 * c[2], c[1]] for c in row["curve"] if c[1] > 0])
            look: dict[str, Any] = {"color": COLOURS[free], "lw": 1.8}
            if curve.size:
                ax.plot(*curve.T, **look)
                ax.plot(*curve[-1], "o", ms=4, color=COLOURS[free])
            ax.plot([], [], label=f"{free} parameters", **look)
        ax.axvline(95.0, color=style.FAINT, lw=1.0, ls=(0, (4, 3)))
        ax.set(xlim=(0.0, 102.0), yscale="log")
        ax.set_xlabel("box covered [%]", fontsize=style.LABEL)
        style.plain(ax)
        style.title(ax, TITLES[family])
    axes[0].set_ylabel("stored catches", fontsize=style.LABEL)
    axes[-1].legend(fontsize=style.SMALL, frameon=False, loc="lower right")
    figure.savefig(path, dpi=90)


def write() -> None:
    """Write table and pictures."""
    for name, text in results(HERE).items():
        write_whole(HERE / name, text)
    rows = json.loads((HERE / "results.json").read_text("utf-8"))["growth"]
    draw_cells(HERE / "cells.png")
    draw_curve(HERE / "curve.png", rows)
