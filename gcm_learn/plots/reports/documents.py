"""The pictures of the README and the documents: ``python -m gcm_learn.plots FOLDER``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gcm_learn.arms import PLANAR, kind_of
from gcm_learn.families import draw, family_names, fig3, gate_scene
from gcm_learn.planners import Plan, solve
from gcm_learn.plots.figures import style, workspace
from gcm_learn.plots.figures.film import animate
from gcm_learn.plots.figures.hand_space import draw_hand_space
from gcm_learn.plots.figures.maps import draw_snapshot, plot_map
from gcm_learn.plots.figures.sheets import mapped, sheets_figure
from gcm_learn.plots.figures.stage import JointPictures
from gcm_learn.plots.reports.solid_documents import save_light, write_solid_gallery
from gcm_learn.scene import outline
from gcm_learn.situation import Situation

INSTANTS = (80.0, 160.0, 240.0)  # [tau] of the wave's snapshots; the contact follows
SHOWN = 0.35  # [s] instant at which hand-space is shown
COURSE = 0.45  # [s] length of the arrows
DPI, DPI_FAMILIES, DPI_CHAINS = (
    150,
    110,
    90,
)  # for screens with small pixels; the README tells the width
WORD = "#b7791f"  # darker than what it names, to be readable
MOST = 200  # draws that are looked through for one worth showing
GHOSTS = 4  # instants at which the bodies are drawn, the last one being the catch
PIXELS = 330  # a side of a panel before a camera
SEEN = 0.05  # [forearms] smallest target that is shown
KEY = ("arm", "obstacle", "target", "path of the hand")


def write_gallery(folder: Path) -> list[Path]:
    """Draw the README's pictures and two of the families.

    The first five show one situation, pictures of a spatial arm show another.

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
    sheets_figure(gate, mapped(gate, solve(gate, "layered"))).savefig(out[-1], dpi=DPI)
    out.append(folder / "families.png")
    families_figure().savefig(out[-1], dpi=DPI_FAMILIES)
    out.append(folder / "families-chain.png")
    save_light(chains_figure(), out[-1], DPI_CHAINS)
    return out + write_solid_gallery(folder)


def _situation(situation: Situation) -> Figure:
    figure = style.new_figure(4.0, 4.0)
    ax = workspace.draw_workspace(figure.subplots(), situation)
    workspace.draw_courses(ax, situation, COURSE)
    style.label(ax, (-0.02, -0.2), "shoulder")
    style.label(ax, (1.3, 0.95), "arm", style.ARM)
    style.label(ax, (-1.1, 0.35), "obstacle", style.OBSTACLE)
    style.label(ax, (1.2, -0.3), "obstacle", style.OBSTACLE)
    style.label(ax, (1.2, -1.25), "target", style.TARGET)
    return figure


def _hand_space(situation: Situation) -> Figure:
    figure = style.new_figure(8.0, 4.2)
    left, right = figure.subplots(1, 2)
    workspace.draw_workspace(left, situation, SHOWN)
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
    if plan.map is None or plan.map.interception_tau is None or plan.trajectory is None:
        raise RuntimeError(f"no catch to show: {plan.message}")
    for ax, tau in zip(panels, INSTANTS, strict=False):
        draw_snapshot(ax, situation, plan.map, tau)
    draw_snapshot(panels[-1], situation, plan.map, plan.map.interception_tau, plan.trajectory.hand)
    style.title(panels[-1], f"τ = {plan.map.interception_tau:.0f}: contact")
    style.label(panels[0], (0.25, 0.95), "front", style.FRONT)
    style.label(panels[1], (1.25, 0.68), "frozen", style.EFFECTIVE)
    return figure


def _map(situation: Situation, plan: Plan) -> Figure:
    if plan.map is None or plan.trajectory is None:
        raise RuntimeError(f"no map to show: {plan.message}")
    figure = style.new_figure(4.9, 4.0)
    ax = plot_map(plan.map, figure.subplots(), np.asarray(plan.trajectory.hand), colour_bar=True)
    workspace.draw_targets(ax, situation, plan.catch_time)
    style.label(ax, (-1.15, 1.35), "effective\nobstacle", style.EFFECTIVE)
    style.label(ax, (0.62, 0.55), "path", style.PATH)
    style.label(ax, (1.2, -1.25), "target", style.TARGET)
    return figure


def shown_families() -> list[str]:
    """Families that get a panel: all but the siblings in space, which look alike in the plane."""
    names = family_names("planar")
    return [n for n in names if n.removesuffix("-solid") not in names or not n.endswith("-solid")]


def families_figure(seed: int = 0, columns: int = 4) -> Figure:
    """Draw one situation of every family, with the movement that catches.

    Parameters
    ----------
    seed : int
        Root of the random situations of the first family; the next one has the next seed.
    columns : int
        Panels in a row.

    Returns
    -------
    Figure
        Of each family the first situation in which the straight line fails and waiting or a
        detour helps; bodies at instants up to the catch, the later the darker.
    """
    names = shown_families()
    figure, (*panels, last) = style.panel_grid(len(names) + 1, columns, (2.6, 2.75))
    for k, (ax, name) in enumerate(zip(panels, names, strict=True)):
        draw_case(ax, *first_case(name, seed + k))  # under one seed all would have the same arm
        style.title(ax, name)
    style.key(last, [entry for entry in style.KEY if entry[1] in KEY])
    return figure


def chains_figure(seed: int = 100, columns: int = 4) -> Figure:
    """Draw one situation of every family for chains, with the movement that catches.

    Parameters
    ----------
    seed, columns
        As of `families_figure`.
    """
    names = family_names("chain")
    figure, panels = style.panel_grid(len(names), columns, (3.0, 2.6))
    for k, (ax, name) in enumerate(zip(panels, names, strict=True)):
        JointPictures(*first_case(name, seed + k, "search")).draw_movement(ax, PIXELS)
        style.title(ax, name)
    return figure


def first_case(name: str, seed: int, planner: str = "layered") -> tuple[Any, Plan]:
    """Return the first situation of a family that is caught, not on the straight line, and seen."""
    for k in range(MOST):
        situation: Any = draw(name, seed, k)
        if solve(situation, "straight").caught:
            continue
        plan = solve(situation, planner)
        if plan.caught and (kind_of(situation) != PLANAR or _is_seen(situation, plan)):
            return situation, plan
    raise RuntimeError(f"nothing to show among {MOST} situations of {name}")


def _is_seen(situation: Any, plan: Plan) -> bool:
    """Return whether the arm plane's cut of the target at the catch is large enough to be seen."""
    seen = outline(situation, 0, plan.catch_time or 0.0)
    return seen is not None and bool(np.ptp(seen, axis=0).min() > SEEN)


def draw_case(ax: Axes, situation: Situation, plan: Plan) -> Axes:
    """Draw a situation with the paths of its bodies and of the hand up to the catch."""
    if plan.trajectory is None or plan.catch_time is None:
        raise ValueError(f"no catch to show: {plan.message}")
    style.frame(ax, situation.arm.upper_arm)
    for t in np.linspace(0.0, plan.catch_time, GHOSTS):
        workspace.draw_bodies(ax, situation, t, alpha=0.15 + 0.7 * t / max(plan.catch_time, 1e-9))
    workspace.draw_courses(ax, situation, plan.catch_time)
    workspace.draw_arm(ax, situation.arm, situation.arm.hand)
    style.draw_path(ax, np.asarray(plan.trajectory.hand), heads=2)
    return ax
