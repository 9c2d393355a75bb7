"""Memories that are made of the catches of a dataset, or of movements without experience.

Synthetic movements are the control for what stored catches add. They go to a random posture that
meets a target, by a random detour. Their length, time and wait are drawn from those of catches.
Obstacles have no influence on them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from itertools import islice
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from gcm_learn import seeding
from gcm_learn.arms import PLANAR, SIDE, ByKind, Kind, forward, joints_of
from gcm_learn.compiled import njit
from gcm_learn.errors import RecallError
from gcm_learn.motion import Movement
from gcm_learn.planners.joints.meetings import meets
from gcm_learn.processes import crew_of
from gcm_learn.recall.index import Index, index_class
from gcm_learn.recall.kinds import MEMORIES, waypoints_of
from gcm_learn.recall.store import Memory
from gcm_learn.recall.waypoints import Waypoints
from gcm_learn.scene.bodies import pose_at

if TYPE_CHECKING:
    from gcm_learn.dataset import Dataset, Record


TRIES = 24  # postures that are drawn for one movement
SAMPLES = 33  # of a movement
BEND = 0.25, 0.75  # shares of the way at which a detour bends
STILL = 1e-3  # turn of the joints that is not yet a movement [rad]
STUDIED = 2000  # catches whose lengths are known, at most


class Habit(NamedTuple):
    """Length and times of a catch, without the path."""

    length: float
    """Way in the joints [rad]."""
    end: float
    """Time of the catch [horizons]."""
    wait: float
    """Rest before the movement begins [times of the catch]."""


def habits_of(records: Iterable[Record]) -> tuple[Habit, ...]:
    """Return lengths and times of the earliest catches of some records.

    Raises
    ------
    RecallError
        If there is no catch.
    """
    pairs = ((record.earliest(), record.situation.horizon) for record in records)
    habits = (
        _habit(plan.trajectory.until(plan.catch_time), horizon)  # a hold comes after
        for plan, horizon in pairs
        if plan is not None and plan.trajectory is not None and plan.catch_time is not None
    )
    found = tuple(islice(habits, STUDIED))
    if not found:
        raise RecallError("the dataset has no catches, whose lengths synthetic movements take")
    return found


def _habit(path: Any, horizon: float) -> Habit:
    turns = np.linalg.norm(np.diff(path.joints, axis=0), axis=1)
    moved = np.linalg.norm(path.joints - path.joints[0], axis=1) > STILL
    begins, end = path.time[max(int(np.argmax(moved)) - 1, 0)], float(path.time[-1])
    return Habit(float(turns.sum()), end / horizon, float(begins) / end if end > 0.0 else 0.0)


@dataclass(frozen=True)
class Synthetic:
    """Source of synthetic movements, one for each record.

    Parameters
    ----------
    habits : tuple of Habit
        See `habits_of`.
    seed : int
        Decides a record's movement, together with its number.
    """

    habits: tuple[Habit, ...]
    seed: int = 0

    def __call__(self, record: Record) -> Waypoints | None:
        """Return a movement in a record's situation, or None without a posture that meets."""
        situation, rng = record.situation, seeding.rng(self.seed, record.index)
        habit = self.habits[int(rng.integers(len(self.habits)))]
        targets = [k for k, body in enumerate(situation.bodies) if body.role == "target"]
        body = targets[int(rng.integers(len(targets)))]
        kind, end = MEMORIES.of(situation), habit.end * situation.horizon
        draw, move = _KINDS.of(situation)
        problem = kind.problem(situation, "synthetic")
        drawn = draw(problem, body, end, rng)
        if drawn is None:
            return None
        start, goals, ends = drawn
        away = np.linalg.norm(goals - start, axis=1)
        near = np.flatnonzero(away <= habit.length)
        goal = goals[near[0] if len(near) else int(np.argmin(away))]
        joints = _way(start, goal, ends, habit.length, rng)
        time = np.linspace(habit.wait * end, end, len(joints))
        if time[0] > 0.0:
            time, joints = np.append(0.0, time), np.vstack([joints[:1], joints])
        return kind.waypoints_of(situation, move(situation.arm, time, joints), body)


def _way(
    start: np.ndarray,
    goal: np.ndarray,
    ends: tuple[np.ndarray, np.ndarray],
    length: float,
    rng: np.random.Generator,
) -> np.ndarray:
    """Return joints (SAMPLES, n) on a way of a length [rad] from start to goal, with one bend."""
    straight, side = goal - start, rng.normal(size=start.size)
    least = float(np.linalg.norm(straight))
    if least > 0.0:
        side -= straight * (side @ straight) / least**2
    aside = 0.5 * math.sqrt(max(length * length - least * least, 0.0))
    bend = start + rng.uniform(*BEND) * straight
    bend += aside * side / max(float(np.linalg.norm(side)), 1e-12)
    corners = np.array([start, np.clip(bend, *ends), goal])
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1))])
    at = np.linspace(0.0, way[-1], SAMPLES)
    return np.stack([np.interp(at, way, column) for column in corners.T], axis=1)


Drawn = tuple[np.ndarray, np.ndarray, tuple[np.ndarray, np.ndarray]]
"""Joints (n,) of the start, postures (m, n) that meet a target, and ends of the joints' ranges."""


