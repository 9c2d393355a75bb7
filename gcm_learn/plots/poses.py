"""Superimposed poses of a moving arm, as in Fig. 4E."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes

from gcm_learn.plots import style
from gcm_learn.plots.waits import draw_waits
from gcm_learn.plots.workspace import draw_arm, draw_bodies
from gcm_learn.situation import Situation

if TYPE_CHECKING:
    from gcm_learn.motion.trajectory import Trajectory

PALEST = 0.25  # share of colour of the earliest pose


def draw_poses(
    ax: Axes,
    situation: Situation,
    trajectory: Trajectory,
    times: np.ndarray | None = None,
    *,
    count: int = 4,
) -> Axes:
    """Draw the arm and the bodies at several instants over each other, later ones darker.

    Parameters
    ----------
    ax : Axes
    situation : Situation
    trajectory : Trajectory
    times : (k,) ndarray, optional
        Instants [s]; by default `count` of them, evenly over the movement.

    Other Parameters
    ----------------
    count : int
        Number of instants when `times` is not given.

    Returns
    -------
    Axes
    """
    style.frame(ax, situation.arm.upper_arm)
    if times is None:
        times = np.linspace(0.0, trajectory.duration, count)
    hand = trajectory.hand
    ax.plot(hand[:, 0], hand[:, 1], color=style.PATH, lw=1.4, ls=(0, (3, 2)), zorder=7.5)
    for t, shade in zip(times, np.linspace(PALEST, 1.0, len(times)), strict=True):
        draw_bodies(ax, situation, t, shade)
        draw_arm(ax, situation.arm, trajectory.hand_at(t), shade)
    draw_waits(ax, trajectory)
    return ax
