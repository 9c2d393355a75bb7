"""The check that stands behind the word "caught"."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from gcm_learn.arms import PLANAR, ByKind
from gcm_learn.arms.planar_limb import joints_of
from gcm_learn.collision.sweep import least_distance
from gcm_learn.compiled import njit
from gcm_learn.motion import holding, joint_verification, smoothing
from gcm_learn.motion.failures import Failure, Reason
from gcm_learn.motion.movement import Movement
from gcm_learn.motion.rules import CATCH_SAFETY, Rules
from gcm_learn.scene import Scene, pack
from gcm_learn.scene.bodies import MARGIN, MARGIN_RATE, pose_at
from gcm_learn.scene.shapes.choice import gap_in_plane
from gcm_learn.situation import Situation

SPEED_TOLERANCE = 1e-7  # relative; the contract grants 1e-6
PARTS = 16  # pieces of a segment on which joint speeds are measured
LARGEST_TURN = 0.5  # of a joint between two samples: more is a jump, e.g. at the shoulder [rad]
HOLE_MARGIN = 1e-3  # chords between samples stay out of the hole [forearm lengths]
STRAY = 8e-4  # of hands on joints that are linear between samples, from the path [forearm lengths]
LONGEST = 600.0  # time after the horizon in which a movement may go on [s]
_ROUNDING = 1e-9  # relative, of the ring's radii
_LATER = 5e-10  # of times, relative; the contract grants 1e-9
_RIM = 1e-6  # nearer than this to the ring's rims joint speeds have no bound [forearm lengths]


@dataclass(frozen=True)
class Verdict:
    """Verdict on a trajectory's promise of "caught"."""

    good: bool
    clearance: float
    """Smallest distance of limb and obstacles, less the thickness; only the order of magnitude of
    the failure when `good` is False."""
    reason: Reason | None = None
    """Reason for a rejection."""
    collision_time: float | None = None
    """Time of the limb's contact with an obstacle [s]; None if it is free or otherwise wrong."""


@njit
def _rates_at(x, y, dx, dy, rho, side):
    """Turn of both joints per length of the hand's way at (x, y) in the unit direction (dx, dy).

    The elbow's angle depends on the hand's radius only, the shoulder's also on its direction.  At
    the rims of the ring both rates are unbounded; the answer there is 0 and means nothing.
    """
    r = np.sqrt(x * x + y * y)
    if r < _RIM or r > rho + 1.0 - _RIM or r < abs(rho - 1.0) + _RIM:
        return 0.0, 0.0
    outward, around = (x * dx + y * dy) / r, (x * dy - y * dx) / (r * r)
    cosine = (r * r + rho * rho - 1.0) / (2.0 * rho * r)  # of the angle at the shoulder
    bend = (r * r - rho * rho + 1.0) / (2.0 * rho * r * r) / np.sqrt(1.0 - cosine * cosine)
    elbow = (r * r - rho * rho - 1.0) / (2.0 * rho)  # cosine of the elbow's angle
    shoulder = abs(around + side * bend * outward)
    return shoulder, abs(outward) * r / (rho * np.sqrt(max(1.0 - elbow * elbow, 1e-12)))


@njit
def joint_turns(hand, rho, side, parts):
    """Return each joint's turn over every segment at the joint's largest rate in that segment.

    That rate is the largest of the mean rates over `parts` equal pieces, and of the rates at their
    ends and where the segment is nearest to the shoulder.

    Returns
    -------
    (n - 1, 2) ndarray
        [rad]
    """
    n = hand.shape[0]
    out = np.zeros((n - 1, 2))
    piece = np.empty((parts + 1, 2))
    for k in range(n - 1):
        x, y = hand[k, 0], hand[k, 1]
        dx, dy = hand[k + 1, 0] - x, hand[k + 1, 1] - y
        length = np.sqrt(dx * dx + dy * dy)
        if length == 0.0:
            continue
        for p in range(parts + 1):
            piece[p, 0], piece[p, 1] = x + p / parts * dx, y + p / parts * dy
        joints = joints_of(piece, rho, side)
        for p in range(parts):
            for a in range(2):
                out[k, a] = max(out[k, a], parts * abs(joints[p + 1, a] - joints[p, a]))
        nearest = min(max(-(x * dx + y * dy) / (length * length), 0.0), 1.0)
        for p in range(parts + 2):
            s = p / parts if p <= parts else nearest
            shoulder, elbow = _rates_at(x + s * dx, y + s * dy, dx / length, dy / length, rho, side)
            out[k, 0] = max(out[k, 0], shoulder * length)
            out[k, 1] = max(out[k, 1], elbow * length)
    return out


