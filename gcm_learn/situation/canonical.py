"""Canonical frame of situations that differ only by a turn or a mirror.

The world of the arm prefers no direction.  A situation that is turned about the shoulder, or
mirrored with the elbow's side, has the same solutions, turned or mirrored.  The canonical form has
the hand on the positive x axis and the elbow on the right.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, overload

import numpy as np
from numpy.typing import ArrayLike

from gcm_learn.arms import PLANAR, SPATIAL, ByKind, Chain, SpatialArm
from gcm_learn.situation.body import Body
from gcm_learn.situation.laws import carried
from gcm_learn.situation.motion import PlanarQuadratic
from gcm_learn.situation.shapes import Polygon, Shape
from gcm_learn.situation.situation import AnySituation, Plane, Situation
from gcm_learn.situation.spatial_frame import (
    SpatialFrame,
    canonical_in_space,
    canonical_on_base,
    plane_frame,
)

_SPACE = Plane((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))


@dataclass(frozen=True)
class Frame:
    """Pose of a situation: its canonical form, mirrored in the x axis if so, then turned."""

    angle: float = 0.0
    """Direction of the hand at t = 0, counter-clockwise [rad]."""
    mirrored: bool = False
    """True where the elbow is on the left."""

    def canonical(self, points: ArrayLike) -> np.ndarray:
        """Points or vectors (..., 2) of the situation's arm plane, in canonical coordinates."""
        return np.asarray(points, dtype=float) @ self._matrix

    def original(self, points: ArrayLike) -> np.ndarray:
        """Points or vectors (..., 2) in canonical coordinates, in the situation's arm plane."""
        return np.asarray(points, dtype=float) @ self._matrix.T

    @property
    def _matrix(self) -> np.ndarray:
        """Orthogonal matrix from canonical to original coordinates (2, 2)."""
        c, s = math.cos(self.angle), math.sin(self.angle)
        side = -1.0 if self.mirrored else 1.0
        return np.array([[c, -s * side], [s, c * side]])


def frame_of(situation: Situation) -> Frame:
    """Return the pose of a situation; a hand at the shoulder has the direction 0."""
    x, y = situation.arm.hand
    return Frame(math.atan2(y, x), situation.arm.elbow == "left")


@overload
def canonical(situation: Situation[SpatialArm]) -> tuple[Situation[SpatialArm], SpatialFrame]: ...
@overload
def canonical(situation: Situation[Chain]) -> tuple[Situation[Chain], SpatialFrame]: ...
@overload
def canonical(situation: Situation) -> tuple[Situation, Frame]: ...
def canonical(situation: AnySituation) -> tuple[AnySituation, Frame | SpatialFrame]:
    """Return the situation in its canonical form, and its frame.

    A 3D situation is also expressed in coordinates of its arm plane; seen from the plane's other
    side it is mirrored.  A spatial arm stands at the origin and is a left one (see
    `situation.spatial_frame`); a chain stands at the origin.

    Returns
    -------
    Situation
        Hand at (r, 0), elbow on the right; or the base at the origin, unturned.  Names and order
        are kept.
    Frame or SpatialFrame
    """
    form: tuple[AnySituation, Frame | SpatialFrame] = _FORM.of(situation)(situation)
    return form


def _canonical_in_plane(situation: Situation) -> tuple[Situation, Frame]:
    """The canonical form of a situation with a planar arm."""
    frame = frame_of(situation)
    arm = replace(situation.arm, hand=(math.hypot(*situation.arm.hand), 0.0), elbow="right")
    if situation.plane is None:
        move = _planar_mover(frame)
        return replace(situation, arm=arm, bodies=tuple(map(move, situation.bodies))), frame
    move = _solid_mover(situation.plane, frame)
    bodies = tuple(map(move, situation.bodies))
    return replace(situation, arm=arm, bodies=bodies, plane=_SPACE), frame


def _planar_mover(frame: Frame) -> Callable[[Body], Body]:
    """Brings planar bodies into canonical coordinates."""
    c, s = math.cos(frame.angle), math.sin(frame.angle)
    side = -1.0 if frame.mirrored else 1.0

    def move(v: tuple[float, float]) -> tuple[float, float]:
        return (c * v[0] + s * v[1], side * (c * v[1] - s * v[0]))

    def moved(body: Body) -> Body:
        motion = body.motion
        assert isinstance(motion, PlanarQuadratic)
        there = PlanarQuadratic(
            move(motion.position),
            move(motion.velocity),
            move(motion.acceleration),
            math.remainder(side * (motion.angle - frame.angle), 2.0 * math.pi),
            side * motion.spin,
        )
        shape = _mirrored(body.shape) if frame.mirrored else body.shape
        return Body(body.role, body.name, shape, there)

    return moved


def _mirrored(shape: Shape) -> Shape:
    """Return a planar shape mirrored in its own x axis."""
    if not isinstance(shape, Polygon):
        return shape
    return Polygon(tuple((x, -y) for x, y in shape.vertices[::-1]))


def _solid_mover(plane: Plane, frame: Frame) -> Callable[[Body], Body]:
    """Brings solids into canonical arm-plane coordinates: x, y and the plane's normal."""
    rows, origin = plane_frame(plane)
    c, s = math.cos(frame.angle), math.sin(frame.angle)
    side = -1.0 if frame.mirrored else 1.0
    # Seen from the other side the normal is turned, too: a rotation, so solids stay what they are.
    turn = np.array([[c, s, 0.0], [-side * s, side * c, 0.0], [0.0, 0.0, side]]) @ rows

    def moved(body: Body) -> Body:
        assert not isinstance(body.motion, PlanarQuadratic)
        return replace(body, motion=carried(body.motion, turn, origin))

    return moved


_FORM: ByKind[Any] = ByKind(
    {PLANAR: _canonical_in_plane, SPATIAL: canonical_in_space}, default=canonical_on_base
)
