"""Cognitive maps, drawn as in Fig. 4D, and the moving front at instants as in Fig. 4C."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize, to_rgba
from matplotlib.patches import Circle

from gcm_learn.plots.figures import style
from gcm_learn.plots.figures.hand_space import draw_extended, draw_hand
from gcm_learn.plots.figures.workspace import draw_bodies, draw_targets, draw_waits
from gcm_learn.situation import Situation

if TYPE_CHECKING:
    from gcm_learn.maps import CognitiveMap
    from gcm_learn.planners import Plan

CONTOUR_STEP = 20.0  # [tau]
SHADES = 40
FAR = 1e3  # [tau] stands for never
FRONT_SPEED = 0.164  # [cells per tau] of a circular front (erratum 9)


def plot_map(
    cognitive_map: CognitiveMap,
    ax: Axes | None = None,
    path: np.ndarray | None = None,
    *,
    colour_bar: bool = False,
    latest: float | None = None,
) -> Axes:
    """Draw arrival times, effective obstacles, the effective target, the hand and a path.

    Parameters
    ----------
    cognitive_map : CognitiveMap
    ax : Axes, optional
        Where to draw; by default in a figure of its own.
    path : (n, 2) ndarray, optional
        Hand positions from the hand to the interception.
    colour_bar : bool
        Explain the colours beside the map.
    latest : float, optional
        Mental time of the darkest colour, so that maps can share a scale; by default the last
        arrival.

    Returns
    -------
    Axes
    """
    if ax is None:
        ax = style.new_figure(5.2 if colour_bar else 4.6, 4.6).subplots()
    style.frame(ax, cognitive_map.lattice.upper_arm)
    darkest = latest_arrival(cognitive_map) if latest is None else latest
    _draw_arrival(ax, cognitive_map, darkest)
    if colour_bar and darkest > 0.0:
        draw_colour_bar([ax], darkest)
    draw_effective(ax, cognitive_map)
    if path is not None:
        style.draw_path(ax, path)
    draw_hand(ax, cognitive_map.hand)
    return ax


def plot_plan(
    ax: Axes,
    situation: Situation,
    plan: Plan,
    cognitive_map: CognitiveMap | None = None,
    *,
    latest: float | None = None,
    waits: bool = True,
) -> None:
    """Draw a plan's map, the path with its waits, and the targets at the catch.

    Parameters
    ----------
    ax : Axes
    situation : Situation
    plan : Plan
        Of this situation.
    cognitive_map : CognitiveMap, optional
        Another map than the plan's own.

    Other Parameters
    ----------------
    latest : float, optional
        Mental time of the darkest colour, as in `plot_map`.
    waits : bool
        Write how long the longest waits are.
    """
    cognitive_map = plan.map if cognitive_map is None else cognitive_map
    assert cognitive_map is not None
    path = None if plan.trajectory is None else plan.trajectory.hand
    plot_map(cognitive_map, ax, path, latest=latest)
    draw_targets(ax, situation, plan.catch_time)
    if plan.trajectory is not None:
        draw_waits(ax, plan.trajectory, labels=waits)


def draw_effective(ax: Axes, cognitive_map: CognitiveMap, tau: float | None = None) -> None:
    """Draw the effective obstacles and target that exist at mental time tau (default: all)."""
    born = birth(cognitive_map)
    for cells, colour in (
        (walls(cognitive_map), style.EFFECTIVE),
        (cognitive_map.effective_target, style.TARGET),
    ):
        there = cells if tau is None else cells & (born <= tau)
        image = there[..., None] * np.array(to_rgba(colour))
        ax.imshow(
            image, origin="lower", extent=cognitive_map.lattice.extent, zorder=4,
            interpolation="antialiased",
        )  # fmt: skip


def walls(cognitive_map: CognitiveMap) -> np.ndarray:
    """Return the cells (n, n) of effective obstacles that the front never entered.

    In a map with waits the front may enter an effective obstacle later; in the paper's maps it
    never does.
    """
    shut: np.ndarray = cognitive_map.effective_obstacles & np.ma.getmaskarray(cognitive_map.arrival)
    return shut


def birth(cognitive_map: CognitiveMap) -> np.ndarray:
    """Return the mental time (n, n) of the front's arrival in each cell, or else in a neighbour.

    A cell that was frozen before it fired has no arrival of its own, but a neighbour has.
    Infinite where the front never came near.
    """
    tau = np.ma.filled(cognitive_map.arrival_tau.astype(float), np.inf)
    padded = np.pad(tau, 1, constant_values=np.inf)
    around = [_shifted(padded, i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)]
    return np.where(np.isfinite(tau), tau, np.min(around, axis=0))


def spread(cognitive_map: CognitiveMap) -> np.ndarray:
    """Return arrival in tau (n, n), extended by one cell at the front's usual speed.

    Its contours are as smooth as the front was, up to the rim and to where the front stopped.
    Infinite further out.
    """
    tau = np.ma.filled(cognitive_map.arrival_tau.astype(float), np.inf)
    tau[walls(cognitive_map)] = np.inf  # the front ends there
    padded = np.pad(tau, 1, constant_values=np.inf)
    wall = np.pad(walls(cognitive_map), 1)
    steps = [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if (i, j) != (0, 0)]
    later = [
        np.where(
            _shifted(wall, i, 0) | _shifted(wall, 0, j) if i and j else False,  # round no corner
            np.inf,
            _shifted(padded, i, j) + np.hypot(i, j) / FRONT_SPEED,
        )
        for i, j in steps
    ]
    return np.where(np.isfinite(tau), tau, np.min(later, axis=0))


def _shifted(padded: np.ndarray, i: int, j: int) -> np.ndarray:
    """Return the value of every cell's neighbour (i, j), from an array padded by one cell."""
    n, m = padded.shape
    return padded[1 + i : n - 1 + i, 1 + j : m - 1 + j]


