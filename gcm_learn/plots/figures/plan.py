"""Pictures of one plan: the movement, and the sheets of the map that it was read from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure

from gcm_learn.handspace import SpaceLattice
from gcm_learn.maps import build_map
from gcm_learn.motion import Trajectory
from gcm_learn.plots.figures import style
from gcm_learn.plots.figures.handspace import draw_hand_space, show_image
from gcm_learn.plots.figures.maps import draw_colour_bar, latest_arrival, plot_plan
from gcm_learn.plots.figures.solid_scene import draw_scene
from gcm_learn.plots.figures.space import (
    draw_courses_in_space,
    draw_movement_in_space,
    draw_space,
    key_in_space,
    time_bar,
)
from gcm_learn.plots.figures.space_maps import HandSpace
from gcm_learn.plots.figures.workspace import draw_courses, draw_movement, draw_waits, notable_waits
from gcm_learn.rendering import SpatialSituation, from_above, view_of
from gcm_learn.situation import AnySituation, Situation
from gcm_learn.wave import MarchingParams

if TYPE_CHECKING:
    from gcm_learn.maps import CognitiveMap
    from gcm_learn.motion import SpatialTrajectory
    from gcm_learn.planners import AnyPlan, Plan

    SpatialPlan = Plan[SpatialTrajectory]

PANEL, STRIP = 4.0, 3.2  # [inches] of `plan_figure`, and where panels stand in one row
IN_SPACE = 4.6  # [inches] of a panel in space
SIDES = ("work-space", "from above")
ABREAST = 4  # panels in one row; more are set in rows of three
MOST_SHEETS = 4
TITLES = (
    "sheet 1: first arrival",
    "sheet 2: free again, second arrival",
    "sheet 3: free again, third arrival",
    "sheet 4: free again, fourth arrival",
)
EARLIER = "#e2e8f0"  # cells of earlier sheets


def plan_figure(situation: AnySituation, plan: AnyPlan) -> Figure:
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
        the map.  In space two panels: the movement from the side and from above; and the map.
    """
    if situation.is_spatial:
        return _plan_in_space(cast("SpatialSituation", situation), cast("SpatialPlan", plan))
    return _plan_in_the_plane(cast("Situation", situation), cast("Plan", plan))


def _plan_in_space(situation: SpatialSituation, plan: SpatialPlan) -> Figure:
    charted = plan.map is not None and isinstance(plan.map.chart, SpaceLattice)
    figure, panels = style.panel_grid(2 + charted, 2 + charted, (IN_SPACE, IN_SPACE), (0.0, 0.8))
    figure.suptitle(_headline(plan), fontsize=style.TITLE, color=style.INK)
    level = view_of(situation, plan.trajectory)
    if plan.map is not None and charted:
        HandSpace(situation, plan.map, plan.trajectory, level).show_map(panels[2])
        style.title(panels[2], "hand-space: cognitive map, cut open")
    for ax, view, name in zip(panels[:2], (level, from_above(level)), SIDES, strict=True):
        if plan.trajectory is None:
            draw_space(ax, situation, view=view)
            draw_courses_in_space(ax, situation, situation.horizon, view)
        else:
            draw_movement_in_space(ax, situation, plan.trajectory, view)
            time_bar(ax, plan.trajectory.duration)
        style.title(ax, name if plan.trajectory is not None else f"{name}: start")
    key_in_space(figure)
    return figure


def _plan_in_the_plane(situation: Situation, plan: Plan) -> Figure:
    count = 1 + situation.is_solid + (1 if plan.map is None else shown_sheets(plan.map))
    columns = count if count <= ABREAST else 3
    figure, panels = style.panel_grid(count, columns, (PANEL, PANEL), (0.0, 0.6))
    figure.suptitle(_headline(plan), fontsize=style.TITLE, color=style.INK)
    if situation.is_solid:
        _draw_solid(panels.pop(0), situation, plan)
    draw_movement(panels[0], situation, plan)
    if plan.trajectory is None:
        draw_courses(panels[0], situation, situation.horizon)
        style.title(panels[0], "work-space: start")
    else:
        style.title(panels[0], "work-space: movement (later is darker)")
    _draw_map_or_handspace(panels[1:], situation, plan)
    return figure


def _headline(plan: AnyPlan) -> str:
    if plan.catch_time is None:
        return f"{plan.name} · {plan.planner}: {plan.status.replace('_', ' ')}\n{plan.message}"
    when = f"caught {plan.catch_body!r} after {plan.catch_time:.3f} s"
    if plan.map is not None:
        when += f" = {plan.catch_time / plan.map.kappa:.0f} τ"
    moves = plan.trajectory
    waits = notable_waits(moves) if isinstance(moves, Trajectory) else []
    if waits:
        when += f", {sum(wait.duration for wait in waits):.2f} s of it waiting"
    known = plan.clearance is not None and np.isfinite(plan.clearance)
    space = f", clearance {plan.clearance:.3f}" if known else ""
    return f"{plan.name} · {plan.planner}: {when}{space}, planned in {plan.planning_ms:.1f} ms"


