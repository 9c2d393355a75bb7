"""The front on its way: what the lattice knows at an instant of mental time."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle

from gcm_learn.plots import style
from gcm_learn.plots.handspace import draw_extended, draw_hand
from gcm_learn.plots.maps import birth, draw_effective, spread, walls
from gcm_learn.plots.workspace import draw_body
from gcm_learn.situation import Situation

if TYPE_CHECKING:
    from gcm_learn.maps.cognitive_map import CognitiveMap

FAR = 1e3  # [tau] stands for never


def draw_snapshot(
    ax: Axes,
    situation: Situation,
    cognitive_map: CognitiveMap,
    tau: float,
    path: np.ndarray | None = None,
) -> Axes:
    """Draw the explored region, the extended obstacles and the targets at one mental time.

    Parameters
    ----------
    ax : Axes
    situation : Situation
    cognitive_map : CognitiveMap
        The map of this situation.
    tau : float
        Mental time.
    path : (n, 2) ndarray, optional
        Way of the hand to the contact.

    Returns
    -------
    Axes
    """
    style.frame(ax, situation.arm.upper_arm)
    style.title(ax, f"τ = {tau:.0f}")
    draw_explored(ax, cognitive_map, tau)
    t = tau * cognitive_map.kappa
    draw_extended(ax, situation, t)
    draw_effective(ax, cognitive_map, tau)
    for index in range(len(situation.bodies)):
        draw_body(ax, situation, index, t)
    if path is not None:
        style.draw_path(ax, path)
    draw_hand(ax, cognitive_map.hand)
    return ax


def draw_explored(ax: Axes, cognitive_map: CognitiveMap, tau: float) -> None:
    """Shade what lies behind the front and draw the front where it is not frozen."""
    ahead = np.minimum(spread(cognitive_map) - tau, FAR)
    if not (ahead < 0.0).any():
        return
    centres, limits = cognitive_map.lattice.centres, ax.axis()
    region = ax.contourf(
        centres, centres, ahead, levels=[-np.inf, 0.0], colors=[style.EXPLORED], zorder=1
    )
    stuck = walls(cognitive_map) & (birth(cognitive_map) <= tau)
    front = ax.contour(
        centres, centres, np.ma.masked_where(stuck, ahead), levels=[0.0], colors=[style.FRONT],
        linewidths=1.8, zorder=3,
    )  # fmt: skip
    ax.axis(limits)
    rim = Circle((0, 0), cognitive_map.lattice.upper_arm + 1.0, transform=ax.transData)
    for drawn in (region, front):
        drawn.set_clip_path(rim)
