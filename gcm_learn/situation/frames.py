"""Rotations and frames as matrices, and motion laws seen in other frames."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from gcm_learn.situation.motion import Pendulum, SolidMotion, SolidQuadratic
from gcm_learn.situation.situation import AnySituation, Plane
from gcm_learn.situation.spatial_arm import SpatialArm

_IDENTITY = np.eye(3)
_ITS_MIRROR = np.diag([1.0, -1.0, 1.0])  # a body reflected in its own xz-plane


def rotation_of(quaternion: Sequence[float]) -> np.ndarray:
    """Rotation matrix (3, 3) of a unit quaternion (w, x, y, z)."""
    length = math.hypot(*quaternion)
    w, x, y, z = (part / length for part in quaternion)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def plane_frame(plane: Plane | None) -> tuple[np.ndarray, np.ndarray]:
    """Rotation world -> arm plane (rows x, y, normal) and the plane's origin."""
    if plane is None:
        return _IDENTITY, np.zeros(3)
    (a, b, c), (d, e, f) = plane.x, plane.y
    normal = (b * f - c * e, c * d - a * f, a * e - b * d)
    return np.array([plane.x, plane.y, normal]), np.asarray(plane.origin)


def arm_frame(situation: AnySituation) -> tuple[np.ndarray, np.ndarray]:
    """Rotation world -> the arm's coordinates, and their origin in the world: the shoulder.

    Returns
    -------
    rotation : (3, 3) ndarray
        Its rows are the arm's axes: x, y and normal of the arm plane, or x, y, z of the base.
    origin : (3,) ndarray
    """
    if isinstance(situation.arm, SpatialArm):
        base = situation.arm.base
        return rotation_of(base.rotation).T, np.asarray(base.origin)
    return plane_frame(situation.plane)


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


def carried(motion: SolidMotion, turn: np.ndarray, origin: np.ndarray) -> SolidMotion:
    """A motion law seen in other coordinates: what was at p is at ``turn @ (p - origin)``.

    Parameters
    ----------
    motion : SolidMotion
    turn : (3, 3) ndarray
        Orthogonal.  Where it is a reflection, the body is one that its own xz-plane mirrors, as
        all our solids are: it comes out reflected in that plane as well, so it is turned only.
    origin : (3,) ndarray
    """
    reflected = bool(np.linalg.det(turn) < 0.0)

    def move(v: ArrayLike) -> tuple[float, float, float]:
        x, y, z = (turn @ np.asarray(v, dtype=float)).tolist()
        return (x, y, z)

    def place(v: ArrayLike) -> tuple[float, float, float]:
        return move(np.asarray(v, dtype=float) - origin)

    def axial(v: ArrayLike) -> tuple[float, float, float]:
        """Axes of rotation, which reflections turn round as well."""
        return move(-np.asarray(v, dtype=float) if reflected else v)

    if isinstance(motion, Pendulum):
        axis, down = axial(motion.axis), move(motion.down)
        return replace(motion, pivot=place(motion.pivot), axis=axis, down=down)
    rotation = turn @ rotation_of(motion.orientation)
    return SolidQuadratic(
        place(motion.position),
        move(motion.velocity),
        move(motion.acceleration),
        quaternion_of(rotation @ _ITS_MIRROR if reflected else rotation),
        axial(motion.spin),
    )
