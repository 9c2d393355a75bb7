"""Hand-space as a ball: extended obstacles, the front and maps, as surfaces and as a cut.

The hand is a point in a ball.  A map of arrivals fills the ball. The picture cuts it
open along a plane through the hand and the place of the catch; effective obstacles stand out of it.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.patches import Circle, Patch
from scipy.ndimage import map_coordinates, maximum_filter, minimum_filter

from gcm_learn.arms import hands_along, rotation_of
from gcm_learn.charts import HandLattice, cell_clearances
from gcm_learn.maps import CognitiveMap
from gcm_learn.plots.figures import style
from gcm_learn.plots.figures.maps import CONTOUR_STEP
from gcm_learn.plots.figures.scenery import show_image, show_through
from gcm_learn.plots.figures.surfaces import softened, surface
from gcm_learn.rendering import (
    PIXELS,
    Camera,
    Faces,
    JointSituation,
    Window,
    body_faces,
    path_faces,
    placed,
    render,
    turned_view,
)
from gcm_learn.situation import Sphere

if TYPE_CHECKING:
    from gcm_learn.motion import Movement

GLASSY, CLEAR, VEILED = 0.5, 0.3, 0.35  # alphas of extended obstacles, front, what is cut off
POINT = 0.045  # [reaches] radius of the hand's ball
CUT = 260  # cells a side of a cut
WHOLE = 0.99  # share of arrivals around a point of a cut that has contours
RING = 1.4  # of these cells: half the width of a contour
MOST_RINGS = 10
SHELL = 0.15  # level at which softened effective obstacles, one cell thin, are drawn


def places_of(chart: HandLattice, index: np.ndarray) -> np.ndarray:
    """Places (..., 3) in the world of indices [iz, iy, ix] (..., 3) of a lattice."""
    return chart.in_world((index[..., ::-1] - 0.5 * (chart.n - 1)) * chart.spacing)


def skin(chart: HandLattice, field: np.ndarray, level: float, colour: str, alpha: float) -> Faces:
    """The surface on which a field over a lattice has a level."""
    corners, normal = surface(field, level)
    # reversing the indices mirrors, so that the order of corners turns round
    places = places_of(chart, corners)[:, ::-1]
    turned = (normal[..., ::-1] @ rotation_of(chart.arm.base.rotation).T)[:, ::-1]
    return Faces(places, np.array(to_rgb(colour)), alpha, turned, both=True)


def extended_faces(
    situation: JointSituation, t: float, cognitive_map: CognitiveMap, alpha: float = GLASSY
) -> Faces:
    """Return extended obstacles at time t [s]: hand places whose posture touches an obstacle."""
    chart, joints = _chart(cognitive_map), cognitive_map.joints
    assert joints is not None
    rooms = cell_clearances(cast("Any", situation), chart, t, joints)
    room = np.clip(rooms, -chart.spacing, 2.0 * chart.spacing)
    return skin(chart, softened(room), 0.0, style.EXTENDED, alpha)


def front_faces(cognitive_map: CognitiveMap, t: float) -> Faces:
    """The front at time t [s]."""
    chart, arrival = _chart(cognitive_map), first_arrival(cognitive_map)
    there = np.where(np.isfinite(arrival), arrival, np.nan)
    steps = np.abs(np.diff(there, axis=0))
    step = 2.0 * (float(np.nanmedian(steps)) if np.isfinite(steps).any() else 0.001)
    return skin(chart, np.clip(arrival - t, -step, step), 0.0, style.FRONT, CLEAR)


def effective_faces(cognitive_map: CognitiveMap, t: float = np.inf, alpha: float = 1.0) -> Faces:
    """Effective obstacles that exist at time t [s]."""
    there = frozen_cells(cognitive_map) & (_birth(first_arrival(cognitive_map)) <= t)
    field = softened(softened(there))
    return skin(_chart(cognitive_map), -field, -SHELL, style.EFFECTIVE, alpha)


def effective_skin(cognitive_map: CognitiveMap, most: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the faces of the effective obstacles, and the time from which each face exists.

    Parameters
    ----------
    cognitive_map : CognitiveMap
        Over a `HandLattice`.
    most : int
        Largest number of cells a side from which the surface is made.

    Returns
    -------
    corners : (k, 4, 3) ndarray
        Of quadrilaterals, in the world.
    since : (k,) ndarray
        [s]
    """
    chart, arrival = _chart(cognitive_map), first_arrival(cognitive_map)
    frozen, stride = frozen_cells(cognitive_map), -(-chart.n // most)
    field = maximum_filter(softened(frozen), stride)[::stride, ::stride, ::stride]
    corners = stride * surface(-softened(field), -SHELL)[0]
    corners += 0.5 * (stride - 1) - stride // 2  # the middle of what became one cell
    came = minimum_filter(np.where(frozen, _birth(arrival), np.inf), 2 * stride + 3)
    middle = np.rint(corners.mean(axis=1)).astype(int).clip(0, chart.n - 1)
    return places_of(chart, corners), came[tuple(middle.T)]


def fills_ball(cognitive_map: CognitiveMap | None) -> bool:
    """Return whether there is a map over a `HandLattice`, which can be drawn in space."""
    return cognitive_map is not None and isinstance(cognitive_map.chart, HandLattice)


def _chart(cognitive_map: CognitiveMap) -> HandLattice:
    if not fills_ball(cognitive_map):
        over = type(cognitive_map.chart).__name__
        raise TypeError(f"this map is over a {over}, not over a HandLattice")
    return cast("HandLattice", cognitive_map.chart)


def first_arrival(cognitive_map: CognitiveMap) -> np.ndarray:
    """When the hand can be in a cell (n, n, n), in whatever posture [s]; infinite if never."""
    arrival = np.ma.filled(cognitive_map.arrival.astype(float), np.inf)
    return arrival if arrival.ndim == 3 else arrival.min(axis=3)


def frozen_cells(cognitive_map: CognitiveMap) -> np.ndarray:
    """Cells (n, n, n) in which the front froze and that the hand can be in in no posture."""
    frozen = cognitive_map.effective_obstacles
    shut: np.ndarray = (frozen if frozen.ndim == 3 else frozen.any(axis=3)) & np.isinf(
        first_arrival(cognitive_map)
    )
    return shut


def _evened(arrival: np.ndarray, never: float) -> np.ndarray:
    """Average arrivals over neighbouring cells that the front reached, for contours."""
    there = np.isfinite(arrival)
    share = softened(softened(there.astype(float)))
    total = softened(softened(np.where(there, arrival, 0.0)))
    return np.where(there, total / np.maximum(share, 1e-9), never)


def _birth(arrival: np.ndarray) -> np.ndarray:
    """Return the time (n, n, n) [s] of the front's arrival in or beside a cell, or infinity."""
    when = np.pad(arrival, 1, constant_values=np.inf)
    out = arrival.copy()
    for axis in range(3):
        for way in (1, -1):
            np.minimum(out, np.roll(when, way, axis)[1:-1, 1:-1, 1:-1], out=out)
    return out


def hand_ball(situation: JointSituation, hand: np.ndarray) -> Faces:
    """Return a small ball at the hand; in hand-space the whole arm is this point."""
    ball = Sphere(POINT * situation.arm.reach)
    return placed(ball, hand, np.eye(3), np.array(to_rgb("#1a202c")))


def ball_window(situation: JointSituation) -> Window:
    """The part of a picture that the ball within reach fills."""
    return Window(np.zeros(2), 1.08 * situation.arm.reach)


def ball_view(situation: JointSituation, view: Camera) -> Camera:
    """The camera, looking at the shoulder."""
    return Camera(
        view.right, view.up, view.nearer, np.asarray(situation.arm.base.origin), view.distance
    )


def draw_ball(ax: Axes, situation: JointSituation, view: Camera, things: list[Faces],
              pixels: int = PIXELS) -> None:  # fmt: skip
    """Draw things in hand-space, with a circle of the arm's reach."""
    window = ball_window(situation)
    show_image(ax, np.clip(render(view, window, things, pixels), 0.0, 1.0), window)
    ax.add_patch(
        Circle(
            (0, 0),
            situation.arm.reach,
            fill=False,
            ec=style.FAINT,
            lw=1.0,
            ls=(0, (4, 3)),
            zorder=5,
        )
    )


def cut_frame(
    start: np.ndarray, end: np.ndarray, view: Camera
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Middle and two axes of the plane through two points that faces a camera best."""
    along = end - start
    if np.linalg.norm(along) < 1e-9:
        along = view.right
    along = along / np.linalg.norm(along)
    facing = view.nearer - (view.nearer @ along) * along
    if np.linalg.norm(facing) < 1e-6:
        facing = view.up
    v = np.cross(facing / np.linalg.norm(facing), along)
    return 0.5 * (start + end), along, v


def cut_faces(
    cognitive_map: CognitiveMap, middle: np.ndarray,
    u: np.ndarray, v: np.ndarray,
) -> Iterator[Faces]:  # fmt: skip
    """Yield a cut through a map: arrival times as colours, with rings, and frozen cells."""
    chart, arrival = _chart(cognitive_map), first_arrival(cognitive_map)
    reach = chart.reach
    marks = np.linspace(-1.7 * reach, 1.7 * reach, CUT + 1)
    grid = middle + marks[:, None, None] * u + marks[None, :, None] * v
    base = chart.in_base(grid)
    index = (base / chart.spacing + 0.5 * (chart.n - 1))[..., ::-1]
    latest = float(arrival[np.isfinite(arrival)].max(initial=1e-9))
    places = np.moveaxis(index, -1, 0)
    times = map_coordinates(np.minimum(arrival, 2 * latest), places, order=1, cval=2 * latest)
    frozen = map_coordinates(softened(softened(frozen_cells(cognitive_map))), places, order=1)
    share = np.clip(times / latest, 0.0, 1.0)
    colours = np.asarray(style.MAP_COLOURS(share))[..., :3]
    step = CONTOUR_STEP * cognitive_map.kappa
    smooth = map_coordinates(_evened(arrival, 2 * latest), places, order=1, cval=2 * latest)
    rings = smooth / (step * max(1.0, np.ceil(latest / (MOST_RINGS * step))))
    off = np.abs((rings + 0.5) % 1.0 - 0.5) / np.maximum(np.hypot(*np.gradient(rings)), 1e-9)
    whole = map_coordinates(np.isfinite(arrival).astype(float), places, order=1) > WHOLE
    ring = np.clip(RING - off, 0.0, 1.0) * (rings > 0.5) * whole
    colours += (1.0 - colours) * ring[..., None]
    colours[frozen > SHELL] = to_rgb(style.EFFECTIVE)
    seen = (times <= latest * 1.02) | (frozen > SHELL)
    seen &= np.linalg.norm(base, axis=-1) <= reach

    def quads(values: np.ndarray) -> np.ndarray:
        parts = [values[:-1, :-1], values[1:, :-1], values[1:, 1:], values[:-1, 1:]]
        return np.stack(parts, axis=2).reshape(-1, 4, *values.shape[2:])

    keep = quads(seen).all(axis=1)
    yield Faces(quads(grid)[keep], quads(colours)[keep], both=True, lit=False)


def map_faces(
    situation: JointSituation, cognitive_map: CognitiveMap, view: Camera,
    trajectory: Movement | None = None, facing: Camera | None = None,
) -> list[Faces]:  # fmt: skip
    """Return a map cut open, facing a camera; effective obstacles before the cut are glass."""
    chart, met = _chart(cognitive_map), cognitive_map.interception
    start = chart.in_world(np.asarray(cognitive_map.hand))
    end = start if met is None else chart.in_world(np.asarray(met.position))
    middle, u, v = cut_frame(start, end, facing or view)
    things = list(cut_faces(cognitive_map, middle, u, v))
    walls = effective_faces(cognitive_map)
    before = ((walls.corners.mean(axis=1) - middle) @ np.cross(u, v)) * (
        np.cross(u, v) @ view.nearer
    ) > 0.0
    assert walls.normals is not None
    for side, alpha in ((before, VEILED), (~before, 1.0)):
        things.append(
            walls._replace(corners=walls.corners[side], normals=walls.normals[side], alpha=alpha)
        )
    if trajectory is not None:
        things += path_faces(situation, trajectory)
    things.append(hand_ball(situation, start))
    return things


class HandBall:
    """Hand-space as a ball in a film: extended obstacles, the front, and at last the map.

    Parameters
    ----------
    situation : Situation
        With an arm that moves in its joints.
    cognitive_map : CognitiveMap
        Over a `HandLattice`.
    trajectory : Movement, optional
    view : Camera
        Of the work-space beside it.
    """

    def __init__(
        self,
        situation: JointSituation,
        cognitive_map: CognitiveMap,
        trajectory: Movement | None,
        view: Camera,
    ) -> None:
        self.situation, self.map, self.trajectory = situation, cognitive_map, trajectory
        self.view = ball_view(situation, view)
        self._map: list[Faces] = []

    def at(self, t: float, *, moving: bool = True) -> list[Faces]:
        """Return all faces at time t [s]: the hand with its path or, unless `moving`, at t = 0."""
        things = [
            *self.world_at(t, t if moving else 0.0),
            effective_faces(self.map, t),
            front_faces(self.map, t),
        ]
        if moving and self.trajectory is not None and t > 0.0:
            things += path_faces(self.situation, self.trajectory, t)
        return things

    def world_at(self, t: float, moved: float = 0.0) -> list[Faces]:
        """Extended obstacles and targets at time t [s], and the hand at another."""
        return [
            extended_faces(self.situation, t, self.map),
            hand_ball(self.situation, self._hand(moved)),
            *body_faces(self.situation, t, roles=("target",)),
        ]

    def _hand(self, t: float) -> np.ndarray:
        if self.trajectory is None:
            return hands_along(self.situation.arm, self.situation.arm.joints)[0][0]
        return self.trajectory.hand_at(t)

    def show_world(self, ax: Axes, t: float) -> None:
        """Draw extended obstacles, targets and the hand's start at time t [s]."""
        draw_ball(ax, self.situation, self.view, self.world_at(t))

    def show(
        self, ax: Axes, t: float, turn: float = 0.0, pixels: int = PIXELS, *, moving: bool = True
    ) -> None:
        """Draw time t [s], from a camera that is turned about the vertical [degrees]."""
        view = turned_view(self.view, turn)
        draw_ball(ax, self.situation, view, self.at(t, moving=moving), pixels)

    def show_map(self, ax: Axes, turn: float = 0.0, pixels: int = PIXELS) -> None:
        """Draw the map, cut open, from a camera that is turned about the vertical [degrees]."""
        if not self._map:
            self._map = map_faces(self.situation, self.map, self.view, self.trajectory)
            if self.trajectory is not None:
                end = self.trajectory.duration
                self._map += body_faces(self.situation, end, roles=("target",))
        view = turned_view(self.view, turn)
        draw_ball(ax, self.situation, view, self._map, pixels)
        if self.trajectory is not None:
            times = np.linspace(0.0, self.trajectory.duration, 60)
            show_through(ax, view, self.trajectory.hand_at(times), 0.9)


HAND_SPACE_KEY = (
    (style.EXTENDED, "extended obstacle"),
    (style.FRONT, "explored by the front"),
    (style.EFFECTIVE, "frozen: effective obstacle"),
    (style.TARGET, "target"),
)


def key_of_hand_space(figure: Figure) -> None:
    """Add a key of the colours of hand-space below the pictures."""
    handles = [Patch(color=colour, label=name) for colour, name in HAND_SPACE_KEY]
    figure.legend(
        handles=handles, loc="outside lower center", ncols=len(handles), fontsize=style.SMALL,
        frameon=False, labelcolor=style.INK, handlelength=1.2, columnspacing=1.4,
    )  # fmt: skip