def _draw_solid(ax: Axes, situation: Situation, plan: Plan) -> None:
    t = 0.0 if plan.catch_time is None else plan.catch_time
    hand = None if plan.trajectory is None else plan.trajectory.hand[-1]
    draw_scene(ax, situation, t, hand=hand)
    style.title(ax, "at the start" if plan.catch_time is None else "at the catch")


def _draw_map_or_handspace(panels: Sequence[Axes], situation: Situation, plan: Plan) -> None:
    """Draw the map, all its sheets; without one, hand-space as it is when the movement ends.

    Planners of straight lines make no map, and `layered` rarely; `mapped` adds one.
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


def mapped(situation: Situation, plan: Plan) -> Plan:
    """Return the plan with the map of a hand that may wait, where it was made without one."""
    if plan.map is not None:
        return plan
    return replace(plan, map=build_map(situation, MarchingParams(), wait=True))


def sheets_figure(situation: Situation, plan: Plan) -> Figure:
    """Draw a movement with its waits, and beside it the sheets of the map that it came from.

    Parameters
    ----------
    situation : Situation
    plan : Plan
        Where it has no map, the movement stands alone.

    Returns
    -------
    Figure
    """
    count = 1 + (0 if plan.map is None else shown_sheets(plan.map))
    figure, panels = style.panel_grid(count, count, (STRIP, STRIP), (0.6, 0.35))
    draw_movement(panels[0], situation, plan)
    style.title(panels[0], "work-space: movement")
    if plan.map is not None:
        draw_sheets(panels[1:], situation, plan)
        if plan.map.sheets.count():
            draw_colour_bar(panels, float(plan.map.sheets.max() / plan.map.kappa))
    return figure


def shown_sheets(cognitive_map: CognitiveMap) -> int:
    """Return how many sheets are drawn of a map."""
    return min(len(cognitive_map.sheets), MOST_SHEETS)


def sheet_of(cognitive_map: CognitiveMap, k: int) -> CognitiveMap:
    """Return sheet k, counted from 0, as a map of its own.

    Walls are the cells out of the hand's reach; the target is on the sheet of the interception.
    """
    first, sheet = cognitive_map.arrival, cognitive_map.sheets[k]
    met, here = cognitive_map.interception, False
    if met is not None:
        here = _sheet_at(cognitive_map, met.cell, met.time) == k
    nothing = np.zeros_like(cognitive_map.effective_target)
    return replace(
        cognitive_map,
        arrival=sheet,
        effective_obstacles=cognitive_map.effective_obstacles & np.ma.getmaskarray(first),
        effective_target=cognitive_map.effective_target if here else nothing,
        later=None,
    )


def _sheet_at(cognitive_map: CognitiveMap, cell: tuple[int, ...], t: float) -> int:
    """Return the sheet on which a hand in a cell is at time t [s]; -1 if it cannot be there."""
    arrivals = cognitive_map.sheets[:, cell[0], cell[1]].filled(np.inf)
    return int((arrivals <= t).sum()) - 1


def draw_sheets(panels: Sequence[Axes], situation: Situation, plan: Plan) -> None:
    """Draw the sheets of a plan's map in one scale of colours, with the path and its waits.

    Parameters
    ----------
    panels : sequence of Axes
        As many as `shown_sheets` says, at most.
    situation : Situation
    plan : Plan
        With a map.
    """
    assert plan.map is not None
    sheets = plan.map.sheets
    latest = float(sheets.max() / plan.map.kappa) if sheets.count() else 0.0
    for k, ax in enumerate(panels):
        plot_plan(ax, situation, plan, sheet_of(plan.map, k), latest=latest, waits=k == 0)
        if k > 0:  # shade the cells that have an earlier arrival only
            there = ~np.ma.getmaskarray(plan.map.arrival)
            show_image(ax, there[..., None] * np.array(to_rgba(EARLIER)), situation.arm, zorder=0.5)
        style.title(ax, TITLES[k])
    hidden = len(sheets) - len(panels)
    if hidden > 0:
        style.title(panels[-1], f"{TITLES[len(panels) - 1]}\n({hidden} more not shown)")


def engines_figure(situation: Situation, plans: Mapping[str, Plan]) -> Figure:
    """Draw the maps of several engines side by side.

    Parameters
    ----------
    situation : Situation
    plans : mapping of str to Plan
        By planner; those without a map leave their panel empty.

    Returns
    -------
    Figure
    """
    figure, panels = style.panel_grid(len(plans), len(plans), (3.0, 3.5), (0.6, 0.0))
    latest = max((latest_arrival(p.map) for p in plans.values() if p.map is not None), default=0.0)
    for ax, (name, plan) in zip(panels, plans.items(), strict=True):
        if plan.map is None:
            ax.axis("off")
        else:
            plot_plan(ax, situation, plan, latest=latest)
        style.title(ax, f"{name}: {plan.status.replace('_', ' ')}")
    if latest > 0.0:
        draw_colour_bar(panels, latest)
    return figure