@njit(_nrt=False)
def nearest_to_shoulder(hand):
    """Smallest distance of a polyline (n, 2) to the origin."""
    best = np.sqrt(hand[0, 0] ** 2 + hand[0, 1] ** 2)
    for k in range(hand.shape[0] - 1):
        x, y = hand[k, 0], hand[k, 1]
        dx, dy = hand[k + 1, 0] - x, hand[k + 1, 1] - y
        length2 = dx * dx + dy * dy
        s = min(max(-(x * dx + y * dy) / length2, 0.0), 1.0) if length2 > 0.0 else 0.0
        best = min(best, np.sqrt((x + s * dx) ** 2 + (y + s * dy) ** 2))
    return best


NOTHING, ELSEWHERE, LATE, OUTSIDE, ROUND, FAST, TURNS, MISSED, TOUCHED, ASTRAY = range(10)
FAULTS = {
    ELSEWHERE: Failure.WRONG_START,
    LATE: Failure.LATE,
    OUTSIDE: Failure.OUTSIDE,
    ROUND: Failure.SINGULAR,
    FAST: Failure.HAND_SPEED,
    TURNS: Failure.JOINT_SPEED,
    MISSED: Failure.MISSED,
    TOUCHED: Failure.COLLISION,
    ASTRAY: Failure.ASTRAY,
}


FAULTS_OF_JOINTS = {
    joint_verification.ELSEWHERE: Failure.WRONG_START,
    joint_verification.LATE: Failure.LATE,
    joint_verification.RANGE: Failure.JOINT_RANGE,
    joint_verification.JOINT: Failure.JOINT_SPEED,
    joint_verification.FORCED: Failure.JOINT_ACCELERATION,
    joint_verification.FAST: Failure.HAND_SPEED,
    joint_verification.MISSED: Failure.MISSED,
    joint_verification.TOUCHED: Failure.COLLISION,
}
_NO_RATES = np.empty((0, 4))


class Ask(NamedTuple):
    """Requirements on a movement that goes on after its catches: the catches, limits and end."""

    catches: tuple[tuple[int, float, float], ...]
    """Targets, when each is caught and when its hold ends [s]."""
    jerk: np.ndarray | None
    """(n,): limits, if there are any."""
    forces: np.ndarray
    """(n,): accelerations at t = 0."""
    stops: bool
    """True if the arm has to rest at the end."""
    end_by: float
    """Time after which it may not go on [s]."""

    @classmethod
    def of(cls, situation: Any, catches: Sequence[tuple[int, float, float]]) -> Ask:
        """Return a situation's requirements on a movement with the given catches."""
        arm, end_by = situation.arm, situation.end_by
        jerk = None if arm.max_joint_jerk is None else np.array(arm.max_joint_jerk)
        forces = np.array(arm.joint_accelerations or (0.0,) * len(arm.joints))
        latest = situation.horizon + LONGEST
        end_by = latest if end_by is None else min(end_by, latest)
        return cls(tuple(catches), jerk, forces, situation.end == "rest", end_by)