def latest_arrival(cognitive_map: CognitiveMap) -> float:
    """Return the mental time of the front's last arrival in a cell, 0 without arrivals."""
    return float(cognitive_map.arrival_tau.max()) if cognitive_map.arrival.count() else 0.0


def draw_colour_bar(panels: Sequence[Axes], latest: float) -> None:
    """Explain the colours of maps beside their panels.

    Parameters
    ----------
    panels : sequence of Axes
        All of one figure; the bar takes some of their room.
    latest : float
        Mental time of the darkest colour.
    """
    figure = panels[0].get_figure(root=True)
    assert figure is not None
    colours = ScalarMappable(Normalize(0.0, latest), style.MAP_COLOURS)
    bar = figure.colorbar(colours, ax=list(panels), shrink=0.75, pad=0.02)
    bar.set_label("arrival of the front, mental time τ", fontsize=style.LABEL, color=style.INK)
    bar.set_ticks(np.arange(2 * CONTOUR_STEP, latest, 2 * CONTOUR_STEP).tolist())
    bar.ax.tick_params(labelsize=style.SMALL, colors=style.INK)
    bar.outline.set_visible(False)


def _draw_arrival(ax: Axes, cognitive_map: CognitiveMap, darkest: float) -> None:
    latest = latest_arrival(cognitive_map)
    if latest <= 0.0:
        return
    tau = np.where(np.isfinite(far := spread(cognitive_map)), far, 2 * latest)
    centres = cognitive_map.lattice.centres
    shown = ax.contourf(
        centres, centres, tau, levels=np.linspace(0.0, latest, SHADES), cmap=style.MAP_COLOURS,
        norm=Normalize(0.0, darkest), zorder=1,
    )  # fmt: skip
    # No ring just before the edge: it would only double it.
    rings = np.arange(CONTOUR_STEP, latest - CONTOUR_STEP / 2, CONTOUR_STEP)
    lines = ax.contour(
        centres, centres, tau, levels=rings, colors="white", linewidths=0.9, zorder=2
    )
    _clip_at_rim(ax, cognitive_map, shown, lines)


def _clip_at_rim(ax: Axes, cognitive_map: CognitiveMap, *drawn: Artist) -> None:
    """Show contours within the arm's reach only."""
    rim = Circle((0, 0), cognitive_map.lattice.upper_arm + 1.0, transform=ax.transData)
    for artist in drawn:
        artist.set_clip_path(rim)


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
        Hand positions from the hand to the interception.

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
    draw_bodies(ax, situation, t)
    if path is not None:
        style.draw_path(ax, path)
    draw_hand(ax, cognitive_map.hand)
    return ax


def draw_explored(ax: Axes, cognitive_map: CognitiveMap, tau: float) -> None:
    """Shade the explored region and draw the front, except where it is frozen."""
    ahead = np.minimum(spread(cognitive_map) - tau, FAR)
    if not (ahead < 0.0).any():
        return
    centres = cognitive_map.lattice.centres
    region = ax.contourf(
        centres, centres, ahead, levels=[-np.inf, 0.0], colors=[style.EXPLORED], zorder=1
    )
    stuck = walls(cognitive_map) & (birth(cognitive_map) <= tau)
    front = ax.contour(
        centres, centres, np.ma.masked_where(stuck, ahead), levels=[0.0], colors=[style.FRONT],
        linewidths=1.8, zorder=3,
    )  # fmt: skip
    _clip_at_rim(ax, cognitive_map, region, front)