def _hand_goals(problem: Any, body: int, end: float, rng: np.random.Generator) -> Drawn | None:
    """Draw places on a disc within grasp of a target's centre, and their postures."""
    arm, poses = problem.situation.arm, np.zeros((len(problem.situation.bodies), 12))
    pose_at(problem.bodies, body, end, poses)
    angles, near = rng.uniform(0.0, 2.0 * math.pi, TRIES), arm.grasp * np.sqrt(rng.random(TRIES))
    hands = poses[body, :2] + near[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    radius = np.hypot(*hands.T)
    hands = hands[(radius < arm.reach) & (radius > arm.inner_reach)]
    if len(hands) == 0:
        return None
    side = SIDE[arm.elbow]
    start = joints_of(np.array([arm.hand]), arm.upper_arm, side)[0]
    goals = joints_of(hands, arm.upper_arm, side)
    goals[:, 0] = start[0] + np.remainder(goals[:, 0] - start[0] + math.pi, 2.0 * math.pi) - math.pi
    bent = np.sort([0.0, start[1], math.copysign(math.pi, start[1])])[[0, 2]]
    return start, goals, (np.array([-np.inf, bent[0]]), np.array([np.inf, bent[1]]))


def _hand_movement(arm: Any, time: np.ndarray, joints: np.ndarray) -> Movement:
    return Movement.of_hand(arm, time, forward(joints, arm.upper_arm))


def _joint_goals(problem: Any, body: int, end: float, rng: np.random.Generator) -> Drawn | None:
    """Draw postures that the start reaches in time and pull them to a target."""
    limb, goals = problem.scene.limb, rng.random((TRIES, problem.study.goal.size))
    met = _meeting(problem.study, body, end, goals)
    return (limb.start, goals[met], (limb.low, limb.high)) if met.any() else None


@njit
def _meeting(study, b, t, goals):
    """Turn drawn postures (m, n) until they catch body b at t [s]; return which do (m,)."""
    met = np.zeros(goals.shape[0], dtype=np.bool_)
    for k in range(goals.shape[0]):
        met[k] = meets(study, b, t, goals[k])
    return met


class _GrowthKind(NamedTuple):
    """Functions that make synthetic movements of one kind of arm."""

    draw: Callable[[Any, int, float, np.random.Generator], Drawn | None]
    move: Callable[[Any, np.ndarray, np.ndarray], Movement]


_KINDS = ByKind(
    {PLANAR: _GrowthKind(_hand_goals, _hand_movement)}, default=_GrowthKind(_joint_goals, Movement)
)


CHUNK = 500  # records that are filed at once
FITTED = 5000  # situations at most that an index is fitted to
Source = Callable[["Record"], "Waypoints | None"]
"""Movement of a record, if it has one."""


def remember(
    records: Dataset,
    index: str | Index = "raw",
    planner: str = "",
    *,
    synthetic: bool = False,
    seed: int = 0,
    most: int | None = None,
    workers: int | None = 1,
    cluster: str | None = None,
    progress: Callable[[int], None] = lambda done: None,
) -> Memory:
    """Make a memory of the catches of a dataset.

    Parameters
    ----------
    records : Dataset
        Records without a catch are left out; choose a split with `where` before.
    index : str or Index
        A registered name, which is fitted to a sample of the situations, or an index of your own.
    planner : str
        Planner of the catches; by default the earliest catch of all planners.
    synthetic : bool
        Take a synthetic movement for each record in place of its catch; see `recall.synthetic`.
    seed : int
        Decides the sample, synthetic movements, and which records are taken if there are more than
        `most`.
    most : int, optional
        Records that are read at most.
    workers, cluster
        See `processes.crew_of`; by default this process.  Whoever reads must find the dataset
        where it is found here.
    progress : callable
        Called with the number of records read since the last call.
    """
    if planner and planner not in records.spec.planners:
        known = ", ".join(records.spec.planners)
        raise RecallError(f"planner: {planner!r} has no plans in the dataset (it has {known})")
    order = np.arange(len(records))
    if most is not None and most < len(order):
        order = np.sort(seeding.rng(seed, 0).permutation(len(order))[:most])
    if isinstance(index, str):
        index = _fitted(records, index, order, seed)
    kind = records.spec.kind
    memory = Memory(index, kind=kind)
    source = source_of(records, planner, synthetic=synthetic, seed=seed)
    parts = [order[start : start + CHUNK] for start in range(0, len(order), CHUNK)]
    with crew_of(workers, cluster) as crew:
        filed = crew.map(partial(_filed, index, kind, source), map(records.part, parts))
        for part, more in zip(parts, filed, strict=True):
            memory.extend(more)
            progress(len(part))
    return memory


def _fitted(records: Dataset, name: str, order: np.ndarray, seed: int) -> Index:
    """A registered index, fitted to situations of the records."""
    if len(order) == 0:
        raise RecallError("the dataset has no records to remember")
    made = index_class(name)
    sample = np.sort(seeding.rng(seed, 1).permutation(order)[:FITTED])
    return made.fit([records[int(k)].situation for k in sample], seed)


def _filed(index: Index, kind: Kind, source: Source, records: Iterable[Record]) -> Memory:
    """A memory of some records."""
    memory = Memory(index, kind=kind)
    found = [(record, waypoints) for record in records if (waypoints := source(record))]
    memory.add(
        [record.situation for record, _ in found],
        [waypoints for _, waypoints in found],
        [record.family for record, _ in found],
        [record.stratum for record, _ in found],
    )
    return memory


def source_of(
    records: Dataset, planner: str = "", *, synthetic: bool = False, seed: int = 0
) -> Source:
    """Return the function that gives a record's catch, or a synthetic movement in its place.

    Synthetic movements are as long as catches of the records for training.
    """
    if not synthetic:
        return partial(catch_of, planner=planner)
    return Synthetic(habits_of(records.where(split="train")), seed)


def catch_of(record: Record, planner: str = "") -> Waypoints | None:
    """Waypoints of a record's catch, of the earliest if no planner is named."""
    plan = record.earliest(planner)
    return None if plan is None else waypoints_of(record.situation, plan)
