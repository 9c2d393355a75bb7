"""Questions of the tree planner about joints and time: if a straight leg holds, where goals are.

Places are joints in units of what each turns in a second, so that distances are times.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from gcm_learn.arms import SPATIAL, ByKind
from gcm_learn.arms.limbs import dof
from gcm_learn.arms.swivels import inverse, limb_at
from gcm_learn.collision.postures import distance_at, gap_at
from gcm_learn.compiled import njit
from gcm_learn.errors import ArmKindError
from gcm_learn.motion.joint_interception import target_room
from gcm_learn.planners.completion import Attempt, JointProblem
from gcm_learn.planners.joints.moves import Study, time_of, timed_move_is_free, turning_time
from gcm_learn.planners.joints.pull import box, pulled
from gcm_learn.planners.joints.straight import attempt_along, soonest_straight
from gcm_learn.scene import Scene
from gcm_learn.scene.bodies import HAND, PART, REACH, centre_at

SPEED = 1.0
"""Of places, with which OMPL reckons. It leaves out legs on which several joints turn at their
fastest; 2 would leave out none. Of 44 situations 1, 1.4 and 2 caught 38, 34 and 31 within 100 ms,
and 41, 39 and 39 within a second."""
SPEED_OF_CHAINS = 1.6
"""The same for chains. Of 44 problems with a Panda (28 of MotionBenchMaker, 16 table-tennis balls)
1, 1.6 and 2.65 caught 24, 35 and 26 within 100 ms; 2.65 leaves out no leg of seven joints."""
_SLACK = 1e-6  # of the bounds of places, which must not be empty [s]
NEAR_START = 0.5
"""Share of goals of chains that are drawn near to what the start is pulled to."""
NEAR_GIVEN = 0.25
"""Share of goals of chains that are pulled from given postures, where there are some."""


@njit(_nrt=False)
def leg_holds_in_space(study, q, since, p, until):
    """Tell whether the joints may go straight from q at `since` to p (dof,) at `until` [s]."""
    took, pieces = time_of(study, q, p)
    if until - since < took or until <= since:
        return False
    return timed_move_is_free(study, q, since, p, until, pieces)


@njit(_nrt=False)
def draw_posture(study, since, until, chances, q):
    """Draw an interception: an instant, and into q the joints (dof,) with the hand on a target.

    Parameters
    ----------
    since, until : float
        The instants to draw from [s].
    chances : (n, 7) ndarray
        Uniform in [0, 1): the numbers for n tries.

    Returns
    -------
    time : float
        -1 if all tries fail [s].
    """
    scene, poses = study.scene, study.desk.poses
    limb, rows = scene.limb, scene.bodies.rows
    targets = 0
    for b in range(rows.shape[0]):
        targets += rows[b, PART] == HAND
    for k in range(chances.shape[0]):
        left, b = int(chances[k, 0] * targets), -1
        while left >= 0:
            b += 1
            left -= rows[b, PART] == HAND
        t = since + chances[k, 1] * (until - since)
        centre_at(scene.bodies, b, t, poses)
        r = chances[k, 2] ** (1.0 / 3.0) * (rows[b, REACH] + max(study.catch, 0.0))
        up, turn = 2.0 * chances[k, 3] - 1.0, 2.0 * np.pi * chances[k, 4]
        wide = r * np.sqrt(1.0 - up * up)
        x, y = poses[b, 0] + wide * np.cos(turn), poses[b, 1] + wide * np.sin(turn)
        z = poses[b, 2] + r * up
        if x * x + y * y + z * z > limb.reach**2:
            continue
        if target_room(scene, b, x, y, z, t, poses) > study.catch:
            continue
        swivel = 2.0 * np.pi * chances[k, 5]
        found = inverse(limb, x, y, z, swivel, limb.start, study.branches)
        if found == 0:
            continue
        branch = int(chances[k, 6] * found)
        for j in range(dof(limb)):
            q[j] = study.branches[branch, j]
        _, _, _, x, y, z = limb_at(limb, q)  # the inverse is exact but for rounding
        if target_room(scene, b, x, y, z, t, poses) > study.catch:
            continue
        if turning_time(scene.limits.joint_speed, limb.start, q) > t:
            continue
        if distance_at(scene, q, t, study.desk) > study.touch:
            return t
    return -1.0


@njit(_nrt=False)
def draw_pulled(study, since, until, chances, given, q):
    """Draw an interception of any arm: postures are pulled until the hand catches.

    Parameters
    ----------
    since, until : float
        The instants to draw from [s].
    chances : (m, n + 4) ndarray
        Uniform in [0, 1): the numbers for m tries.
    given : (k, n) ndarray
        Postures from which some goals are pulled.

    Returns
    -------
    time : float
        -1 if all tries fail [s].
    """
    scene = study.scene
    start, rows = scene.limb.start, scene.bodies.rows
    targets = 0
    for b in range(rows.shape[0]):
        targets += rows[b, PART] == HAND
    for k in range(chances.shape[0]):
        left, b = int(chances[k, 0] * targets), -1
        while left >= 0:
            b += 1
            left -= rows[b, PART] == HAND
        t = since + chances[k, 1] * (until - since)
        box(study, start, t)
        near = min(chances[k, 2] / NEAR_START, 1.0)
        hinted = given.shape[0] > 0 and chances[k, 3] < NEAR_GIVEN
        which = int(chances[k, 3] / NEAR_GIVEN * given.shape[0]) if hinted else 0
        for j in range(q.size):
            low, high = study.low[j], study.high[j]
            if hinted:
                q[j] = min(max(given[which, j], low), high)
            else:
                q[j] = start[j] + near * (low + chances[k, 4 + j] * (high - low) - start[j])
        if pulled(study, b, t, q) and gap_at(scene, q, t, study.desk) > study.touch:
            return t
    return -1.0


def _by_inverse(study: Study, since: float, until: float, chances: Any, given: Any, q: Any) -> Any:
    return draw_posture(study, since, until, chances, q)


class Drawing(NamedTuple):
    """Goals of a kind of arm."""

    draw: Callable[..., Any]
    numbers: Callable[[int], int]
    """Count of random numbers of a try, of the number of joints."""
    soonest: Callable[[Study], float]
    """No goal is before [s]."""
    speed: float
    """See `SPEED`."""


_DRAWINGS: ByKind[Drawing] = ByKind(
    {SPATIAL: Drawing(_by_inverse, lambda n: 7, soonest_straight, SPEED)},
    # The soonest straight line of a chain costs about as much as our search.
    default=Drawing(draw_pulled, lambda n: n + 4, lambda study: 0.0, SPEED_OF_CHAINS),
)


@dataclass(frozen=True)
class JointTask:
    """Task of a search in joints and time: goals, legs and the search's budget."""

    study: Study
    unhindered: float
    """No goal is before [s]."""
    seed: int
    budget_ms: float
    """Of processor time."""
    iterations: int
    drawing: Drawing
    draws: int
    """Numbers that are drawn for a try to draw a goal."""
    given: np.ndarray | None = None
    """Postures (k, dof) from which some goals are pulled."""

    @property
    def speed(self) -> float:
        """Of places, with which OMPL reckons."""
        return self.drawing.speed

    @property
    def scene(self) -> Scene:
        """Scene of the task."""
        return self.study.scene

    @property
    def start(self) -> tuple[float, ...]:
        """The joints at t = 0."""
        return tuple(self.scene.limb.start / self.scene.limits.joint_speed)

    @property
    def bounds(self) -> tuple[tuple[float, float], ...]:
        """Lowest and highest places that each joint can reach before the horizon."""
        limb, rate, end = self.scene.limb, self.scene.limits.joint_speed, self.scene.limits.horizon
        ends = zip(limb.low / rate, limb.high / rate, self.start, strict=True)
        return tuple((max(a, s - end) - _SLACK, min(b, s + end) + _SLACK) for a, b, s in ends)

    def joints(self, place: Sequence[float]) -> np.ndarray:
        """Return the joints (dof,) of a place; for the start exactly the joints at t = 0."""
        limb, rate = self.scene.limb, self.scene.limits.joint_speed
        here = np.array([place[j] for j in range(limb.start.size)])
        if (here == self.start).all():
            return np.array(limb.start)
        return np.clip(here * rate, limb.low, limb.high)

    def holds(self, p: Sequence[float], since: float, q: Sequence[float], until: float) -> bool:
        """Return whether the leg from p to q holds; see `leg_holds_in_space`."""
        ends = self.joints(p), since, self.joints(q), until
        return bool(leg_holds_in_space(self.study, *ends))

    def draw(self, until: float, chances: np.ndarray) -> tuple[float, ...]:
        """An interception before `until` [s]: when (-1 if all tries fail) and where."""
        q = np.zeros_like(self.scene.limb.start)
        given = np.zeros((0, q.size)) if self.given is None else self.given
        time = self.drawing.draw(self.study, self.unhindered, until, chances, given, q)
        return (float(time), *(q / self.scene.limits.joint_speed).tolist())


