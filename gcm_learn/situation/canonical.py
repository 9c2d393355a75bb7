"""One frame for situations that differ only by how they are turned or mirrored.

Nothing in the world of the arm prefers a direction: a situation turned about the shoulder, or
mirrored with the elbow's side, has the same solutions, turned or mirrored.  The canonical form has
the hand on the positive x axis and the elbow on the right.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from gcm_learn.situation.frames import plane_frame, rotation_of
from gcm_learn.situation.motion import Motion, Pendulum, PlanarQuadratic, SolidQuadratic
from gcm_learn.situation.shapes import Polygon, Shape
from gcm_learn.situation.situation import Body, Plane, Situation

_SPACE = Plane((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))


@dataclass(frozen=True)
class Frame:
    """How a situation lies: mirror the canonical one in its x axis if so, then turn it."""

    angle: float = 0.0
    """Direction of the hand at t = 0, counter-clockwise [rad]."""
    mirrored: bool = False
    """Whether the elbow is on the left."""

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
    """How a situation lies; a hand at the shoulder has the direction 0."""
    x, y = situation.arm.hand
    return Frame(math.atan2(y, x), situation.arm.elbow == "left")


def canonical(situation: Situation) -> tuple[Situation, Frame]:
    """The situation in its canonical form, and how it lay.

    A 3D situation is also expressed in coordinates of its arm plane; to mirror it takes no more
    than to look at the plane from its other side.

    Returns
    -------
    Situation
        Hand at (r, 0), elbow on the right; names and order are kept.
    Frame
    """
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
    """A planar shape mirrored in its own x axis."""
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

    def move(v: ArrayLike) -> tuple[float, float, float]:
        x, y, z = (turn @ np.asarray(v, dtype=float)).tolist()
        return (x, y, z)

    def place(v: ArrayLike) -> tuple[float, float, float]:
        return move(np.asarray(v, dtype=float) - origin)

    def motion_of(motion: Motion) -> Motion:
        if isinstance(motion, Pendulum):
            axis, down = move(motion.axis), move(motion.down)
            return replace(motion, pivot=place(motion.pivot), axis=axis, down=down)
        assert isinstance(motion, SolidQuadratic)
        return SolidQuadratic(
            place(motion.position),
            move(motion.velocity),
            move(motion.acceleration),
            quaternion_of(turn @ rotation_of(motion.orientation)),
            move(motion.spin),
        )

    def moved(body: Body) -> Body:
        return replace(body, motion=motion_of(body.motion))

    return moved


def quaternion_of(rotation: np.ndarray) -> tuple[float, float, float, float]:
    """Unit quaternion (w, x, y, z) of a rotation matrix (3, 3), the inverse of `rotation_of`.

    The largest of the four numbers is positive; it is taken from the diagonal and the others by
    division (S. W. Shepperd, J. Guidance and Control 1, 1978), so none is a difference of nearly
    equal numbers.
    """
    r = rotation.tolist()
    trace = r[0][0] + r[1][1] + r[2][2]
    squares = (trace, r[0][0], r[1][1], r[2][2])
    k = max(range(4), key=squares.__getitem__)
    if k == 0:
        q = [1.0 + trace, r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1]]
    else:
        a, b, c = k - 1, k % 3, (k + 1) % 3
        q = [r[c][b] - r[b][c], 0.0, 0.0, 0.0]
        q[1 + a] = 1.0 + r[a][a] - r[b][b] - r[c][c]
        q[1 + b] = r[b][a] + r[a][b]
        q[1 + c] = r[c][a] + r[a][c]
    length = math.sqrt(math.fsum(x * x for x in q))
    w, x, y, z = (value / length for value in q)
    return (w, x, y, z)
