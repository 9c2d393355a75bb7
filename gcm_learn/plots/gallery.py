"""The README's pictures: ``python -m gcm_learn.plots.gallery FOLDER``.

All but the last are of one situation.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from gcm_learn.families.examples import gate_scene
from gcm_learn.families.paper import fig3
from gcm_learn.planners import Plan, solve
from gcm_learn.plots import style
from gcm_learn.plots.animation import animate
from gcm_learn.plots.handspace import draw_hand_space
from gcm_learn.plots.maps import plot_map
from gcm_learn.plots.sheets import sheets_figure
from gcm_learn.plots.snapshots import draw_snapshot
from gcm_learn.plots.workspace import draw_courses, draw_targets, draw_workspace
from gcm_learn.situation import Situation

INSTANTS = (80.0, 160.0, 240.0)  # [tau] of the wave's snapshots; the contact follows
SHOWN = 0.35  # [s] instant at which hand-space is shown
COURSE = 0.45  # [s] length of the arrows
DPI = 150  # for screens with small pixels; the README tells the width
WORD = "#b7791f"  # darker than what it names, to be readable


def write_gallery(folder: Path) -> list[Path]:
    """Draw the pictures.

    Parameters
    ----------
    folder : Path
        Made when it is missing.

    Returns
    -------
    list of Path
        The files, in the order in which they tell the story.
    """
    folder.mkdir(parents=True, exist_ok=True)
    situation = fig3()
    plan = solve(situation, "gcm")
    out = []
    for name, figure in (
        ("situation", _situation(situation)),
        ("hand-space", _hand_space(situation)),
        ("wave", _wave(situation, plan)),
        ("map", _map(situation, plan)),
    ):
        out.append(folder / f"{name}.png")
        figure.savefig(out[-1], dpi=DPI)
    out.append(folder / "catch.gif")
    animate(situation, plan, out[-1])
    out.append(folder / "waiting.png")
    gate = gate_scene()
    sheets_figure(gate, solve(gate, "layered")).savefig(out[-1], dpi=DPI)
    return out


def _situation(situation: Situation) -> Figure:
    figure = style.new_figure(4.0, 4.0)
    ax = draw_workspace(figure.subplots(), situation)
    draw_courses(ax, situation, COURSE)
    style.label(ax, (-0.02, -0.2), "shoulder")
    style.label(ax, (1.3, 0.95), "arm", style.ARM)
    style.label(ax, (-1.1, 0.35), "obstacle", style.OBSTACLE)
    style.label(ax, (1.2, -0.3), "obstacle", style.OBSTACLE)
    style.label(ax, (1.2, -1.25), "target", style.TARGET)
    return figure


def _hand_space(situation: Situation) -> Figure:
    figure = style.new_figure(8.0, 4.2)
    left, right = figure.subplots(1, 2)
    draw_workspace(left, situation, SHOWN)
    style.title(left, "work-space: an arm among bodies")
    draw_hand_space(right, situation, SHOWN)
    style.title(right, "hand-space: a point among larger bodies")
    style.label(right, (1.0, 1.48), "arm")
    style.label(right, (-0.7, -0.35), "extended obstacle", WORD)
    style.label(right, (1.2, 1.05), "extended obstacle", WORD)
    return figure


def _wave(situation: Situation, plan: Plan) -> Figure:
    figure = style.new_figure(9.6, 2.75)
    panels = figure.subplots(1, len(INSTANTS) + 1)
    if plan.map is None or plan.map.contact_tau is None or plan.trajectory is None:
        raise RuntimeError(f"no catch to show: {plan.message}")
    for ax, tau in zip(panels, INSTANTS, strict=False):
        draw_snapshot(ax, situation, plan.map, tau)
    draw_snapshot(panels[-1], situation, plan.map, plan.map.contact_tau, plan.trajectory.hand)
    style.title(panels[-1], f"τ = {plan.map.contact_tau:.0f}: contact")
    style.label(panels[0], (0.25, 0.95), "front", style.FRONT)
    style.label(panels[1], (1.25, 0.68), "frozen", style.EFFECTIVE)
    return figure


def _map(situation: Situation, plan: Plan) -> Figure:
    if plan.map is None or plan.trajectory is None:
        raise RuntimeError(f"no map to show: {plan.message}")
    figure = style.new_figure(4.9, 4.0)
    ax = plot_map(plan.map, figure.subplots(), np.asarray(plan.trajectory.hand), colour_bar=True)
    draw_targets(ax, situation, plan.catch_time)
    style.label(ax, (-1.15, 1.35), "effective\nobstacle", style.EFFECTIVE)
    style.label(ax, (0.62, 0.55), "path", style.PATH)
    style.label(ax, (1.2, -1.25), "target", style.TARGET)
    return figure


if __name__ == "__main__":
    for path in write_gallery(Path(sys.argv[1])):
        print(path)
