"""Part of space in a picture, over a floor with shadows; colours, poses of bodies."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from gcm_learn.arms import Chain
from gcm_learn.rendering.camera import Camera, Faces, Window, camera_from, render
from gcm_learn.scene import pack_bodies, poses_at
from gcm_learn.situation import Body, Box, Situation, arm_frame

OBSTACLE = "#2b6cb0"  # solid blue
TARGET = "#8e44ad"  # purple
ARM = "#a61e3a"  # dark red
JOINT = "#f3dfe3"
APPROACH = "#2f855a"  # green: from which side a target is to be caught
PATH = "#5b2a86"  # dark purple
FLOOR = "#f4f6f9"
INK = "#2d3748"  # text and outlines
TIME = ("#fbc65d", "#ef7b5a", "#c2427f", PATH)  # from early to late
SHADES = 256  # of them


def rgb(colour: str) -> np.ndarray:
    """Red, green and blue (3,) of a colour, from 0 to 1."""
    return np.array([int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)])


def body_colour(body: Body) -> str:
    """Return the colour of a body's role."""
    return TARGET if body.role == "target" else OBSTACLE


def time_colours(shares: ArrayLike) -> np.ndarray:
    """Colours (n, 3) of instants, given as shares (n,) of a movement."""
    marks, wanted = np.linspace(0.0, 1.0, len(TIME)), np.array([rgb(name) for name in TIME])
    step = np.minimum((np.asarray(shares) * SHADES).astype(int), SHADES - 1) / (SHADES - 1)
    return np.stack([np.interp(step, marks, channel) for channel in wanted.T], axis=-1)


JointSituation = Situation[Chain]
"""Situation among solids whose arm moves in its joints."""
LEVEL = 1e-6  # largest sine of the slope of a ground


class Ground(NamedTuple):
    """A level box at rest that reaches farther than the arm to all sides."""

    body: Body
    height: float


