"""VAMP on a frozen world, planned anew every 20 ms: a rival that knows no motion of obstacles.

In each period all bodies are frozen where they are, and VAMP plans (RRT-Connect, then its
shortcuts) from the present posture to one of up to 20 postures.  Each of these catches the target
where it will be at the instant that is aimed for.  The arm follows the path at its joints' speeds
for 20 ms, or rests without a path.  It stays on the last path if the new one is not quicker.  VAMP
has to find the rest of that path free, and the aim has to be the same.  Without this rule the arm
wavered between ways.  A path that leaves the range of a joint of our arm is drawn again, twice at
most.

The aim is the earliest of 48 instants at which a straight move could meet the target.  A path that
takes longer moves the aim to its end.  The aim is taken anew if no posture catches then.  For a
target that moves, VAMP gets the postures to which a straight move leads in time, or the nearest.
"""

from __future__ import annotations

import zlib
from dataclasses import dataclass, field
from itertools import pairwise
from time import process_time
from typing import Any

import numpy as np

from gcm_learn import seeding
from gcm_learn.arms.curves import line
from gcm_learn.motion import Failure, Movement
from gcm_learn.motion.joint_interception import first_meeting
from gcm_learn.planners import JointProblem, Plan
from gcm_learn.planners.completion import Attempt, judged
from gcm_learn.planners.joints.moves import turning_time
from gcm_learn.planners.joints.pull import met_from, pulled
from gcm_learn.scene import HAND, PART, TOP_SPEED, poses_at
from gcm_learn.situation import Box, Capsule, Cylinder, Sphere

try:
    import vamp
except ImportError:
    vamp = None

PERIOD = 0.02
GOALS, TRIES = 20, 60  # postures that catch, and draws for them
AGAIN = 3  # paths that are drawn in a period, if they leave the joints' ranges
INSTANTS = 48  # at which the first aim is looked for
SPEED = 1.0 - 1e-6  # share of the joints' speeds that is used, against rounding
ROUNDING = 1e-5  # of VAMP's single precision, by which a path may leave a range [rad]
LOOK = 0.0025  # time between looks by VAMP's own geometry [s]


def takes(situation: Any) -> bool:
    """Return whether VAMP is installed and has the situation's arm."""
    return vamp is not None and situation.arm.model.name in vamp.robots


def world(situation: Any, poses: np.ndarray) -> Any:
    """Return VAMP's environment of the obstacles at their poses (n, 12).

    Cylinders become capsules, and boxes in the set with boxes, as in VAMP's own benchmark.
    """
    made = vamp.Environment()
    boxed = situation.name.startswith("box_")
    for body, pose in zip(situation.bodies, poses, strict=True):
        if body.role != "obstacle":
            continue
        place, turn, shape = pose[:3].tolist(), _angles(pose[3:].reshape(3, 3)), body.shape
        if isinstance(shape, Sphere):
            made.add_sphere(vamp.Sphere(place, shape.radius))
        elif isinstance(shape, Box):
            made.add_cuboid(vamp.Cuboid(place, turn, list(shape.half_extents)))
        elif boxed and isinstance(shape, Cylinder):
            half = [shape.radius, shape.radius, shape.half_length]
            made.add_cuboid(vamp.Cuboid(place, turn, half))
        elif isinstance(shape, Cylinder | Capsule):
            length = 2.0 * shape.half_length
            made.add_capsule(vamp.Cylinder(place, turn, shape.radius, length))
        else:
            raise TypeError(f"{body.name}: VAMP has no {shape.kind}")
    return made


def _angles(turn: np.ndarray) -> list[float]:
    """Return the angles about the fixed x, y and z axes of a rotation (3, 3)."""
    pitch = np.arcsin(np.clip(-turn[2, 0], -1.0, 1.0))
    roll, yaw = np.arctan2(turn[2, 1], turn[2, 2]), np.arctan2(turn[1, 0], turn[0, 0])
    return [float(roll), float(pitch), float(yaw)]


@dataclass
class Executed:
    """Movement that planning anew all the time led to."""

    plan: Plan
    """Caught if the hand met the target; whether it touched is for the referee."""
    good: bool
    """True if our verification finds the movement free."""
    first_ms: float
    """Processor time of the first plan [ms]."""
    inner_ms: float
    """The part of it that VAMP takes [ms]; the rest is our search for postures that catch."""
    slowest_ms: float
    """Of a period [ms]."""
    plans: int
    """Periods with a path."""


