"""Points of a planar limb that touch an obstacle."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from gcm_learn.arms import elbow_of
from gcm_learn.collision import segment_distance
from gcm_learn.motion.movement import Movement
from gcm_learn.scene import LIMB, PART, pack, poses_at
from gcm_learn.situation import Situation

_POINTS = 101  # of each part of the limb, among which the nearest one is found


def collided_part(situation: Situation, path: Movement) -> str:
    """Return the part of the limb that is nearer to an obstacle at the end of a path."""
    elbow, hand, distance = _at_end(situation, path)
    return "forearm" if distance(elbow, hand) <= distance(np.zeros(2), elbow) else "upper arm"


def collision_point(situation: Situation, path: Movement) -> np.ndarray:
    """Return the point (2,) of the limb that is nearest to an obstacle at the end of a path."""
    elbow, hand, distance = _at_end(situation, path)
    shares = np.linspace(0.0, 1.0, _POINTS)[:, None]
    points = np.concatenate([shares * elbow, elbow + shares * (hand - elbow)])
    return np.asarray(min(points, key=lambda point: distance(point, point)))


def _at_end(
    situation: Situation, path: Movement
) -> tuple[np.ndarray, np.ndarray, Callable[[np.ndarray, np.ndarray], float]]:
    """Return elbow (2,) and hand (2,) at the end of a path, and distances of segments there."""
    (bodies, limb, _), hand = pack(situation), path.hand[-1]
    poses = np.zeros((len(situation.bodies), 12))
    poses_at(bodies, path.duration, poses)
    obstacles = np.flatnonzero(bodies.rows[:, PART] == LIMB)

    def distance(start: np.ndarray, end: np.ndarray) -> float:
        near = (segment_distance(bodies, poses, b, *start, *end) for b in obstacles)
        return float(min(near, default=np.inf))

    return np.array(elbow_of(hand[0], hand[1], limb.rho, limb.side)), hand, distance
