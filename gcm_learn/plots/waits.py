"""Rests of the hand, as marks on its path."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes

from gcm_learn.plots import style

if TYPE_CHECKING:
    from gcm_learn.motion.trajectory import Trajectory, Wait

SHORTEST = 0.02  # share of the movement: shorter rests are not to be seen
NEAR = 0.15  # [forearms] rests so close together share a mark
LABELLED = 3  # so many of the longest tell how long they are
SMALLEST, GROWTH = 7.0, 14.0  # [pt] size of a mark; its area grows with the rest's length
BESIDE = 4.0  # [pt] from a mark to its label
AROUND = 0.3  # [forearms] part of the path of which labels keep clear


def notable_waits(trajectory: Trajectory) -> list[Wait]:
    """Return the rests of a movement that are long enough to be shown."""
    return trajectory.waits(SHORTEST * trajectory.duration)


def waiting_at(trajectory: Trajectory, t: float) -> bool:
    """Say whether the hand is in a notable rest at time t [s]."""
    return any(wait.start < t < wait.end for wait in notable_waits(trajectory))


def draw_waits(ax: Axes, trajectory: Trajectory, *, labels: bool = True) -> None:
    """Draw the sign for a pause where the hand rests, larger for longer rests, and say how long.

    Rests close together, as of a hand that follows something slow, share a sign.

    Parameters
    ----------
    ax : Axes
        Hand-space or work-space.
    trajectory : Trajectory
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
    """Draw a ring with two bars in it, `size` points wide."""
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
    """Write beside a mark of a size [pt], on one side of it."""
    steep = abs(side[1]) > 2 * abs(side[0])
    ax.annotate(
        text, tuple(place), xytext=tuple((0.5 * size + BESIDE) * side), textcoords="offset points",
        ha="center" if steep else "left" if side[0] > 0 else "right",
        va="center" if abs(side[0]) > 2 * abs(side[1]) else "bottom" if side[1] > 0 else "top",
        fontsize=style.SMALL, color=style.PATH, zorder=15, path_effects=[style.HALO],
    )  # fmt: skip
