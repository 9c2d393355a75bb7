"""What the tree planner asks about space-time: whether a straight leg holds, where goals are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gcm_learn.collision.distance import segment_point2
from gcm_learn.collision.sweep import least_distance
from gcm_learn.compiled import njit
from gcm_learn.motion.interception import target_distance
from gcm_learn.motion.timing import JOINT_SLACK
from gcm_learn.motion.verification import PARTS, joint_turns
from gcm_learn.planners.oracle.moves import ANY
from gcm_learn.scene.bodies import HAND, PART, REACH, Bodies, pose_at


class Limits(NamedTuple):
    """What a hand may do."""

    rho: float
    side: float
    hole: float  # legs stay that far from the shoulder
    far: float  # outer radius of the ring
    touch: float  # distance at which an obstacle touches
    speed: float  # of the hand [forearm lengths / s]
    shoulder: float  # of the joints [rad / s], infinite if there are no limits
    elbow: float
    reach: float  # signed distance to a target at which the hand surely catches


@dataclass(frozen=True)
class Task:
    """What to search, and for how long."""

    bodies: Bodies
    limits: Limits
    hand: tuple[float, float]
    horizon: float
    unhindered: float
    """No goal is before [s]."""
    seed: int
    budget_ms: float
    """Of processor time."""
    iterations: int


@njit
def leg_holds(bodies, limits, x0, y0, t0, x1, y1, t1):
    """Tell whether the hand may go straight and evenly from (x0, y0) at t0 to (x1, y1) at t1."""
    span = t1 - t0
    dx, dy = x1 - x0, y1 - y0
    if span <= 0.0 or dx * dx + dy * dy > (limits.speed * span) ** 2:
        return False
    if x1 * x1 + y1 * y1 > limits.far * limits.far:
        return False
    if segment_point2(0.0, 0.0, x0, y0, x1, y1) < limits.hole * limits.hole:
        return False
    hand = np.array([[x0, y0], [x1, y1]])
    if limits.shoulder < np.inf:
        turns = joint_turns(hand, limits.rho, limits.side, PARTS)
        if JOINT_SLACK * max(turns[0, 0] / limits.shoulder, turns[0, 1] / limits.elbow) > span:
            return False
    time = np.array([t0, t1])
    distance, _ = least_distance(bodies, time, hand, limits.rho, limits.side, limits.touch, ANY)
    return distance > limits.touch


@njit
def draw_goal(bodies, limits, x, y, since, until, chances):
    """Draw an interception: an instant, and a place where the hand is then on a target.

    Parameters
    ----------
    x, y : float
        Where the hand starts at t = 0; what it cannot reach in a straight line is not drawn.
    since, until : float
        The instants to draw from [s].
    chances : (n, 4) ndarray
        Uniform in [0, 1): the numbers for n tries.

    Returns
    -------
    time, x, y : float
        The time is -1 if all tries fail.
    """
    poses = np.zeros((bodies.rows.shape[0], 12))
    targets = np.flatnonzero(bodies.rows[:, PART] == HAND)
    here, now = np.empty((1, 2)), np.empty(1)
    for k in range(chances.shape[0]):
        b = targets[int(chances[k, 0] * targets.size)]
        now[0] = since + chances[k, 1] * (until - since)
        pose_at(bodies, b, now[0], poses)
        r = np.sqrt(chances[k, 2]) * (bodies.rows[b, REACH] + max(limits.reach, 0.0))
        px = poses[b, 0] + r * np.cos(2.0 * np.pi * chances[k, 3])
        py = poses[b, 1] + r * np.sin(2.0 * np.pi * chances[k, 3])
        if (px - x) ** 2 + (py - y) ** 2 > (limits.speed * now[0]) ** 2:
            continue
        if not limits.hole <= np.sqrt(px * px + py * py) <= limits.far:
            continue
        if target_distance(bodies, poses, b, px, py) > limits.reach:
            continue
        here[0, 0], here[0, 1] = px, py
        distance, _ = least_distance(bodies, now, here, limits.rho, limits.side, limits.touch, ANY)
        if distance > limits.touch:
            return now[0], px, py
    return -1.0, x, y
