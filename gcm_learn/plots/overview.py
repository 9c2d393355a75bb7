"""One picture of a situation and its plan."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gcm_learn.plots import style
from gcm_learn.plots.handspace import draw_hand_space
from gcm_learn.plots.poses import draw_poses
from gcm_learn.plots.scene3d import HEADROOM, draw_scene
from gcm_learn.plots.sheets import draw_sheets, shown_sheets
from gcm_learn.plots.waits import draw_waits, notable_waits
from gcm_learn.plots.workspace import draw_courses, draw_workspace
from gcm_learn.situation import Situation

if TYPE_CHECKING:
    from gcm_learn.planners.plan import Plan

PANEL = 4.0  # [inches]
ABREAST = 4  # panels in one row; more are set in rows of three


def plan_figure(situation: Situation, plan: Plan) -> Figure:
    """Draw the movement in the work-space and the map it was read from.

    Parameters
    ----------
    situation : Situation
    plan : Plan
        Of this situation, whatever its status.

    Returns
    -------
    Figure
        Two panels, one more when the situation is 3D, and one more for every further sheet of
        the map.
    """
    count = 1 + situation.is_solid + (1 if plan.map is None else shown_sheets(plan.map))
    figure, panels = _panels(count)
    figure.suptitle(_headline(plan), fontsize=style.TITLE, color=style.INK)
    if situation.is_solid:
        _draw_solid(panels.pop(0), situation, plan)
    _draw_movement(panels[0], situation, plan)
    _draw_thought(panels[1:], situation, plan)
    return figure


def _panels(count: int) -> tuple[Figure, list[Axes]]:
    """Make a figure with so many panels, in one row or two."""
    columns = count if count <= ABREAST else 3
    rows = -(-count // columns)
    figure = style.new_figure(PANEL * columns, PANEL * rows + 0.6)
    grid = list(figure.subplots(rows, columns, squeeze=False).ravel())
    for ax in grid[count:]:
        ax.axis("off")
    return figure, grid[:count]


def _headline(plan: Plan) -> str:
    if plan.catch_time is None:
        return f"{plan.name} · {plan.planner}: {plan.status.replace('_', ' ')}\n{plan.message}"
    when = f"caught {plan.catch_body!r} after {plan.catch_time:.3f} s"
    if plan.map is not None:
        when += f" = {plan.catch_time / plan.map.kappa:.0f} τ"
    waits = [] if plan.trajectory is None else notable_waits(plan.trajectory)
    if waits:
        when += f", {sum(wait.duration for wait in waits):.2f} s of it waiting"
    known = plan.clearance is not None and np.isfinite(plan.clearance)
    space = f", clearance {plan.clearance:.3f}" if known else ""
    return f"{plan.name} · {plan.planner}: {when}{space}, planned in {plan.planning_ms:.1f} ms"


def _draw_solid(ax: Axes, situation: Situation, plan: Plan) -> None:
    t = 0.0 if plan.catch_time is None else plan.catch_time
    hand = None if plan.trajectory is None else plan.trajectory.hand[-1]
    draw_scene(ax, situation, t, hand=hand, headroom=HEADROOM)
    style.title(ax, "at the start" if plan.catch_time is None else "at the catch")


def _draw_movement(ax: Axes, situation: Situation, plan: Plan) -> None:
    if plan.trajectory is not None:
        draw_poses(ax, situation, plan.trajectory)
        style.title(ax, "work-space: movement (later is darker)")
        return
    draw_workspace(ax, situation)
    draw_courses(ax, situation, situation.horizon)
    style.title(ax, "work-space: start")


def _draw_thought(panels: Sequence[Axes], situation: Situation, plan: Plan) -> None:
    """Draw the map, all its sheets; without one, hand-space as it is when the movement ends.

    Planners of straight lines make no map, nor does `layered` where a straight line holds.
    """
    if plan.map is not None:
        draw_sheets(panels, situation, plan)
        if len(panels) == 1:
            style.title(panels[0], "hand-space: cognitive map")
        return
    ax = panels[0]
    draw_hand_space(ax, situation, plan.catch_time or 0.0)
    if plan.trajectory is not None:
        style.draw_path(ax, plan.trajectory.hand)
        draw_waits(ax, plan.trajectory)
    when = "start" if plan.catch_time is None else "catch"
    style.title(ax, f"hand-space at the {when} (no map was made)")
