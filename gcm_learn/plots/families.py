"""One situation of every family: ``python -m gcm_learn.plots.families PICTURE``."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gcm_learn.families import draw, family_names
from gcm_learn.planners import Plan, solve
from gcm_learn.plots import style
from gcm_learn.plots.workspace import draw_arm, draw_bodies, draw_courses
from gcm_learn.scene.outlines import outline
from gcm_learn.situation import Situation

MOST = 200  # draws that are looked through for one worth showing
GHOSTS = 4  # instants at which the bodies are drawn, the last one being the catch
DPI = 110
SEEN = 0.05  # [forearms] smallest target that is shown
KEY = ("arm", "obstacle", "target", "path of the hand")


def shown_families() -> list[str]:
    """Families that get a panel: all but the siblings in space, which look alike in the plane."""
    names = family_names()
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
    rows = -(-(len(names) + 1) // columns)
    figure = style.new_figure(2.6 * columns, 2.75 * rows)
    panels = figure.subplots(rows, columns).ravel()
    for k, (ax, name) in enumerate(zip(panels, names, strict=False)):
        draw_case(ax, *first_case(name, seed + k))  # under one seed all would have the same arm
        style.title(ax, name)
    for ax in panels[len(names) :]:
        ax.axis("off")
    style.key(panels[-1], [entry for entry in style.KEY if entry[1] in KEY])
    return figure


def first_case(name: str, seed: int) -> tuple[Situation, Plan]:
    """The first situation of a family that is caught, but not on the straight line, and seen."""
    for k in range(MOST):
        situation = draw(name, seed, k)
        if solve(situation, "straight").caught:
            continue
        plan = solve(situation, "layered")
        if plan.catch_time is None:
            continue
        seen = outline(situation, 0, plan.catch_time)  # the plane may hardly touch a solid then
        if seen is not None and np.ptp(seen, axis=0).min() > SEEN:
            return situation, plan
    raise RuntimeError(f"nothing to show among {MOST} situations of {name}")


def draw_case(ax: Axes, situation: Situation, plan: Plan) -> Axes:
    """Draw a situation, where its bodies go and how the hand catches."""
    if plan.trajectory is None or plan.catch_time is None:
        raise ValueError(f"no catch to show: {plan.message}")
    style.frame(ax, situation.arm.upper_arm)
    for t in np.linspace(0.0, plan.catch_time, GHOSTS):
        draw_bodies(ax, situation, t, alpha=0.15 + 0.7 * t / max(plan.catch_time, 1e-9))
    draw_courses(ax, situation, plan.catch_time)
    draw_arm(ax, situation.arm, situation.arm.hand)
    style.draw_path(ax, np.asarray(plan.trajectory.hand), heads=2)
    return ax


if __name__ == "__main__":
    target = Path(sys.argv[1])
    families_figure().savefig(target, dpi=DPI)
    print(target)
