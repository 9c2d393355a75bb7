"""Places of bodies in the world, and the ground among them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from gcm_learn.arms import Chain, SpatialArm
from gcm_learn.scene import pack_bodies, poses_at
from gcm_learn.situation import Body, Box, Situation, arm_frame

JointSituation = Situation[SpatialArm] | Situation[Chain]
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
    bodies, (axes, origin) = pack_bodies(situation), arm_frame(situation)
    instants = np.atleast_1d(np.asarray(times, dtype=float))
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