def body_poses(situation: JointSituation, times: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Return places and turns of the bodies at some times, in the world.

    Parameters
    ----------
    situation : Situation
        With an arm that moves in its joints.
    times : (k,) array_like
        [s]

    Returns
    -------
    centres : (k, m, 3) ndarray
    rotations : (k, m, 3, 3) ndarray
        Columns are the bodies' axes.
    """
    instants = np.atleast_1d(np.asarray(times, dtype=float))
    bodies = pack_bodies(situation, max(situation.horizon, float(instants.max())))
    axes, origin = arm_frame(situation)
    out = np.zeros((len(instants), len(situation.bodies), 12))
    out[..., 3:] = np.eye(3).ravel()  # spheres leave it so
    for t, poses in zip(instants, out, strict=True):
        poses_at(bodies, t, poses)
    turns = axes.T @ out[..., 3:].reshape(*out.shape[:2], 3, 3)
    return out[..., :3] @ axes + origin, turns


def ground_of(situation: JointSituation) -> Ground | None:
    """Return the ground of a situation, if it has one."""
    base, reach = np.asarray(situation.arm.base.origin), situation.arm.reach
    for k, body in enumerate(situation.bodies):
        if not isinstance(body.shape, Box) or sorted(body.shape.half_extents)[1] < reach:
            continue
        centres, turns = body_poses(situation, [0.0, situation.horizon])
        place, turn = centres[0, k], turns[0, k]
        rests = np.allclose(centres[:, k], place) and np.allclose(turns[:, k], turn)
        up = int(np.abs(turn[2]).argmax())
        beside = np.delete(np.abs((base - place) @ turn) + reach, up)
        covers = (beside <= np.delete(body.shape.half_extents, up)).all()
        height = float(place[2] + body.shape.half_extents[up])
        if rests and covers and 1.0 - abs(turn[2, up]) <= LEVEL and height <= base[2] + reach:
            return Ground(body, height)
    return None


AWAY = 1.35  # [reaches] from the base: nothing farther widens the picture, but paths of targets
LONGEST = 3.0  # [reaches] from the base: paths of targets from within are whole in a figure
PIXELS = 720  # of a side of a picture
ABOVE = 75.0  # [degrees] elevation of an eye that looks down
SHADOW, GRID = "#d9e0e9", "#ffffff"


def turned_view(view: Camera, degrees: float) -> Camera:
    """Return a camera turned about the vertical through its centre."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    turn = np.array([(c, s, 0.0), (-s, c, 0.0), (0.0, 0.0, 1.0)])
    axes = (view.right @ turn, view.up @ turn, view.nearer @ turn)
    return Camera(*axes, view.centre, view.distance)


def from_above(view: Camera) -> Camera:
    """Return a camera above the same centre, nearly in the vertical."""
    azimuth = float(np.degrees(np.arctan2(view.nearer[1], view.nearer[0])))
    return camera_from(azimuth, ABOVE, view.centre, view.distance)


def window_of(situation: JointSituation, view: Camera, things: Sequence[Faces]) -> Window:
    """Return the part of the picture in which things near the arm are whole."""
    seen = view.see(_near_arm(situation, things))[:, :2]
    low, high = seen.min(axis=0), seen.max(axis=0)
    room = 0.05 * situation.arm.reach
    return Window(0.5 * (low + high), 0.5 * float((high - low).max()) + room)


def centred(situation: JointSituation, view: Camera, things: Sequence[Faces]) -> Camera:
    """Return the camera, moved before the middle of things near the arm."""
    return replace(view, centre=np.mean(box_of(situation, things), axis=0))


def box_of(situation: JointSituation, things: Sequence[Faces]) -> tuple[np.ndarray, np.ndarray]:
    """Return lowest and highest coordinates (3,) of things near the arm."""
    near = _near_arm(situation, things)
    return near.min(axis=0), near.max(axis=0)


def floor_of(situation: JointSituation, things: Sequence[Faces]) -> float:
    """Return the height of the ground, or of a floor just under things near the arm."""
    ground = ground_of(situation)
    if ground is not None:
        return ground.height
    return float(box_of(situation, things)[0][2]) - 0.03 * situation.arm.reach


def _near_arm(situation: JointSituation, things: Sequence[Faces]) -> np.ndarray:
    """Return corners (k, 3) that are above the ground and not far from the base, or kept."""
    corners = np.concatenate([thing.corners.reshape(-1, 3) for thing in things])
    away = np.linalg.norm(corners - np.asarray(situation.arm.base.origin), axis=1)
    kept = np.concatenate([np.full(thing.corners.size // 3, thing.kept) for thing in things])
    ground = ground_of(situation)
    above = corners[:, 2] >= (-np.inf if ground is None else ground.height)
    near: np.ndarray = corners[kept | (above & (away < AWAY * situation.arm.reach))]
    return near


def staged(
    view: Camera, window: Window, floor: float, things: Sequence[Faces], pixels: int = PIXELS
) -> np.ndarray:
    """Return an image (pixels, pixels, 3) of things over a floor with their shadows."""
    ground = ground_faces(view.centre, floor, window.half, things)
    return np.clip(render(view, window, [*ground, *things], pixels), 0.0, 1.0)


def ground_faces(
    centre: np.ndarray, floor: float, size: float, things: Sequence[Faces]
) -> Iterator[Faces]:
    """Yield a floor, its grid, and the shadows of things above the floor, lit from the zenith."""
    step = 10.0 ** np.floor(np.log10(size))
    step *= 0.5 if size / step < 3.0 else 1.0
    middle = np.append(np.round(centre[:2] / step) * step, floor)
    half, hair = np.ceil(1.2 * size / step) * step, 1e-3 * size
    yield _level(middle - (0, 0, 2 * hair), [(-half, half, -half, half)], FLOOR)
    marks, wide = np.arange(-half, half + 0.5 * step, step), 0.004 * size
    lines = [(m - wide, m + wide, -half, half) for m in marks]
    yield _level(middle, lines + [(c, d, a, b) for a, b, c, d in lines], GRID)
    for thing in things:
        if thing.alpha == 1.0 and thing.lit:
            inside = (np.abs(thing.corners[..., :2] - middle[:2]) <= half).all(axis=(1, 2))
            above = (thing.corners[..., 2] >= floor).all(axis=1)
            flat = thing.corners[inside & above].copy()
            flat[..., 2] = floor - hair
            yield Faces(flat, rgb(SHADOW), both=True, lit=False)


def _level(
    middle: np.ndarray, areas: Sequence[tuple[float, float, float, float]], colour: str
) -> Faces:
    """Return level rectangles, each from x to x and y to y from the middle of all."""
    corners = [[(a, c, 0.0), (b, c, 0.0), (b, d, 0.0), (a, d, 0.0)] for a, b, c, d in areas]
    return Faces(middle + np.array(corners), rgb(colour), both=True, lit=False)
