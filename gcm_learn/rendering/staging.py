"""Part of space that is in a picture, over a floor with shadows."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from gcm_learn.rendering.camera import Camera, Faces, Window, camera_from, render
from gcm_learn.rendering.colours import FLOOR, rgb
from gcm_learn.rendering.poses import JointSituation, ground_of

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
    """Yield a floor, a grid on it and shadows of what is above it, lit from the zenith."""
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
