"""Figures of one plan with the map that its path was read from, and of one missed catch."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from gcm_learn.plots.figures import style
from gcm_learn.plots.figures.kinds import DRAWN, pictures_of
from gcm_learn.situation import AnySituation

if TYPE_CHECKING:
    from gcm_learn.planners import Plan

ABREAST = 4  # panels in one row; more are set in rows of three
PANEL = 480  # of a picture before a camera [pixels]
SIZE = (3.6, 3.8)  # [inches]
WORDS = {"broken": "breaks its promise", "error": "fails"}


def plan_figure(situation: AnySituation, plan: Plan) -> Figure:
    """Draw the movement in the work-space and the map that its path was read from.

    Parameters
    ----------
    situation : Situation
    plan : Plan
        Of this situation, whatever its status.

    Returns
    -------
    Figure
        Of a planar arm two panels, one more when the situation is 3D, and one more for every
        further sheet of the map.  Of other arms the movement from the side and from above, and
        the map where there is one.
    """
    pictures = pictures_of(situation, plan)
    panels = pictures.panels()
    columns = len(panels) if len(panels) <= ABREAST else 3
    size = (pictures.panel, pictures.panel)
    figure, axes = style.panel_grid(len(panels), columns, size, (0.0, pictures.margin))
    figure.suptitle(_headline(plan, pictures.waiting), fontsize=style.TITLE, color=style.INK)
    style.fill_panels(axes, panels)
    pictures.key_below(figure)
    return figure


def _headline(plan: Plan, waiting: float) -> str:
    if plan.catch_time is None:
        return f"{plan.name} · {plan.planner}: {plan.status.replace('_', ' ')}\n{plan.message}"
    when = f"caught {plan.catch_body!r} after {plan.catch_time:.3f} s"
    for word, time in (("held until", plan.held_until), ("placed at", plan.placed)):
        when += "" if time is None else f", {word} {time:.3f} s"
    if plan.map is not None:
        when += f" = {plan.catch_time / plan.map.kappa:.0f} τ"
    if waiting:
        when += f", {waiting:.2f} s of it waiting"
    known = plan.clearance is not None and np.isfinite(plan.clearance)
    space = f", clearance {plan.clearance:.3f}" if known else ""
    after = " " if plan.held_until is None else "\n"
    told = f"{when}{space}, planned in {plan.planning_ms:.1f} ms"
    return f"{plan.name} · {plan.planner}:{after}{told}"


@dataclass(frozen=True)
class MissedCatch:
    """A situation in which an entrant caught nothing, with the entrant's outcome and movement."""

    name: str
    """Of the entrant."""
    about: str
    """Family and stratum."""
    situation: Any
    outcome: str
    trajectory: Any
    """Movement that ends in a collision; None if the arm rested."""
    example: Any = None
    """Movement of an entrant that catches, or None."""

    @cached_property
    def pictures(self) -> Any:
        """Pictures of the missed catch, by the kind of arm."""
        touches = self.outcome == "touched"
        return DRAWN.of(self.situation).missed(
            self.situation, self.trajectory, self.example, touches
        )

    @property
    def duration(self) -> float:
        """Time of the last picture [s]: the collision, or the example's catch.

        Without both, the horizon or, where bodies are solid, the time when a target is closest.
        """
        shown = self.trajectory or self.example
        return float(self.pictures.resting_until if shown is None else shown.duration)


def failure_figure(failure: MissedCatch) -> Figure:
    """Draw the last instant of a missed catch."""
    figure = style.new_figure(*SIZE)
    ax = figure.subplots()
    failure.pictures.show_end(ax, failure.duration, PANEL)
    words = WORDS.get(failure.outcome, failure.outcome.replace("_", " "))
    style.title(ax, f"{failure.name}: {words}\n{failure.about} {failure.duration:.2f} s")
    return figure
