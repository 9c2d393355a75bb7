"""The yardstick: bounds on the earliest catch of any movement, waiting allowed, whole limb.

The places that the hand can reach are followed through space and time on a lattice,
R(t + dt) = dilate(R(t), v dt) minus what is occupied, once rounded outwards and once inwards
(`reachable_set`).  The outer set's first meeting with a target is before every catch; one that
never meets a target proves that there is none.  The inner set's first meeting ends a movement,
which is pulled tight, timed and verified like every plan, and is not before the earliest catch.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from gcm_learn.planners.completion import Problem, checked, finish, straight_catch
from gcm_learn.planners.fronts import marching
from gcm_learn.planners.interception import first_interception
from gcm_learn.planners.oracle_kernels import pull
from gcm_learn.planners.plan import Plan
from gcm_learn.planners.reachable_set import ReachableSet
from gcm_learn.planners.straight import StraightPlanner
from gcm_learn.planners.timing import straight_way
from gcm_learn.situation import Situation

SIZES = (60, 120)
"""Cells along a side, one lattice after the other until the bounds are tight."""
LAST_SIZE = 240
"""For situations that those leave undecided: a catch neither found nor ruled out."""
TIGHT = 0.02
"""Bounds that differ by at most this share are not refined."""
A_CELL = 2  # meetings of one step of which movements are made
WORTH=0.002
MEETINGS = 24  # and of one lattice

Stratum = Literal["U", "L", "W", "Q"]


@dataclass(frozen=True)
class Bounds:
    """What is known of a situation's earliest catch."""

    lower: float
    """No movement catches before [s]; infinite if none catches within the horizon."""
    upper: float
    """`plan` catches then [s]; infinite without one."""
    plan: Plan | None
    """The best verified plan."""
    blocked: bool = False
    """The limb touches an obstacle at t = 0."""

    @property
    def tight(self) -> bool:
        """Whether the bounds agree, or say that there is no catch."""
        return self.lower >= (1.0 - TIGHT) * self.upper or math.isinf(self.lower)


def bounds(
    situation: Situation, sizes: tuple[int, ...] = SIZES, last_size: int | None = LAST_SIZE
) -> Bounds:
    """Bound the earliest catch of any movement that keeps the rules of the world.

    Parameters
    ----------
    situation : Situation
        Joint speed limits are kept by the plan; the lower bound does not know them.
    sizes : tuple of int
        Cells along a side of the lattices, in the order in which they are tried.
    last_size : int, optional
        One more size, for when a catch has neither been found nor ruled out.

    Returns
    -------
    Bounds
        The lower one ignores free spaces and obstacles smaller than a cell's diagonal.
    """
    return _bounds(Problem(situation, "oracle"), sizes, last_size)


def _bounds(problem: Problem, sizes: tuple[int, ...], last_size: int | None) -> Bounds:
    answer = problem.early_answer()
    if answer is not None:
        return Bounds(math.inf, math.inf, None, answer.status == "start_blocked")
    lower = _unhindered(problem)
    best = _straight(problem)
    for n in sizes:
        found = Bounds(lower, _time(best), best)
        if found.tight:
            return found
        lower, best = _refined(problem, n, found)
    found = Bounds(lower, _time(best), best)
    if last_size is not None and best is None and not found.tight:
        lower, best = _refined(problem, last_size, found)
    return Bounds(lower, _time(best), best)


def _time(plan: Plan | None) -> float:
    return math.inf if plan is None or plan.catch_time is None else plan.catch_time


def _refined(problem: Problem, n: int, known: Bounds) -> tuple[float, Plan | None]:
    """Both bounds on a lattice of n x n cells, given what is known."""
    outer = ReachableSet(problem, n, exact=False, before=known.upper)
    lower = known.lower
    if outer.sound:
        _, times = next(outer.meetings(), (None, [known.upper]))
        lower = max(lower, float(times[0]))
    best = known.plan
    if not math.isinf(lower):
        found = first_catch_of(problem, n, before=known.upper)
        best = best if found is None else found
    return min(lower, _time(best)), best


def _unhindered(problem: Problem) -> float:
    """Earliest interception by a hand that nothing hinders [s], infinite if there is none."""
    situation, arm = problem.situation, problem.situation.arm
    x, y = arm.hand
    t, *_ = first_interception(
        problem.bodies, x, y, 0.0, 0.0, situation.horizon + problem.instant,
        arm.max_hand_speed * (1.0 + 1e-9), arm.grasp, 0.0, math.inf, problem.instant,
    )  # fmt: skip
    return math.inf if t < 0.0 else max(t - problem.instant, 0.0)


