"""Questions of the tree planner about space-time: does a straight leg hold, where are goals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from gcm_learn.collision.distance import segment_point2
from gcm_learn.collision.sweep import least_distance
from gcm_learn.compiled import njit
from gcm_learn.motion.rules import Rules
from gcm_learn.motion.timing import JOINT_SLACK
from gcm_learn.motion.verification import PARTS, joint_turns
from gcm_learn.planners.oracle.moves import ANY
from gcm_learn.scene import Scene
from gcm_learn.scene.bodies import HAND, PART, REACH, pose_at
from gcm_learn.scene.shapes.choice import gap_in_plane

SLACK = 1e-6  # of the bounds of places, which must not be empty [arm lengths]


@dataclass(frozen=True)
class HandTask:
    """Task and duration of a search."""

    scene: Scene
    rules: Rules
    hole: float
    """Legs stay that far from the shoulder."""
    unhindered: float
    """No goal is before [s]."""
    seed: int
    budget_ms: float
    """Of processor time."""
    iterations: int

    draws: ClassVar[int] = 4
    """Random numbers that one try of drawing a goal takes."""

    @property
    def start(self) -> tuple[float, ...]:
        """The hand at t = 0."""
        return self.scene.limb.x, self.scene.limb.y

    @property
    def bounds(self) -> tuple[tuple[float, float], ...]:
        """Lowest and highest x and y that the hand may come to before the horizon."""
        far, way = self.scene.limb.far, self.speed * self.scene.limits.horizon
        hair = SLACK * far
        return tuple((max(c - way, -far) - hair, min(c + way, far) + hair) for c in self.start)

    @property
    def speed(self) -> float:
        """No leg is faster."""
        return self.rules.speed

    def holds(self, p: Sequence[float], since: float, q: Sequence[float], until: float) -> bool:
        """Return whether the leg from p to q holds; see `leg_holds`."""
        legs = p[0], p[1], since, q[0], q[1], until
        return bool(leg_holds(self.scene, self.rules, self.hole, *legs))

    def draw(self, until: float, chances: np.ndarray) -> tuple[float, ...]:
        """An interception before `until` [s]: when (-1 if all tries fail) and where."""
        since = self.unhindered
        found = draw_goal(self.scene, self.rules, self.hole, since, until, chances)
        return tuple(float(v) for v in found)


@njit
def leg_holds(scene, rules, hole, x0, y0, t0, x1, y1, t1):
    """Tell whether the hand may go straight and evenly from (x0, y0) at t0 to (x1, y1) at t1."""
    span = t1 - t0
    dx, dy = x1 - x0, y1 - y0
    if span <= 0.0 or dx * dx + dy * dy > (rules.speed * span) ** 2:
        return False
    limb, limits = scene.limb, scene.limits
    if x1 * x1 + y1 * y1 > limb.far * limb.far:
        return False
    if segment_point2(0.0, 0.0, x0, y0, x1, y1) < hole * hole:
        return False
    hand = np.array([[x0, y0], [x1, y1]])
    if limits.shoulder < np.inf:
        turns = joint_turns(hand, limb.rho, limb.side, PARTS)
        if JOINT_SLACK * max(turns[0, 0] / limits.shoulder, turns[0, 1] / limits.elbow) > span:
            return False
    time = np.array([t0, t1])
    distance, _ = least_distance(scene, time, hand, rules.touch, ANY)
    return distance > rules.touch


@njit
def draw_goal(scene, rules, hole, since, until, chances):
    """Draw an interception: an instant, and a place where the hand is then on a target.

    Parameters
    ----------
    hole : float
        What the hand cannot reach in a straight line, or is nearer to the shoulder, is not drawn.
    since, until : float
        The instants to draw from [s].
    chances : (n, 4) ndarray
        Uniform in [0, 1): the numbers for n tries.

    Returns
    -------
    time, x, y : float
        The time is -1 if all tries fail.
    """
    bodies, x, y = scene.bodies, scene.limb.x, scene.limb.y
    poses = np.zeros((bodies.rows.shape[0], 12))
    targets = np.flatnonzero(bodies.rows[:, PART] == HAND)
    here, now = np.empty((1, 2)), np.empty(1)
    for k in range(chances.shape[0]):
        b = targets[int(chances[k, 0] * targets.size)]
        now[0] = since + chances[k, 1] * (until - since)
        pose_at(bodies, b, now[0], poses)
        r = np.sqrt(chances[k, 2]) * (bodies.rows[b, REACH] + max(rules.catch, 0.0))
        px = poses[b, 0] + r * np.cos(2.0 * np.pi * chances[k, 3])
        py = poses[b, 1] + r * np.sin(2.0 * np.pi * chances[k, 3])
        if (px - x) ** 2 + (py - y) ** 2 > (rules.speed * now[0]) ** 2:
            continue
        if not hole <= np.sqrt(px * px + py * py) <= scene.limb.far:
            continue
        if gap_in_plane(bodies, poses, b, px, py) > rules.catch:
            continue
        here[0, 0], here[0, 1] = px, py
        distance, _ = least_distance(scene, now, here, rules.touch, ANY)
        if distance > rules.touch:
            return now[0], px, py
    return -1.0, x, y
