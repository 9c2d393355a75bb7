"""Places of contact: the deepest overlap at t = 0, and where a planar limb ends in an obstacle."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from gcm_learn import arms
from gcm_learn.arms import CHAIN, IDENTITY, PLANAR, ByKind, elbow_of, off_segment
from gcm_learn.collision import segment_distance
from gcm_learn.motion.failures import Failure, Reason
from gcm_learn.motion.movement import Movement
from gcm_learn.motion.rules import start_clearance
from gcm_learn.scene import LIMB, PART, Scene, gap, pack, poses_at
from gcm_learn.situation import AnySituation, Situation

_POINTS, _ROUNDS = 33, 3  # of an axis that are asked at once; how often, always more closely
_Overlap = tuple[float, str, str]
_SAMPLES = 101  # of each part of the limb, among which the nearest one is found


def why_blocked(situation: AnySituation, scene: Scene) -> Reason:
    """Return the deepest overlap of an arm that is blocked at the start, as a reason.

    Depths are in the arm's unit.
    """
    depth, first, second = max(_overlaps(situation, scene))
    depth = max(depth, 0.0)  # it is blocked at the very contact, which rounding may miss
    return Failure.START_BLOCKED.with_numbers(first=first, second=second, depth=f"{depth:.3g}")


def _overlaps(situation: AnySituation, scene: Scene) -> Iterator[_Overlap]:
    """Yield depth, negative without a touch, and names of every pair that is checked."""
    arm, bodies, kind = situation.arm, scene.bodies, _KINDS.of(situation)
    axes, radii = kind.links(arm)
    poses = np.zeros((len(situation.bodies), 12))
    poses[:, 3:] = np.eye(3).ravel()  # discs and spheres leave it so
    poses_at(bodies, 0.0, poses)
    ignored = set(getattr(arm, "ignored", ()))
    for b, body in enumerate(situation.bodies):
        centre, turn = poses[b, :3], poses[b, 3:].reshape(3, 3)
        for i, axis in enumerate((axes - centre) @ turn):
            if body.role == "obstacle" and (i, body.name) not in ignored:
                off = off_segment(np.zeros((1, 3)), *axis)[0] - body.shape.bounding_radius
                margin = 0.0 if body.margin is None else body.margin.now
                kept = radii[i] + margin
                off = _least(partial(_gaps, bodies, b), axis) if off <= kept else off
                called = f"{body.name!r} with its margin" if margin else repr(body.name)
                yield kept - off, kind.name(arm, i), called
    for i, j in arm.model.self_collision if hasattr(arm, "model") else ():
        off = _least(partial(off_segment, start=axes[j, 0], end=axes[j, 1]), axes[i])
        yield radii[i] + radii[j] - off, kind.name(arm, i), kind.name(arm, j)
    if kind.itself:
        yield -0.999 * start_clearance(scene), "the limb", "itself"


def _least(distances: Callable[[np.ndarray], np.ndarray], axis: np.ndarray) -> float:
    """Return the least value on a segment (2, 3) of a function of points (k, 3)."""
    low, high, best = 0.0, 1.0, np.inf
    for _ in range(_ROUNDS):
        shares = np.linspace(low, high, _POINTS)
        found = distances(axis[0] + shares[:, None] * (axis[1] - axis[0]))
        k = int(np.argmin(found))
        best = min(best, float(found[k]))
        low, high = shares[max(k - 1, 0)], shares[min(k + 1, _POINTS - 1)]
    return best


def _gaps(bodies: Any, b: int, points: np.ndarray) -> np.ndarray:
    """Return signed distances (k,) of points (k, 3) in a body's frame."""
    return np.array([gap(bodies, b, *point) for point in points])


def _planar_links(arm: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return ends (2, 2, 3) and radii (2,) of upper arm and forearm."""
    elbow = arms.elbow_position(arm.hand, arm.upper_arm, arm.elbow)
    joints = np.zeros((3, 3))
    joints[1, :2], joints[2, :2] = elbow, arm.hand
    return np.stack([joints[:2], joints[1:]], axis=1), np.full(2, arm.thickness)


def _links(arm: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return ends (m, 2, 3) in the frame of the base and radii (m,) of an arm's links."""
    ends, radii = arms.links_along(replace(arm, base=IDENTITY), [arm.joints])
    return ends[0], radii


class _LinkKind(NamedTuple):
    """How the links of a kind of arm are called and found."""

    name: Callable[[Any, int], str]
    links: Callable[[Any], tuple[np.ndarray, np.ndarray]] = _links
    itself: bool = False
    """True if the arm may overlap itself in pairs that are not known here."""


def _bone(arm: Any, i: int) -> str:
    return ("upper arm", "forearm")[i]


_KINDS = ByKind(
    {
        PLANAR: _LinkKind(_bone, _planar_links),
        CHAIN: _LinkKind(lambda arm, i: str(arm.model.named(i))),
    },
    default=_LinkKind(lambda arm, i: f"link {i}", itself=True),
)


def collided_part(situation: Situation, path: Movement) -> str:
    """Return the part of the limb that is nearer to an obstacle at the end of a path."""
    elbow, hand, distance = _at_end(situation, path)
    return "forearm" if distance(elbow, hand) <= distance(np.zeros(2), elbow) else "upper arm"


def collision_point(situation: Situation, path: Movement) -> np.ndarray:
    """Return the point (2,) of the limb that is nearest to an obstacle at the end of a path."""
    elbow, hand, distance = _at_end(situation, path)
    shares = np.linspace(0.0, 1.0, _SAMPLES)[:, None]
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
