"""Artificial potential field: pulled by the target, pushed by obstacles, step by step.

O. Khatib, Real-time obstacle avoidance for manipulators and mobile robots, Int. J. Robotics
Research 5(1), 1986.  The goal is an attractive well.  An obstacle has the repulsive potential
eta / 2 (1 / d - 1 / d0)^2 within the distance d0 of it.  Here the goal is the straight
interception, predicted anew in every step, and d is the distance of the whole limb.  The hand goes
down the gradient at most at its speed limit.  It is a local rule: it gets stuck, and it may touch
what comes fast, which the verification then finds.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from gcm_learn.arms import PLANAR, SPATIAL, ByKind, Kind
from gcm_learn.arms.planar_limb import elbow_of
from gcm_learn.collision.distance import arm_distance
from gcm_learn.compiled import njit
from gcm_learn.motion import Failure
from gcm_learn.motion.interception import first_interception
from gcm_learn.motion.verification import HOLE_MARGIN
from gcm_learn.planners.baselines.joint_potential import potential_plan
from gcm_learn.planners.completion import JointProblem, Problem, checked, finish
from gcm_learn.planners.plan import Plan
from gcm_learn.scene.bodies import HAND, PART, poses_at
from gcm_learn.scene.shapes.choice import gap_in_plane
from gcm_learn.situation import AnySituation

STEP = 0.02  # how far the hand goes in a step at most [forearm lengths]
MOST_STEPS = 20_000  # against absurdly long horizons
NEAREST = 1e-3  # the push grows no more below this distance [forearm lengths]
_PROBE = 1e-5  # finite difference of the potential [forearm lengths]


class Repulsion(NamedTuple):
    """The repulsive potential; the attractive force is 1."""

    influence: float  # distance d0 within which obstacles push [forearm lengths]
    gain: float  # eta


@njit(_nrt=False)
def repulsion(scene, field, poses, x, y):
    """Khatib's repulsive potential of all obstacles for a hand at (x, y)."""
    ex, ey = elbow_of(x, y, scene.limb.rho, scene.limb.side)
    total = 0.0
    for b in range(scene.bodies.rows.shape[0]):
        if scene.bodies.rows[b, PART] == HAND:
            continue
        d = arm_distance(scene.bodies, poses, b, x, y, ex, ey) - scene.limb.thickness
        d = max(d, NEAREST)
        if d < field.influence:
            total += 0.5 * field.gain * (1.0 / d - 1.0 / field.influence) ** 2
    return total


@njit
def descend_field(scene, rules, field, points):
    """Follow the field from the hand until a target is caught.

    Parameters
    ----------
    scene, rules, field : Scene, Rules, Repulsion
    points : (m, 2) ndarray
        Filled with the hand after every step of horizon / (m - 1), its start included.

    Returns
    -------
    int
        Number of points when a target is within reach, -1 if none ever is.
    """
    bodies, limb, horizon = scene.bodies, scene.limb, scene.limits.horizon
    x, y = limb.x, limb.y
    steps = points.shape[0] - 1
    dt = horizon / steps
    poses = np.zeros((bodies.rows.shape[0], 12))
    for k in range(steps + 1):
        points[k, 0], points[k, 1] = x, y
        poses_at(bodies, k * dt, poses)
        for b in range(bodies.rows.shape[0]):
            if bodies.rows[b, PART] != HAND:
                continue
            if gap_in_plane(bodies, poses, b, x, y) <= rules.catch:
                return k + 1
        if k == steps:
            break
        t, _, px, py = first_interception(scene, rules, x, y, k * dt, k * dt, horizon)
        if t < 0.0:
            break
        poses_at(bodies, (k + 1) * dt, poses)  # where the obstacles will be after this step
        u0 = repulsion(scene, field, poses, x - _PROBE, y)
        u1 = repulsion(scene, field, poses, x + _PROBE, y)
        v0 = repulsion(scene, field, poses, x, y - _PROBE)
        v1 = repulsion(scene, field, poses, x, y + _PROBE)
        away = max(np.sqrt((px - x) ** 2 + (py - y) ** 2), 1e-12)
        fx = (px - x) / away - 0.5 * (u1 - u0) / _PROBE
        fy = (py - y) / away - 0.5 * (v1 - v0) / _PROBE
        force = np.sqrt(fx * fx + fy * fy)
        length = rules.speed * dt / max(force, 1.0)
        x, y = x + length * fx, y + length * fy
        r = max(np.sqrt(x * x + y * y), 1e-12)
        scale = min(max(r, limb.near + HOLE_MARGIN), limb.far) / r
        x, y = x * scale, y * scale
    return -1


@dataclass(frozen=True)
class PotentialPlanner:
    """An artificial potential field (Khatib 1986), rolled out in the known world and verified."""

    name: str = "potential"
    influence: float = 0.1
    """Distance d0 within which obstacles push [forearm lengths]; chosen on 300 situations."""
    gain: float = 3e-4
    """eta of the repulsive potential, for an attractive force of 1; chosen on 300 situations."""

    accelerates = False

    def takes(self, kind: Kind) -> bool:
        """Return whether there is a field for arms of a kind."""
        return _BY_KIND.takes(kind)

    def plan(self, situation: AnySituation) -> Plan:
        """Answer a situation."""
        return _BY_KIND.of(situation)(self, situation)

    def _in_space(self, situation: AnySituation) -> Plan:
        problem = JointProblem(situation, self.name)
        return problem.early_answer() or potential_plan(problem, self.influence, self.gain)

    def _in_plane(self, situation: AnySituation) -> Plan:
        problem = Problem(situation, self.name)
        answer = problem.early_answer()
        if answer is not None:
            return answer
        arm, horizon = problem.situation.arm, problem.situation.horizon
        steps = max(int(np.ceil(arm.max_hand_speed * horizon / STEP)), 1)
        hand = np.empty((min(steps, MOST_STEPS) + 1, 2))
        rules = problem.rules._replace(speed=arm.max_hand_speed * (1.0 - 1e-8))
        count = descend_field(problem.scene, rules, Repulsion(self.influence, self.gain), hand)
        if count < 0:
            return problem.answer(Failure.NO_FIELD_LINE)
        time = np.linspace(0.0, horizon, len(hand))[:count]
        attempt = finish(problem, np.vstack([hand[:1], hand[:count]]), np.append(0.0, time))
        if attempt is None:
            return problem.answer(Failure.NO_FIELD_LINE)
        plan, reason = checked(problem, attempt)
        return plan if plan is not None else problem.answer(reason or Failure.NO_FIELD_LINE)


_BY_KIND: ByKind[Any] = ByKind(
    {PLANAR: PotentialPlanner._in_plane, SPATIAL: PotentialPlanner._in_space},
    who="planner 'potential'",
)
