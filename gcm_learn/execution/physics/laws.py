"""Where bodies are at every step of the physics, while nothing has touched them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.compiled import njit
from gcm_learn.scene import HAND, PART, Scene, poses_at


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
    from scipy.spatial.transform import Rotation

    poses = np.zeros((time.size, len(scene.bodies.rows), 12))
    poses[:, :, 3::4] = 1.0  # spheres are not turned
    _tabulate(scene.bodies, time, poses)
    places = poses[:, :, :3] * metres
    turned = Rotation.from_matrix(poses[:, :, 3:].reshape(-1, 3, 3))
    turns = np.roll(turned.as_quat(), 1, axis=1).reshape(*poses.shape[:2], 4)
    met = scene.bodies.rows[:, PART] == HAND
    step = time[1] - time[0]
    speeds = np.gradient(places[:, met], step, axis=0, edge_order=2)
    spins = _spins(poses[:, met, 3:].reshape(time.size, -1, 3, 3), step)
    targets = np.concatenate([places[:, met], turns[:, met]], axis=-1)
    moves = np.concatenate([speeds, spins], axis=-1)
    return Laws(
        places[:, ~met], turns[:, ~met],
        targets.reshape(time.size, -1), moves.reshape(time.size, -1),
    )  # fmt: skip


def _spins(turns: np.ndarray, step: float) -> np.ndarray:
    """Angular velocities (n, m, 3) of rotations (n, m, 3, 3), each until the next one [rad/s]."""
    from scipy.spatial.transform import Rotation

    between = np.swapaxes(turns[:-1], -1, -2) @ turns[1:]
    if not between.size or (between == np.eye(3)).all():
        return np.zeros(turns.shape[:-1])
    spins = Rotation.from_matrix(between.reshape(-1, 3, 3)).as_rotvec() / step
    spins = spins.reshape(*between.shape[:2], 3)
    return np.concatenate([spins, spins[-1:]])


@njit
def _tabulate(bodies, time, poses):
    for k in range(time.size):
        poses_at(bodies, time[k], poses[k])
