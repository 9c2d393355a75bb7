"""Numbers of the hand's path, for each kind of arm; lengths in forearms."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from gcm_learn.arms import SIDE, SPATIAL, ByKind, elbow_of, kind_of
from gcm_learn.collision import segment_distance
from gcm_learn.evaluation.methods import Result
from gcm_learn.motion import PARTS, Movement, clearance, joint_turns
from gcm_learn.scene import LIMB, PART, pack, poses_at
from gcm_learn.situation import AnySituation, Situation

NAMES = ("end", "length", "clearance", "peak_hand", "peak_shoulder", "peak_elbow", "part")
_POINTS = 101  # of each part of the limb, or of a path, among which an extreme one is found


def hand_movement(situation: Situation, result: Result, path: Movement) -> dict[str, Any]:
    """Return the numbers of a planar arm's path."""
    arm, spans = situation.arm, np.maximum(np.diff(path.time), 1e-12)
    out: dict[str, Any] = {
        "end": path.duration,
        "length": path.length,
        "clearance": result.clearance,
    }
    if result.clearance is None and result.outcome == "caught":
        out["clearance"], _ = clearance(situation, path)
    if len(spans):
        steps = np.sqrt((np.diff(path.hand, axis=0) ** 2).sum(axis=1))
        turns = joint_turns(path.hand, arm.upper_arm, SIDE[arm.elbow], PARTS) / spans[:, None]
        out["peak_hand"] = float((steps / spans).max())
        out["peak_shoulder"], out["peak_elbow"] = (float(v) for v in turns.max(axis=0))
    if result.outcome == "touched":
        out["part"] = collided_part(situation, path)
    return out


_UNIT: ByKind[Callable[[Any], float]] = ByKind(
    {SPATIAL: lambda arm: float(np.linalg.norm(arm.forearm))},
    default=lambda arm: float(kind_of(arm).pack(arm, ()).length),
)
"""Length that counts as 1 in tables, in the unit of the arm."""


def joint_movement(situation: AnySituation, result: Result, path: Movement) -> dict[str, Any]:
    """Return the numbers of the path of an arm that moves in its joints.

    The first half of the joints counts as the shoulder's, the others as the elbow's.
    """
    unit, gap = _UNIT.of(path.arm)(path.arm), result.clearance
    time = np.linspace(0.0, path.duration, _POINTS)
    span = max(path.duration / (_POINTS - 1), 1e-12)
    speeds = np.linalg.norm(np.diff(path.hand_at(time), axis=0), axis=1) / span
    rates = np.abs(np.diff(path.joints_at(time), axis=0)).max(axis=0) / span
    half = (len(rates) + 1) // 2
    return {
        "end": path.duration,
        "length": path.length / unit,
        "clearance": None if gap is None else gap / unit,
        "peak_hand": float(speeds.max()) / unit,
        "peak_shoulder": float(rates[:half].max()),
        "peak_elbow": float(rates[half:].max(initial=0.0)),
    }


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
