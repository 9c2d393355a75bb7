"""Pieces of motion in a time that runs backwards."""

from __future__ import annotations

import numpy as np

from gcm_learn.scene import bodies as k
from gcm_learn.scene.bodies import Bodies, pose_at


def reverse_pieces(bodies: Bodies, rows: np.ndarray, angles: np.ndarray, end: float) -> None:
    """Write the pieces of bodies for which at t happens what happens at end - t.

    Parameters
    ----------
    bodies : Bodies
    rows : (n, COLUMNS) ndarray
        Rows of the reversed bodies; those of bodies with pieces are renewed.
    angles : (k, m, 2) ndarray
        Their tables; the entries of bodies with pieces are renewed.
    end : float
        Time at which the reversed motion begins [s].
    """
    for b in np.flatnonzero(rows[:, k.PIECES] > 0.0):
        entry, count = int(rows[b, k.SWING]), int(rows[b, k.PIECES])
        mine = bodies.angles[entry, : k.PIECE_ROWS * count].reshape(count, -1)
        mine = mine[(mine[:, k.START] < end) | (mine[:, k.START] == 0.0)]
        until = np.append(mine[1:, k.START], end)
        jumps = np.vstack([mine[1:, k.JUMP : k.JUMP_TURN + 1], np.zeros((1, 2))])
        turned = (_reversed(piece, t) for piece, t in zip(mine, until, strict=True))
        backwards = np.array(list(turned))[::-1].copy()
        backwards[:, k.START] = end - until[::-1]
        backwards[:, k.JUMP : k.JUMP_TURN + 1] = jumps[::-1]
        rows[b, k.PIECES] = len(mine)
        rows[b, k.POSITION : k.TURN + 9] = backwards[0, k.POSITION : k.TURN + 9]
        angles[entry] = 0.0
        angles[entry, : k.PIECE_ROWS * len(mine)] = backwards.reshape(-1, 2)


def _reversed(piece: np.ndarray, until: float) -> np.ndarray:
    """Return a piece as it runs from its end back to its start."""
    span = until - piece[k.START]
    row = np.zeros((1, k.COLUMNS))
    row[0, k.SWING] = -1.0
    row[0, k.POSITION : k.TURN + 9] = piece[k.POSITION : k.TURN + 9]
    poses = np.zeros((1, 12))
    pose_at(k.no_bodies()._replace(rows=row), 0, span, poses)
    made = piece.copy()
    made[k.POSITION : k.POSITION + 3], made[k.TURN : k.TURN + 9] = poses[0, :3], poses[0, 3:]
    speed = piece[k.VELOCITY : k.VELOCITY + 3] + span * piece[k.ACCELERATION : k.ACCELERATION + 3]
    made[k.VELOCITY : k.VELOCITY + 3] = -speed
    made[k.SPIN : k.SPIN + 3] *= -1.0
    return made
