"""Arms and the capsules that cover them, from two sides."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Polygon

from gcm_learn.arms import ChainModel
from gcm_learn.plots.figures import style

SIDES = {"from the side": (0, 2), "from the front": (1, 2)}
"""Panels, and the axes of the base that lie across and up in them."""
COLOURS = ("#0b6e4f", "#c1666b", "#d4a017", "#4a6fa5", "#7d8597", "#8f5fa8", "#68a691")


def draw_arm(
    model: ChainModel,
    joints: Sequence[float] | None = None,
    parts: Sequence[Sequence[tuple[np.ndarray, np.ndarray]]] = (),
) -> Figure:
    """Draw an arm's capsules, one colour for each joint, and the parts of links inside them.

    Parameters
    ----------
    model : ChainModel
    joints : (n,) sequence of float, optional
        The posture; the middle of all ranges if not given.
    parts : sequence of sequences of (centres, radii), optional
        Balls, in the frame of its joint, whose hull each link holds.

    Returns
    -------
    matplotlib.figure.Figure
    """
    from gcm_learn.arms import frames_at  # its libraries take a while to import

    low, high = np.array(model.ranges).T
    posture = 0.5 * (low + high) if joints is None else np.array(joints)
    rotations, places = frames_at(model, posture[None].astype(float))
    rotation, place = rotations[:, 0], places[:, 0]
    figure = style.new_figure(8.0, 4.6)
    axes = figure.subplots(1, 2)
    for ax, (name, across) in zip(axes, SIDES.items(), strict=True):
        for k, link in enumerate(model.links):
            colour = COLOURS[link.joint % len(COLOURS)]
            ends = np.array([link.start, link.end]) @ rotation[link.joint].T + place[link.joint]
            outline = _stadium(ends[0, across], ends[1, across], link.radius)
            ax.add_patch(Polygon(outline, facecolor=colour, alpha=0.25, edgecolor=colour))
            for centres, radii in parts[k] if parts else ():
                moved = centres @ rotation[link.joint].T + place[link.joint]
                _dots(ax, moved[:, across], radii)
        hand = model.hand
        tip = rotation[hand.joint] @ np.array(hand.point) + place[hand.joint]
        ax.plot(*tip[list(across)], marker="x", color=style.TARGET, ms=7)
        ax.set_title(name, fontsize=9)
        ax.set_aspect("equal")
        ax.autoscale_view()
    _widen(axes)
    figure.suptitle(f"{model.name}: {model.dof} joints, {len(model.links)} capsules", fontsize=10)
    return figure


def _widen(axes: Sequence[Axes]) -> None:
    """Give all axes square limits of one size, each about the middle of its present limits."""
    limits = np.array([[ax.get_xlim(), ax.get_ylim()] for ax in axes])
    half = 0.5 * np.ptp(limits, axis=2).max()
    for ax, (across, up) in zip(axes, limits.mean(axis=2), strict=True):
        ax.set_xlim(across - half, across + half)
        ax.set_ylim(up - half, up + half)


def _stadium(start: np.ndarray, end: np.ndarray, radius: float) -> np.ndarray:
    """Return the outline (n, 2) of a capsule that is seen from the side."""
    along = np.arctan2(*(end - start)[::-1])
    half = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 16)
    caps = []
    for centre, turn in ((end, along), (start, along + np.pi)):
        caps.append(centre + radius * np.column_stack([np.cos(half + turn), np.sin(half + turn)]))
    return np.concatenate(caps)


def _dots(ax: Axes, places: np.ndarray, radii: np.ndarray) -> None:
    """Draw balls as circles, and points as dots."""
    points = places[radii == 0.0]
    ax.plot(points[:, 0], points[:, 1], ".", color=style.INK, ms=1.0)
    for place, radius in zip(places[radii > 0.0], radii[radii > 0.0], strict=True):
        ax.add_patch(Circle(place, radius, fill=False, edgecolor=style.INK, linewidth=0.4))