def task_in_space(problem: JointProblem, seed: int, budget_ms: float, iterations: int) -> JointTask:
    """Return the task of the search."""
    study = problem.study
    drawing = _DRAWINGS.of(problem.situation)
    soonest = max(drawing.soonest(study) - problem.rules.instant, 0.0)
    draws = drawing.numbers(study.goal.size)
    return JointTask(study, soonest, seed, budget_ms, iterations, drawing, draws)


def near(task: Any, postures: Sequence[Sequence[float]]) -> JointTask:
    """Return a task in which some goals are pulled from given postures.

    Raises
    ------
    ArmKindError
        If the arm's goals are not pulled from postures.
    """
    if not isinstance(task, JointTask) or task.drawing.draw is not draw_pulled:
        raise ArmKindError("postures: are of chains; goals of other arms are drawn otherwise")
    return replace(task, given=np.array(postures, dtype=float).reshape(-1, len(task.start)))


def ways_along(problem: JointProblem, paths: list[np.ndarray]) -> list[Attempt]:
    """Paths between states (n, dof + 1), the earliest catch first; targets may cut them short."""
    study, limb = problem.study, problem.scene.limb
    body = int(np.flatnonzero(problem.bodies.rows[:, PART] == HAND)[0])
    attempts = []
    for path in paths:
        joints = path[:, :-1] * problem.scene.limits.joint_speed
        joints = np.clip(joints, limb.low, limb.high)
        joints[0] = limb.start
        attempts.append(attempt_along(problem, study, path[:, -1], joints, body))
    return sorted(attempts, key=lambda attempt: attempt.trajectory.duration)
