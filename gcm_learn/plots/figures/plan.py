"""Picture of one plan: the movement, and the map that it was read from."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from gcm_learn.plots.figures import style
from gcm_learn.plots.figures.kinds import pictures_of
from gcm_learn.situation import AnySituation

if TYPE_CHECKING:
    from gcm_learn.planners import Plan

ABREAST = 4  # panels in one row; more are set in rows of three


def plan_figure(situation: AnySituation, plan: Plan) -> Figure:
    """Draw the movement in the work-space and the map it was read from.

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
    if plan.map is not None:
        when += f" = {plan.catch_time / plan.map.kappa:.0f} τ"
    if waiting:
        when += f", {waiting:.2f} s of it waiting"
    known = plan.clearance is not None and np.isfinite(plan.clearance)
    space = f", clearance {plan.clearance:.3f}" if known else ""
    return f"{plan.name} · {plan.planner}: {when}{space}, planned in {plan.planning_ms:.1f} ms"