def _straight(problem: Problem) -> Plan | None:
    """The straight planner's plan, under this planner's name."""
    plan = StraightPlanner("oracle").plan(problem.situation)
    return plan if plan.caught else None


def first_catch_of(
    problem: Problem, n: int, waiting: bool = True, before: float = math.inf
) -> Plan | None:
    """The first meeting of the inner set of which a verified plan can be made.

    Parameters
    ----------
    n : int
        Cells along a side of the lattice.
    waiting : bool
        Whether the set may wait.
    before : float
        Later catches are no use [s].
    """
    inner = ReachableSet(problem, n, exact=True, waiting=waiting, before=before)
    best: Plan | None = None
    tries: Counter[int] = Counter()
    for cells, times in inner.meetings():
        if times[0] >= before or tries.total() >= MEETINGS:
            break
        for cell, time in zip(cells.tolist(), times.tolist(), strict=True):
            if tries[cell] < A_CELL and _promises(problem, inner, cell, before):
                tries[cell] += 1
                plan = _catch_from(problem, inner, cell, time, waiting)
                if plan is not None and _time(plan) < before:
                    best, before = plan, _time(plan) * (1.0-WORTH)
    return best


def _promises(problem: Problem, inner: ReachableSet, cell: int, before: float) -> bool:
    front = inner.front
    ending = straight_catch(problem, inner.grid.centre[cell, :2], float(front.arrival[cell]))
    return ending is not None and ending[0][-1] < before


def _catch_from(
    problem: Problem, inner: ReachableSet, cell: int, time: float, waiting: bool
) -> Plan | None:
    """The earliest plan by the way to a cell at which a target is met at `time`."""
    came, left, hand = inner.way_to(cell)
    left[-1] = time if waiting else came[-1]
    best = _verified(problem, *_sampled(came, left, hand))
    if best is None:
        best = _verified(problem, *_sampled(came, came[-1:] if len(came) == 1 else np.append(left[:-1], came[-1]), hand))
    if best is None:
        return None
    for way in _shorter(problem, inner, came, left, hand):
        ending = straight_catch(problem, way[1][-1], float(way[0][-1]))
        if ending is None or ending[0][-1] >= _time(best) - 1e-6:
            continue
        plan = _verified(problem, *way)
        if plan is not None and _time(plan) < _time(best):
            best = plan
    return best


def _shorter(problem, inner, came, left, hand) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    speed = problem.situation.arm.max_hand_speed * (1.0 - 1e-8)
    arrival, departure, before = pull(problem.bodies, inner.rules, came, left, hand, speed)
    for j in range(len(came)):
        stops = [j]
        while before[stops[0]] >= 0:
            stops.insert(0, int(before[stops[0]]))
        first = stops[0]
        c = np.concatenate([came[:first+1], arrival[stops[1:]]])
        l = np.concatenate([left[:first], departure[stops[1:]], arrival[j:j+1]])
        p = np.concatenate([hand[:first], hand[stops]])
        yield _sampled(c, l, p)
        if before[j] < 0 and left[j] > came[j] + 1e-9:
            l = l.copy(); l[-1] = left[j]
            yield _sampled(c, l, p)


def _sampled(came, left, hand):
    time, way = [came[:1]], [hand[:1]]
    for k in range(len(came)):
        if left[k] > time[-1][-1]:
            time.append(left[k:k+1]); way.append(hand[k:k+1])
        if k + 1 < len(came):
            piece = straight_way(hand[k], hand[k+1])
            time.append(np.linspace(left[k], came[k+1], len(piece))[1:])
            way.append(piece[1:])
    return np.concatenate(time), np.concatenate(way)


def _verified(problem, time, hand):
    if len(time) < 2:
        return None
    attempt = finish(problem, hand, time)
    return None if attempt is None else checked(problem, attempt)[0]


def stratum(situation, known=None):
    if StraightPlanner().plan(situation).caught:
        return "L"
    problem = Problem(situation, "oracle")
    if problem.early_answer() is not None:
        return "U"
    if marching().plan(situation).caught or first_catch_of(problem, SIZES[-1], waiting=False) is not None:
        return "W"
    known = bounds(situation)
    return "Q" if known.plan is not None else "U"
