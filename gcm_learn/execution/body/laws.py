"""Poses of bodies at every step of the physics, while nothing has touched them, and catches.

Catches are judged as everywhere: by the distance of the hand to a target's solid. Scenes come as
plain tuples, since finding the types of named ones takes long; the types choose the kernels.
"""

from __future__ import annotations

from functools import cache
from typing import Any, NamedTuple

import numpy as np

from gcm_learn.arms.limbs import hand_of, place
from gcm_learn.collision.distance import point_distance
from gcm_learn.compiled import njit
from gcm_learn.motion.joint_interception import met_at
from gcm_learn.scene import HAND, PART, Bodies, Scene, poses_at


class Laws(NamedTuple):
    """Poses and velocities at n instants, in the frame of the base and in metres."""

    obstacles: np.ndarray
    """(n, o, 3) [m]"""
    turns: np.ndarray
    """Of obstacles (n, o, 4): quaternions w, x, y, z."""
    targets: np.ndarray
    """(n, 7 m): position and quaternion of one target after the other."""
    moves: np.ndarray
    """(n, 6 m): velocity, and angular velocity in the body's own frame."""


def laws(scene: Scene, time: np.ndarray, metres: float) -> Laws:
    """Tabulate the motion laws of a scene's bodies at equidistant times (n,) [s]."""
    poses = np.zeros((time.size, len(scene.bodies.rows), 12))
    poses[:, :, 3::4] = 1.0  # spheres are not turned
    turns = np.empty((*poses.shape[:2], 4))
    _tabulate(scene.bodies, time, poses, turns)
    met = scene.bodies.rows[:, PART] == HAND
    places, step = poses[:, :, :3] * metres, time[1] - time[0]
    moves = np.empty((time.size, met.sum(), 6))
    moves[..., :3] = np.gradient(places[:, met], step, axis=0, edge_order=2)
    _spin(turns[:, met], step, moves)
    moves[-1, :, 3:] = moves[-2, :, 3:]
    targets = np.concatenate([places[:, met], turns[:, met]], axis=-1)
    return Laws(
        places[:, ~met], turns[:, ~met],
        targets.reshape(time.size, -1), moves.reshape(time.size, -1),
    )  # fmt: skip


@njit
def _tabulate(bodies, time, poses, turns):
    for k in range(time.size):
        poses_at(bodies, time[k], poses[k])
        for b in range(poses.shape[1]):
            _quaternion(poses[k, b, 3:], turns[k, b])


@njit(_nrt=False)
def _quaternion(r, out):
    """Write the unit quaternion w, x, y, z of a rotation (9,); see `situation.quaternion_of`."""
    trace = r[0] + r[4] + r[8]
    if trace >= max(r[0], r[4], r[8]):
        out[0], out[1], out[2], out[3] = 1.0 + trace, r[7] - r[5], r[2] - r[6], r[3] - r[1]
    else:
        for a in range(3):
            b, c = (a + 1) % 3, (a + 2) % 3
            if r[4 * a] == max(r[0], r[4], r[8]):
                out[0] = r[3 * c + b] - r[3 * b + c]
                out[1 + a] = 1.0 + r[4 * a] - r[4 * b] - r[4 * c]
                out[1 + b] = r[3 * b + a] + r[3 * a + b]
                out[1 + c] = r[3 * c + a] + r[3 * a + c]
                break
    out /= np.sqrt(out[0] ** 2 + out[1] ** 2 + out[2] ** 2 + out[3] ** 2)


@njit(_nrt=False)
def _spin(turns, step, moves):
    """Write angular velocities in the bodies' frames [rad/s] to moves (n, m, 3:), but the last.

    Each leads to the next instant: it is the logarithm of the turn between.
    """
    for k in range(turns.shape[0] - 1):
        for b in range(turns.shape[1]):
            p, q, out = turns[k, b], turns[k + 1, b], moves[k, b, 3:]
            w = p[0] * q[0] + p[1] * q[1] + p[2] * q[2] + p[3] * q[3]
            out[0] = p[0] * q[1] - p[1] * q[0] - p[2] * q[3] + p[3] * q[2]
            out[1] = p[0] * q[2] - p[2] * q[0] - p[3] * q[1] + p[1] * q[3]
            out[2] = p[0] * q[3] - p[3] * q[0] - p[1] * q[2] + p[2] * q[1]
            sine = np.sqrt(out[0] ** 2 + out[1] ** 2 + out[2] ** 2)
            angle = np.arctan2(sine, abs(w)) / sine if sine > 0.0 else 1.0
            out *= np.copysign(2.0 / step * angle, w)  # q and -q are the same turn


@cache
def first_met_in(limb_type: Any, limits_type: Any) -> Any:
    """Return the kernel that finds a catch, for types of limbs and of limits."""

    @njit
    def first_met(parts, joints, first, last, step, poses):
        """First step from `first` to `last` with a target within grasp, and which; -1 if none."""
        scene = Scene(Bodies(*parts[0]), limb_type(*parts[1]), limits_type(*parts[2]))
        for k in range(first, last + 1):
            b = met_at(scene, joints[k], k * step, scene.limits.grasp, poses)
            if b >= 0:
                return k, b
        return -1, -1

    return first_met


@njit
def grasped(scene, b, joints, poses, room):
    """Return whether body b is within grasp at all joints (n, dof) and poses (n, 12) of the body.

    Parameters
    ----------
    room : (bodies, 12) ndarray
        Its row b is overwritten.
    """
    for k in range(joints.shape[0]):
        room[b] = poses[k]
        x, y, z = hand_of(scene.limb, place(scene.limb, joints[k]))
        if point_distance(scene.bodies, room, b, x, y, z) > scene.limits.grasp:
            return False
    return True
