"""One picture of a situation and its plan."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gcm_learn.plots import style
from gcm_learn.plots.handspace import draw_hand_space
from gcm_learn.plots.maps import plot_map
from gcm_learn.plots.poses import draw_poses
from gcm_learn.plots.scene3d import HEADROOM, draw_scene
from gcm_learn.plots.workspace import draw_courses, draw_targets, draw_workspace
from gcm_learn.situation import Situation

if TYPE_CHECKING:
    from gcm_learn.planners.plan import Plan

PANEL = 4.0  # [inches]


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
        Two panels, three when the situation is 3D.
    """
    count = 3 if situation.is_solid else 2
    figure = style.new_figure(PANEL * count, PANEL + 0.6)
    panels = list(figure.subplots(1, count))
    figure.suptitle(_headline(plan), fontsize=style.TITLE, color=style.INK)
    if situation.is_solid:
        _draw_solid(panels.pop(0), situation, plan)
    _draw_movement(panels[0], situation, plan)
    _draw_thought(panels[1], situation, plan)
    return figure


def _headline(plan: Plan) -> str:
    if plan.catch_time is None:
        return f"{plan.name} · {plan.planner}: {plan.status.replace('_', ' ')}\n{plan.message}"
    when = f"caught {plan.catch_body!r} after {plan.catch_time:.3f} s"
    if plan.map is not None:
        when += f" = {plan.catch_time / plan.map.kappa:.0f} τ"
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


def _draw_thought(ax: Axes, situation: Situation, plan: Plan) -> None:
    path = None if plan.trajectory is None else np.asarray(plan.trajectory.hand)
    if plan.map is not None:
        plot_map(plan.map, ax, path)
        draw_targets(ax, situation, plan.catch_time)
        style.title(ax, "hand-space: cognitive map")
        return
    draw_hand_space(ax, situation, plan.catch_time or 0.0)
    if path is not None:
        style.draw_path(ax, path)
    style.title(ax, "hand-space: extended obstacles")