def verify(
    scene: Scene, rules: Rules, trajectory: Movement, body: int, ask: Ask | None = None
) -> Verdict:
    """Check a trajectory against everything that "caught" promises.

    Parameters
    ----------
    scene : Scene
    rules : Rules
        Of the scene; its `touch` is the distance that the limb keeps.
    trajectory : Movement
        Of the scene's kind of arm.
    body : int
        Index of the target that is caught at the trajectory's end, if there is no `ask`.
    ask : Ask, optional
        For movements that go on after the catch; only of arms that move in their joints.

    Returns
    -------
    Verdict
    """
    if ask is None:
        failure, distance, when = _JUDGES.of(scene)(scene, rules, trajectory, body)
    else:
        failure, distance, when = _judge_end(scene, rules, trajectory, ask)
    if failure is None:
        return Verdict(True, np.inf if distance > 1e200 else distance - scene.limb.thickness)
    reason = failure.with_numbers(when=when)
    if failure is Failure.COLLISION:
        return Verdict(False, distance - scene.limb.thickness, reason, collision_time=when)
    return Verdict(False, 0.0, reason)


def _judge_hand(
    scene: Scene, rules: Rules, trajectory: Movement, body: int
) -> tuple[Failure | None, float, float]:
    """Return the failure of a planar movement or None, the least distance, and a time [s]."""
    fault, distance, when = _judge(
        scene, rules.touch, trajectory.time, trajectory.hand, trajectory.joints, body
    )
    return FAULTS.get(fault), distance, when


def judge_joints(
    scene: Scene, rules: Rules, trajectory: Movement, body: int
) -> tuple[Failure | None, float, float]:
    """Return the failure of a movement in joints or None, the least distance, and a time [s]."""
    given, limits = trajectory.rates, scene.limits
    if given is None and np.isfinite(limits.joint_acceleration).any():
        return Failure.JOINT_ACCELERATION, 0.0, 0.0
    rates = _NO_RATES if given is None else given
    moves = trajectory.time, trajectory.joints, rates
    fault, distance, when = joint_verification.judge(scene, rules.touch, *moves, body)
    rows = scene.bodies.rows
    if fault == joint_verification.NOTHING and rows[:, MARGIN : MARGIN_RATE + 1].any():
        rows = rows.copy()  # clearances count without margins
        rows[:, MARGIN : MARGIN_RATE + 1] = 0.0
        bare = scene._replace(bodies=scene.bodies._replace(rows=rows))
        distance = joint_verification.judge(bare, rules.touch, *moves, body)[1]
    return FAULTS_OF_JOINTS.get(fault), distance, when


FAULTS_OF_HOLDS = {
    holding.LOST: Failure.NOT_HELD,
    holding.SLIPPED: Failure.SLIPS,
    holding.TURNED: Failure.TURNS_AWAY,
}


def _judge_end(
    scene: Scene, rules: Rules, trajectory: Movement, ask: Ask
) -> tuple[Failure | None, float, float]:
    """Judge a movement that goes on after its catches; the results are as of `judge_joints`."""
    moves, limits, end = trajectory, scene.limits, trajectory.duration
    if moves.rates is None:
        return Failure.JOINT_ACCELERATION, 0.0, 0.0
    if end > ask.end_by * (1.0 + _LATER):
        return Failure.ENDS_LATE, 0.0, end
    if ask.stops and not smoothing.rests_at_end(limits, ask.jerk, moves):
        return Failure.NOT_AT_REST, 0.0, end
    if ask.jerk is not None:
        failure = smoothing.jerk_fault(limits, ask.jerk, moves, ask.forces)
        if failure is not None:
            return failure, 0.0, 0.0
    for body, time, until in ask.catches:
        if time > limits.horizon:
            return Failure.LATE, 0.0, time
        fault = holding.catch_fault(scene, body, time, until, moves.time, moves.joints, moves.rates)
        if fault != holding.KEPT:
            return FAULTS_OF_HOLDS[fault], 0.0, time
    return judge_joints(scene, rules, moves, -1)


_JUDGES = ByKind({PLANAR: _judge_hand}, default=judge_joints)


@njit(_nrt=False)
def _goes_astray(hand, joints, rho):
    """Return whether joints, linear between samples, lead the hand off its straight way.

    The deviation is largest about half way between two samples.
    """
    for k in range(hand.shape[0] - 1):
        shoulder = 0.5 * (joints[k, 0] + joints[k + 1, 0])
        forearm = shoulder + 0.5 * (joints[k, 1] + joints[k + 1, 1])
        x = rho * np.cos(shoulder) + np.cos(forearm) - 0.5 * (hand[k, 0] + hand[k + 1, 0])
        y = rho * np.sin(shoulder) + np.sin(forearm) - 0.5 * (hand[k, 1] + hand[k + 1, 1])
        if x * x + y * y > STRAY * STRAY:
            return True
    return False


