"""Sheets of arrivals, of maps in which the hand may wait, and maps of engines side by side."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure

from gcm_learn.maps import build_map
from gcm_learn.plots.figures import style
from gcm_learn.plots.figures.hand_space import show_image
from gcm_learn.plots.figures.maps import draw_colour_bar, plot_plan
from gcm_learn.plots.figures.style import Panel
from gcm_learn.plots.figures.workspace import draw_movement
from gcm_learn.situation import Situation
from gcm_learn.wave import MarchingParams

if TYPE_CHECKING:
    from gcm_learn.maps import CognitiveMap
    from gcm_learn.planners import Plan

STRIP = 3.2  # [inches] of panels in one row
MOST_SHEETS = 4
TITLES = (
    "sheet 1: first arrival",
    "sheet 2: free again, second arrival",
    "sheet 3: free again, third arrival",
    "sheet 4: free again, fourth arrival",
)
EARLIER = "#e2e8f0"  # cells of earlier sheets


def mapped(situation: Situation, plan: Plan) -> Plan:
    """Return the plan, with a map in which the hand may wait if the plan has no map."""
    if plan.map is not None:
        return plan
    return replace(plan, map=build_map(situation, MarchingParams(), wait=True))


def sheets_figure(situation: Situation, plan: Plan) -> Figure:
    """Draw a movement with its waits, and beside it the sheets of the plan's map.

    Parameters
    ----------
    situation : Situation
    plan : Plan
        Where it has no map, the movement stands alone.

    Returns
    -------
    Figure
    """
    sheets = [] if plan.map is None else sheet_panels(situation, plan)
    count = 1 + len(sheets)
    figure, panels = style.panel_grid(count, count, (STRIP, STRIP), (0.6, 0.35))
    draw_movement(panels[0], situation, plan)
    style.title(panels[0], "work-space: movement")
    style.fill_panels(panels[1:], sheets)
    if plan.map is not None and plan.map.sheets.count():
        draw_colour_bar(panels, float(plan.map.sheets.max() / plan.map.kappa))
    return figure


def sheet_of(cognitive_map: CognitiveMap, k: int) -> CognitiveMap:
    """Return sheet k, counted from 0, as a separate map.

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
    """Return the sheet of a hand in a cell at time t [s]; -1 if the hand cannot be there then."""
    arrivals = cognitive_map.sheets[:, cell[0], cell[1]].filled(np.inf)
    return int((arrivals <= t).sum()) - 1


def sheet_panels(situation: Situation, plan: Plan) -> list[Panel]:
    """Return panels of the sheets of a plan's map, in one colour scale, with path and waits.

    Parameters
    ----------
    situation : Situation
    plan : Plan
        With a map.
    """
    assert plan.map is not None
    count, hidden = len(plan.map.sheets), len(plan.map.sheets) - MOST_SHEETS
    titles = list(TITLES[:count])
    if hidden > 0:
        titles[-1] += f"\n({hidden} more not shown)"
    return [
        (title, lambda ax, k=k: _draw_sheet(ax, situation, plan, k))  # type: ignore[misc]
        for k, title in enumerate(titles)
    ]


def _draw_sheet(ax: Axes, situation: Situation, plan: Plan, k: int) -> None:
    assert plan.map is not None
    sheets = plan.map.sheets
    latest = float(sheets.max() / plan.map.kappa) if sheets.count() else 0.0
    plot_plan(ax, situation, plan, sheet_of(plan.map, k), latest=latest, waits=k == 0)
    if k > 0:  # shade the cells that have an earlier arrival only
        there = ~np.ma.getmaskarray(plan.map.arrival)
        show_image(ax, there[..., None] * np.array(to_rgba(EARLIER)), situation.arm, zorder=0.5)