@dataclass
class Frozen:
    """One arm that plans in a frozen world and acts in the real one.

    Parameters
    ----------
    situation : Situation
    goal : (n,) tuple of float, optional
        The suite's own goal posture.
    limit_ms : float
        A plan that takes longer is not followed [ms].
    """

    situation: Any
    goal: tuple[float, ...] | None
    limit_ms: float = np.inf
    times: list[float] = field(default_factory=lambda: [0.0])
    joints: list[np.ndarray] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Pack the situation and set up VAMP."""
        self.problem: Any = JointProblem(self.situation, "vamp")
        self.study, self.scene = self.problem.study, self.problem.scene
        self.limb, self.rate = self.scene.limb, SPEED * self.scene.limits.joint_speed
        self.joints.append(self.limb.start.copy())
        self.rows = self.scene.bodies.rows
        self.target = int(np.flatnonzero(self.rows[:, PART] == HAND)[0])
        self.poses = np.tile(np.r_[np.zeros(3), np.eye(3).ravel()], (len(self.rows), 1))
        self.rng = seeding.rng(18, zlib.crc32(self.situation.name.encode()))
        self._rests = bool(self.rows[self.target, TOP_SPEED] == 0.0)
        self.goals: list[np.ndarray] = []
        self.robot, self.draws = vamp.panda, vamp.panda.halton()
        found = vamp.configure_robot_and_planner_with_kwargs("panda", "rrtc")
        self.settings, self.shortening = found[2], found[3]
        self.settings.max_iterations = self.settings.max_samples = 5000
        self.aim = self.inner = 0.0

    def run(self) -> Executed:
        """Plan and move until a catch or the horizon."""
        t, horizon, body = 0.0, self.situation.horizon, -1
        path, spent, inner, plans = [self.joints[0]], [], [], 0
        while body < 0 and t < horizon:
            since = process_time()
            found = self._path(t, path)
            spent.append(1e3 * (process_time() - since))
            inner.append(self.inner)
            if spent[-1] <= self.limit_ms:
                plans += found is not None
                path = [self.joints[-1]] if found is None else found
            end = min(t + PERIOD, horizon)
            path, body = self._follow(path, t, end)
            t = end
        return self._told(body, spent, inner[0], plans)

    def _aimed(self, since: float) -> float:
        """Return the earliest instant at which a straight move could meet the target [s]."""
        here, horizon = self.joints[-1], self.situation.horizon
        for t in np.linspace(0.0, horizon, INSTANTS + 1)[1:]:
            if t > since and met_from(self.study, here, since, self.target, here, t) > 0:
                return float(t)
        return float(horizon)

    def _path(self, t: float, last: list[np.ndarray]) -> list[np.ndarray] | None:
        """Return postures from the present one to one that catches, in the world of now."""
        aim = self.aim
        if self.aim <= t:
            self.aim = self._aimed(t)
        self._renew_goals()
        if not self.goals:
            self.aim = self._aimed(t)
            self._renew_goals()
        since = process_time()
        try:
            return self._planned(t, last if self.aim == aim or self._rests else [])
        finally:
            self.inner = 1e3 * (process_time() - since)

    def _planned(self, t: float, last: list[np.ndarray]) -> list[np.ndarray] | None:
        """Return VAMP's path to a posture that catches, or what is left of the last one."""
        poses_at(self.scene.bodies, t, self.poses)
        frozen, here = world(self.situation, self.poses), self.joints[-1]
        free = [g for g in self.goals if self.robot.validate(g.astype(np.float32), frozen)]
        if not free:
            return None
        if not self._rests:
            free.sort(key=lambda g: float(turning_time(self.rate, here, g)))
            soon = [g for g in free if turning_time(self.rate, here, g) <= self.aim - t]
            free = soon or free[:1]
        ends = [g.astype(np.float32) for g in free]
        spare = self._lasts(last) if self._leads(last, frozen) else np.inf
        for _ in range(AGAIN):
            found = self.robot.rrtc(
                here.astype(np.float32), ends, frozen, self.settings, self.draws
            )
            if not found.solved:
                break
            short = self.robot.simplify(found.path, frozen, self.shortening, self.draws).path
            path = [np.array(q, dtype=float) for q in short.numpy()]
            path[0] = here
            path[-1] = min(free, key=lambda g: np.abs(g - path[-1]).max())
            if all(self._in_range(q) for q in path):
                path = [np.clip(q, self.limb.low, self.limb.high) for q in path]
                if self._lasts(path) >= spare:
                    return last
                self.aim = min(max(self.aim, t + self._lasts(path)), self.situation.horizon)
                return path
        return last if np.isfinite(spare) else None

    def _lasts(self, path: list[np.ndarray]) -> float:
        """Return how long a path takes [s]."""
        return float(sum(turning_time(self.rate, p, q) for p, q in pairwise(path)))

    def _leads(self, path: list[np.ndarray], frozen: Any) -> bool:
        """Return whether a path ends in a posture that catches and is free in the world of now."""
        if not path or not any(np.array_equal(path[-1], g) for g in self.goals):
            return False
        legs = pairwise(q.astype(np.float32) for q in path)
        return all(self.robot.validate_motion(p, q, frozen) for p, q in legs)

    def _in_range(self, q: np.ndarray) -> bool:
        low, high = self.limb.low - ROUNDING, self.limb.high + ROUNDING
        return bool((q >= low).all() and (q <= high).all())

    def _renew_goals(self) -> None:
        """Find up to 20 postures that catch at the instant aimed for, from the last ones first."""
        if self.goals and self._rests:
            return
        seeds = self.goals or ([] if self.goal is None else [np.array(self.goal)])
        tries = max(0, TRIES if not self.goals else GOALS - len(self.goals))
        drawn = self.rng.uniform(self.limb.low, self.limb.high, (tries, self.limb.start.size))
        found = []
        for seed in [*seeds, *drawn]:
            self.study.low[:], self.study.high[:] = self.limb.low, self.limb.high
            q = np.clip(seed, self.limb.low, self.limb.high)
            if len(found) < GOALS and pulled(self.study, self.target, self.aim, q):
                found.append(q)
        self.goals = found

    def _follow(self, path: list[np.ndarray], t: float, end: float) -> tuple[list[np.ndarray], int]:
        """Follow a path from t to `end` [s]; return its rest and the target that is caught."""
        path = [self.joints[-1], *path[1:]]
        while t < end:
            if len(path) == 1:
                return path, self._move(path[0], t, end)[1]
            took = turning_time(self.rate, path[0], path[1])
            if took <= end - t:
                target = path.pop(1)
                until = t + took
            else:
                target = path[0] + (end - t) / took * (path[1] - path[0])
                until = end
            if until > t:
                t, body = self._move(target, t, until)
                if body >= 0:
                    return path, body
            path[0] = target
        return path, -1

    def _move(self, q: np.ndarray, t: float, until: float) -> tuple[float, int]:
        """Go straight to joints q (n,), up to the first target within reach."""
        here, study = self.joints[-1], self.study
        line(here, q, study.desk.curve)
        met, body = first_meeting(
            self.scene, study.desk.curve, t, until, study.catch, study.instant, study.desk.poses
        )
        if body >= 0 and met > t:
            q, until = here + (met - t) / (until - t) * (q - here), met
        self.times.append(until)
        self.joints.append(q.copy())
        return until, int(body)

    def _told(self, body: int, spent: list[float], inner: float, plans: int) -> Executed:
        """Return the movement, whether it met the target, and what it took."""
        times = spent[0], inner, max(spent), plans
        if body < 0:
            return Executed(self.problem.answer(Failure.NO_TREE), False, *times)
        moves = Movement(self.situation.arm, np.array(self.times), np.array(self.joints))
        attempt = Attempt(moves, body)
        plan, verdict = judged(self.problem, attempt)
        claimed = self.problem.caught(attempt, verdict.clearance)
        return Executed(claimed, plan is not None, *times)


def touches(situation: Any, plan: Plan) -> bool:
    """Return whether a movement touches by VAMP's own spheres, looked at every 2.5 ms."""
    problem: Any = JointProblem(situation, "vamp")
    bodies, moves = problem.scene.bodies, plan.trajectory
    poses = np.tile(np.r_[np.zeros(3), np.eye(3).ravel()], (len(bodies.rows), 1))
    assert moves is not None
    for t in np.arange(0.0, moves.duration, LOOK):
        poses_at(bodies, t, poses)
        q = [np.interp(t, moves.time, column) for column in moves.joints.T]
        if not vamp.panda.validate(np.array(q, dtype=np.float32), world(situation, poses)):
            return True
    return False
