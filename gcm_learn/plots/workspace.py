"""The work-space: the arm, the bodies and where they go."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.patches import Polygon as Patch

from gcm_learn.plots import style
from gcm_learn.scene.limb import elbow_position
from gcm_learn.scene.outlines import outline
from gcm_learn.scene.packing import pose
from gcm_learn.situation import Arm, Body, Situation


def draw_workspace(
    ax: Axes,
    situation: Situation,
    t: float = 0.0,
    *,
    hand: tuple[float, float] | np.ndarray | None = None,
    annulus: bool = False,
) -> Axes:
    """Draw the arm plane at one instant.

    Parameters
    ----------
    ax : Axes
    situation : Situation
    t : float
        Time [s].
    hand : (2,) array_like, optional
        Hand position; by default the one at t = 0.
    annulus : bool
        Draw the circle of radius rho.

    Returns
    -------
    Axes
    """
    style.frame(ax, situation.arm.upper_arm, annulus=annulus)
    draw_bodies(ax, situation, t)
    draw_arm(ax, situation.arm, situation.arm.hand if hand is None else hand)
    return ax


def draw_bodies(ax: Axes, situation: Situation, t: float, alpha: float = 1.0) -> None:
    """Draw all bodies, or their cuts with the arm plane, at time t [s]."""
    for index in range(len(situation.bodies)):
        draw_body(ax, situation, index, t, alpha)


def draw_targets(ax: Axes, situation: Situation, t: float | None) -> None:
    """Draw the targets alone at time t [s]; nothing when there is no such time."""
    for index, body in enumerate(situation.bodies):
        if t is not None and body.role == "target":
            draw_body(ax, situation, index, t)


def draw_body(ax: Axes, situation: Situation, index: int, t: float, alpha: float = 1.0) -> None:
    """Draw one body, or its cut with the arm plane; nothing when the plane misses it."""
    corners = outline(situation, index, t)
    if corners is None:
        return
    colour = body_colour(situation.bodies[index])
    ax.add_patch(
        Patch(corners, closed=True, fc=to_rgba(colour, alpha), ec=colour, lw=1.2 * alpha, zorder=5)
    )


def body_colour(body: Body) -> str:
    """Return the colour of a body's role."""
    return style.TARGET if body.role == "target" else style.OBSTACLE


def draw_arm(
    ax: Axes, arm: Arm, hand: tuple[float, float] | np.ndarray, alpha: float = 1.0
) -> None:
    """Draw the limb with its hand at a point; joints as open circles, the hand filled."""
    elbow = elbow_position(hand, arm.upper_arm, arm.elbow)
    x, y = np.array([(0.0, 0.0), elbow, hand]).T
    colour = _paler(style.ARM, alpha)
    ax.plot(x, y, color=colour, lw=4.0, solid_capstyle="round", zorder=6)
    ax.plot(x[:2], y[:2], "o", mfc="white", mec=colour, mew=1.6, ms=6.5, zorder=7)
    ax.plot(x[2:], y[2:], "o", color=colour, ms=8.0, zorder=7)


def draw_courses(ax: Axes, situation: Situation, duration: float) -> None:
    """Draw an arrow along the way of every planar body that moves within `duration` [s]."""
    if situation.is_solid:
        return
    for index, body in enumerate(situation.bodies):
        times = np.linspace(0.0, duration, 40)
        way = np.array([pose(situation, index, t)[0][:2] for t in times])
        if np.linalg.norm(way[-1] - way[0]) < 0.05:
            continue
        colour = body_colour(body)
        ax.plot(way[:, 0], way[:, 1], color=colour, lw=1.4, ls=(0, (2, 1.5)), zorder=4)
        style.arrow(ax, way[-2], way[-1], colour)


def _paler(colour: str, alpha: float) -> tuple[float, float, float]:
    """Mix with white: unlike transparency, overlapping limbs stay clean."""
    r, g, b, _ = to_rgba(colour)
    return (1 + alpha * (r - 1), 1 + alpha * (g - 1), 1 + alpha * (b - 1))
