"""The work-space: the arm, the bodies, where they go and where the hand rests."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba
from matplotlib.patches import Polygon as Patch

from gcm_learn.arms import Arm, elbow_position
from gcm_learn.plots.figures import style
from gcm_learn.rendering import body_colour
from gcm_learn.scene import outline, pose
from gcm_learn.situation import Situation

if TYPE_CHECKING:
    from gcm_learn.motion import Movement, Wait
    from gcm_learn.planners import Plan

PALEST = 0.25  # share of colour of the earliest pose
SHORTEST = 0.02  # share of the movement: shorter rests are not to be seen
NEAR = 0.15  # [forearms] rests so close together share a mark
LABELLED = 3  # so many of the longest tell how long they are
SMALLEST, GROWTH = 7.0, 14.0  # [pt] size of a mark; its area grows with the rest's length
BESIDE = 4.0  # [pt] from a mark to its label
AROUND = 0.3  # [forearms] part of the path of which labels keep clear


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
    """Draw the targets alone at time t [s], or nothing without a time."""
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


def draw_arm(
    ax: Axes, arm: Arm, hand: tuple[float, float] | np.ndarray, alpha: float = 1.0
) -> None:
    """Draw the arm with its hand at a point; joints as open circles, the hand filled."""
    elbow = elbow_position(hand, arm.upper_arm, arm.elbow)
    x, y = np.array([(0.0, 0.0), elbow, hand]).T
    colour = _paler(style.ARM, alpha)
    ax.plot(x, y, color=colour, lw=4.0, solid_capstyle="round", zorder=6)
    ax.plot(x[:2], y[:2], "o", mfc="white", mec=colour, mew=1.6, ms=6.5, zorder=7)
    ax.plot(x[2:], y[2:], "o", color=colour, ms=8.0, zorder=7)


def draw_courses(ax: Axes, situation: Situation, duration: float) -> None:
    """Draw an arrow along the path of every planar body that moves within `duration` [s]."""
    if situation.is_solid:
        return
    for index, body in enumerate(situation.bodies):
        times = np.linspace(0.0, duration, 40)
        path = np.array([pose(situation, index, t)[0][:2] for t in times])
        if np.linalg.norm(path[-1] - path[0]) < 0.05:
            continue
        colour = body_colour(body)
        ax.plot(*path.T, color=colour, lw=1.4, ls=(0, (2, 1.5)), zorder=4)
        style.arrow(ax, path[-2], path[-1], colour)


def _paler(colour: str, alpha: float) -> tuple[float, float, float]:
    """Mix with white: unlike transparency, overlapping limbs stay clean."""
    r, g, b, _ = to_rgba(colour)
    return (1 + alpha * (r - 1), 1 + alpha * (g - 1), 1 + alpha * (b - 1))


def draw_poses(
    ax: Axes,
    situation: Situation,
    trajectory: Movement,
    times: np.ndarray | None = None,
    *,
    count: int = 4,
) -> Axes:
    """Draw the arm and the bodies at several instants over each other, later ones darker.

    Parameters
    ----------
    ax : Axes
    situation : Situation
    trajectory : Movement
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


def draw_movement(ax: Axes, situation: Situation, plan: Plan, count: int = 4) -> None:
    """Draw `count` poses of a plan's movement; only the start of a plan without a movement."""
    if plan.trajectory is None:
        draw_workspace(ax, situation)
    else:
        draw_poses(ax, situation, plan.trajectory, count=count)


def notable_waits(trajectory: Movement) -> list[Wait]:
    """Return the rests of a movement that are long enough to be shown."""
    return trajectory.waits(SHORTEST * trajectory.duration)


def waiting_at(trajectory: Movement, t: float) -> bool:
    """Say whether the hand is in a notable rest at time t [s]."""
    return any(wait.start < t < wait.end for wait in notable_waits(trajectory))


def draw_waits(ax: Axes, trajectory: Movement, *, labels: bool = True) -> None:
    """Draw the sign for a pause where the hand rests, larger for longer rests, and say how long.

    Rests close together, as of a hand that follows something slow, share a sign.

    Parameters
    ----------
    ax : Axes
        Hand-space or work-space.
    trajectory : Movement
    labels : bool
        Write the lengths of the longest rests beside their signs.
    """
    stops = [_stop(group) for group in _grouped(notable_waits(trajectory))]
    stops.sort(key=lambda stop: -stop[1])
    for rank, (place, lasts) in enumerate(stops):
        size = SMALLEST + GROWTH * float(np.sqrt(lasts / trajectory.duration))
        _draw_pause(ax, place, size)
        if labels and rank < LABELLED:
            _label(ax, place, f"waits {lasts:.2f} s", size, _free_side(trajectory.hand, place))


def _grouped(waits: list[Wait]) -> list[list[Wait]]:
    """Put rests together that follow each other near the same place."""
    groups: list[list[Wait]] = []
    for wait in waits:
        if groups and np.hypot(wait.x - groups[-1][0].x, wait.y - groups[-1][0].y) < NEAR:
            groups[-1].append(wait)
        else:
            groups.append([wait])
    return groups


def _stop(group: list[Wait]) -> tuple[np.ndarray, float]:
    """Return where the longest of some rests is (2,), and how long they are together [s]."""
    longest = max(group, key=lambda wait: wait.duration)
    return np.array([longest.x, longest.y]), sum(wait.duration for wait in group)


def _draw_pause(ax: Axes, place: np.ndarray, size: float) -> None:
    """Draw the sign of a pause: a ring, `size` points wide, with two bars inside."""
    x, y = place
    ax.plot(x, y, "o", mfc="white", mec=style.PATH, mew=1.6, ms=size, zorder=12.5)
    for side in (-0.45, 0.45):
        bar = [(side, -1.0), (side, 1.0)]
        ax.plot(x, y, marker=bar, mec=style.PATH, mew=0.1 * size, ms=0.42 * size, zorder=12.6)


def _free_side(hand: np.ndarray, place: np.ndarray) -> np.ndarray:
    """Return the direction (2,) that leads away from the path around a place."""
    away = place - hand
    distance = np.linalg.norm(away, axis=1)
    near = (distance > 0.0) & (distance < AROUND)
    side = (away[near] / distance[near, None]).sum(axis=0)
    norm = float(np.linalg.norm(side))
    return side / norm if norm > 1e-9 else np.array([1.0, 0.0])


def _label(ax: Axes, place: np.ndarray, text: str, size: float, side: np.ndarray) -> None:
    """Write a text beside a mark of a size [pt], in the direction `side` from the mark."""
    steep = abs(side[1]) > 2 * abs(side[0])
    ax.annotate(
        text, tuple(place), xytext=tuple((0.5 * size + BESIDE) * side), textcoords="offset points",
        ha="center" if steep else "left" if side[0] > 0 else "right",
        va="center" if abs(side[0]) > 2 * abs(side[1]) else "bottom" if side[1] > 0 else "top",
        fontsize=style.SMALL, color=style.PATH, zorder=15,
        bbox={"boxstyle": "round,pad=0.15", "fc": "white", "ec": "none", "alpha": 0.85},
    )  # fmt: skip
