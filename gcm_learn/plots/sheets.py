"""Maps in which the hand may wait: their sheets, side by side."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.figure import Figure

from gcm_learn.plots import style
from gcm_learn.plots.handspace import show_image
from gcm_learn.plots.maps import draw_colour_bar, plot_map
from gcm_learn.plots.poses import draw_poses
from gcm_learn.plots.waits import draw_waits
from gcm_learn.plots.workspace import draw_targets, draw_workspace
from gcm_learn.situation import Arm, Situation

if TYPE_CHECKING:
    from gcm_learn.maps.cognitive_map import CognitiveMap
    from gcm_learn.planners.plan import Plan

MOST_SHEETS = 4
PANEL = 3.2  # [inches]
TITLES = (
    "sheet 1: first arrival",
    "sheet 2: free again, second arrival",
    "sheet 3: free again, third arrival",
    "sheet 4: free again, fourth arrival",
)
EARLIER = "#e2e8f0"  # cells of earlier sheets


def shown_sheets(cognitive_map: CognitiveMap) -> int:
    """Return how many sheets are drawn of a map."""
    return min(len(cognitive_map.sheets), MOST_SHEETS)


def sheet_of(cognitive_map: CognitiveMap, k: int) -> CognitiveMap:
    """Return sheet k, counted from 0, as a map of its own.

    Walls are the cells that the hand can never be in; the target is on the sheet on which it is
    met.
    """
    first, sheet = cognitive_map.arrival, cognitive_map.sheets[k]
    contact, here = cognitive_map.contact, False
    if contact is not None:
        here = _sheet_at(cognitive_map, contact.cell, contact.time) == k
    nothing = np.zeros_like(cognitive_map.effective_target)
    return replace(
        cognitive_map,
        arrival=sheet,
        effective_obstacles=cognitive_map.effective_obstacles & np.ma.getmaskarray(first),
        effective_target=cognitive_map.effective_target if here else nothing,
        later=None,
    )


def _sheet_at(cognitive_map: CognitiveMap, cell: tuple[int, int], t: float) -> int:
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
    latest = float(plan.map.sheets.max() / plan.map.kappa) if plan.map.sheets.count() else 0.0
    for k, ax in enumerate(panels):
        path = None if plan.trajectory is None else plan.trajectory.hand
        plot_map(sheet_of(plan.map, k), ax, path, latest=latest)
        if k > 0:
            _draw_earlier(ax, plan.map, k, situation.arm)
        draw_targets(ax, situation, plan.catch_time)
        if plan.trajectory is not None:
            draw_waits(ax, plan.trajectory, labels=k == 0)
        style.title(ax, TITLES[k])
    hidden = len(plan.map.sheets) - len(panels)
    if hidden > 0:
        style.title(panels[-1], f"{TITLES[len(panels) - 1]}\n({hidden} more not shown)")


def _draw_earlier(ax: Axes, cognitive_map: CognitiveMap, k: int, arm: Arm) -> None:
    """Shade the cells that have an earlier arrival only."""
    there = ~np.ma.getmaskarray(cognitive_map.arrival)
    image = there[..., None] * np.array(to_rgba(EARLIER))
    show_image(ax, image, arm, zorder=0.5)


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
    figure = style.new_figure(PANEL * count + 0.6, PANEL + 0.35)
    left, *panels = figure.subplots(1, count, squeeze=False)[0]
    if plan.trajectory is None:
        draw_workspace(left, situation)
    else:
        draw_poses(left, situation, plan.trajectory)
    style.title(left, "work-space: movement")
    if plan.map is not None:
        draw_sheets(panels, situation, plan)
        if plan.map.sheets.count():
            draw_colour_bar([left, *panels], float(plan.map.sheets.max() / plan.map.kappa))
    return figure