@njit
def _judge(scene, touch, time, hand, joints, body):
    """Return the first broken promise or NOTHING, the least distance, and when [s]."""
    last = time.size - 1
    fault = _hand_fault(scene, time, hand, joints)
    if fault == NOTHING and _turns_too_fast(scene, time, hand):
        fault = TURNS
    if fault == NOTHING and _goes_astray(hand, joints, scene.limb.rho):
        fault = ASTRAY
    if fault == NOTHING:
        poses = np.zeros((scene.bodies.rows.shape[0], 12))
        pose_at(scene.bodies, body, time[last], poses)
        away = gap_in_plane(scene.bodies, poses, body, hand[last, 0], hand[last, 1])
        if away > scene.limits.grasp - 0.5 * CATCH_SAFETY:
            fault = MISSED
    if fault != NOTHING:
        return fault, 0.0, time[last]
    distance, when = least_distance(scene, time, hand, touch, RESOLUTION)
    return TOUCHED if distance <= touch else NOTHING, distance, when


@njit(_nrt=False)
def _hand_fault(scene, time, hand, joints):
    """Return the first broken promise about the hand's path, or NOTHING."""
    limb, limits, last = scene.limb, scene.limits, time.size - 1
    if time[0] != 0.0 or hand[0, 0] != limb.x or hand[0, 1] != limb.y:
        return ELSEWHERE
    if time[last] > limits.horizon:
        return LATE
    for k in range(last + 1):
        if np.sqrt(hand[k, 0] ** 2 + hand[k, 1] ** 2) > limb.far * (1.0 + _ROUNDING):
            return OUTSIDE
    if last > 0 and nearest_to_shoulder(hand) < limb.near * (1.0 - _ROUNDING):
        return OUTSIDE
    for k in range(last):
        for joint in range(2):
            if abs(joints[k + 1, joint] - joints[k, joint]) > LARGEST_TURN:
                return ROUND
    fastest = limits.speed * (1.0 + SPEED_TOLERANCE)
    for k in range(last):
        dx, dy = hand[k + 1, 0] - hand[k, 0], hand[k + 1, 1] - hand[k, 1]
        if np.sqrt(dx * dx + dy * dy) > fastest * (time[k + 1] - time[k]):
            return FAST
    return NOTHING


@njit
def _turns_too_fast(scene, time, hand):
    """Return whether a joint would have to be faster than its limit."""
    limits = scene.limits
    if limits.shoulder == np.inf or time.size == 1:
        return False
    turns = joint_turns(hand, scene.limb.rho, scene.limb.side, PARTS)
    shoulder, elbow = (
        limits.shoulder * (1.0 + SPEED_TOLERANCE), limits.elbow * (1.0 + SPEED_TOLERANCE)
    )  # fmt: skip
    for k in range(time.size - 1):
        span = time[k + 1] - time[k]
        if turns[k, 0] > shoulder * span or turns[k, 1] > elbow * span:
            return True
    return False


RESOLUTION = 2e-4  # the reported clearance is at most this above the true one [forearm lengths]


def clearance(
    situation: Situation, trajectory: Movement, scene: Scene | None = None
) -> tuple[float, float]:
    """Smallest distance between limb and obstacles along a trajectory, less the thickness.

    Parameters
    ----------
    situation : Situation
    trajectory : Movement
        Linear between its samples.
    scene : Scene, optional
        The situation packed, if the caller has it at hand.

    Returns
    -------
    clearance : float
        [forearm lengths], within 2e-4 of the true one; infinite without obstacles, and not
        above zero if the limb touches at any instant.
    when : float
        The time of it [s].
    """
    scene = pack(situation) if scene is None else scene
    thickness = scene.limb.thickness
    distance, when = least_distance(scene, trajectory.time, trajectory.hand, thickness, RESOLUTION)
    return (float("inf") if distance > 1e200 else distance - thickness), when
