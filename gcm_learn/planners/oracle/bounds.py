"""The yardstick: bounds on the earliest catch of any movement, waiting allowed, whole limb.

The places that the hand can reach are followed through space and time on a lattice:
R(t + dt) = dilate(R(t), v dt) minus what is occupied.  It is rounded once outwards and once inwards
(`reachable_set`).  The outer set's first meeting with a target comes before every catch; an outer
set that misses all targets rules catches out.  The inner set's meetings end movements, which are
pulled tight, timed and verified like every plan: the earliest of them is not before the earliest
catch.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any, Literal, NamedTuple, cast

import numpy as np

from gcm_learn.arms import PLANAR, SPATIAL, ByKind, Kind, SpatialArm
from gcm_learn.motion import Failure, Reason, anywhere, first_interception, straight_path
from gcm_learn.planners.baselines.straight import StraightPlanner
from gcm_learn.planners.completion import Problem, checked, finish
from gcm_learn.planners.fronts import marching
from gcm_learn.planners.oracle.moves import leg_from, pull
from gcm_learn.planners.oracle.reachable_set import Meeting, ReachableSet
from gcm_learn.planners.oracle.yardstick import Yardstick, oracle_in_space, yardstick
from gcm_learn.planners.plan import Plan
from gcm_learn.situation import AnySituation, Situation

SIZES = (60, 120)  # cells along a side, one lattice after the other until the bounds are tight
LAST_SIZE = 240  # for situations in which these neither find a catch nor rule it out
TIGHT = 0.02  # bounds that differ by at most this share are not refined
MEETINGS = 8  # of an inner set of which movements are made
A_CELL = 2  # of them in the same cell
LOOSE = 1.015  # paths on the lattice are worth pulling tight if they take at most that much longer
WORTH = 5e-4  # share of its time by which a catch must be earlier to be looked for
FINE = 1e-3  # interceptions are trusted as a bound at this resolution [forearm lengths]

Stratum = Literal["U", "L", "W", "Q"]


@dataclass(frozen=True)
class Bounds:
    """Bounds on a situation's earliest catch."""

    lower: float
    """No movement catches before [s]; infinite if none does within the horizon."""
    upper: float
    """Catch time of `plan` [s]; infinite if it does not catch."""
    plan: Plan
    """The best verified plan, or the reason for its absence."""

    @property
    def tight(self) -> bool:
        """True if the bounds agree to a share of TIGHT, or rule catches out."""
        return self.lower >= (1.0 - TIGHT) * self.upper

    @property
    def decided(self) -> bool:
        """True if a catch is known, or ruled out."""
        return self.plan.caught or math.isinf(self.lower)


@dataclass(frozen=True)
class OraclePlanner:
    """Planner with the upper bound's plan; slow, and as near to optimal as its finest lattice."""

    name: str = "oracle"
    sizes: tuple[int, ...] = SIZES
    last_size: int | None = LAST_SIZE
    trees_ms: float = 1000.0
    """In space, for ST-RRT* [ms], of which `yardstick` grants more; lattices are of the plane."""

    def takes(self, kind: Kind) -> bool:
        """Return whether there is a yardstick for arms of a kind."""
        return _BY_KIND.takes(kind)

    def plan(self, situation: AnySituation) -> Plan:
        """Answer a situation."""
        return _BY_KIND.of(situation)(self, situation)

    def _in_plane(self, situation: Situation) -> Plan:
        return bounds(situation, self.sizes, self.last_size).plan

    def _in_space(self, situation: Situation[SpatialArm]) -> Plan:
        return oracle_in_space(situation, self.trees_ms)


_BY_KIND: ByKind[Any] = ByKind(
    {PLANAR: OraclePlanner._in_plane, SPATIAL: OraclePlanner._in_space}, who="planner 'oracle'"
)


def bounds(
    situation: Situation, sizes: tuple[int, ...] = SIZES, last_size: int | None = LAST_SIZE
) -> Bounds:
    """Bound the earliest catch of any movement that keeps the rules of the world.

    Parameters
    ----------
    situation : Situation
    sizes : tuple of int
        Cells along a side of the lattices, in the order in which they are tried.
    last_size : int, optional
        One more size, for when a catch has neither been found nor ruled out.

    Returns
    -------
    Bounds
        The lower one knows no joint speeds.  It takes a cell for blocked when all its corners are
        by the same obstacle, so it holds but for free spots smaller than a cell within the image
        of one obstacle, and it is loosest where images taper, near the shoulder and the rim.
    """
    problem = Problem(situation, "oracle")
    answer = problem.early_answer()
    if answer is not None:
        return Bounds(math.inf, math.inf, answer)
    plan = StraightPlanner("oracle").plan(situation)
    known = Bounds(_unhindered(problem), _time(plan), plan)
    for n in sizes:
        if not known.tight:
            known = _refined(problem, n, known)
    if last_size is not None and not known.decided:
        known = _refined(problem, last_size, known)
    if known.plan.caught:
        elapsed = problem.elapsed_ms
        return replace(known, plan=replace(known.plan, planning_ms=elapsed))
    return replace(known, plan=problem.answer(_why(known)))


def stratum(situation: AnySituation, known: Bounds | Yardstick | None = None) -> Stratum:
    """Classify a situation by the movement that a catch needs; in space, see `yardstick`.

    - **L**, straight line: the planner `straight` catches.
    - **W**, way round: other than L, a first arrival catches.  Either the planner `marching` does,
      or the inner set that never waits (it leaves every cell when it comes, once) meets a target.
      From there a straight last leg, which may be slow, ends in a verified catch.
    - **Q**, queueing: neither, but `bounds` has a verified plan, which therefore waits.
    - **U**, unreachable: no plan at all.  `known.decided` says whether that is certain.

    Parameters
    ----------
    situation : Situation
    known : Bounds or Yardstick, optional
        The situation's bounds, if the caller has them at hand; of a spatial arm, its yardstick.
    """
    if situation.is_spatial:
        if not isinstance(known, Yardstick):
            known = yardstick(cast(Situation[SpatialArm], situation), earliest=False)
        return known.stratum
    return _stratum(cast(Situation, situation), cast(Bounds | None, known))


def _stratum(situation: Situation, known: Bounds | None) -> Stratum:
    if StraightPlanner().plan(situation).caught:
        return "L"
    known = bounds(situation) if known is None else known
    if math.isinf(known.lower):
        return "U"
    if marching().plan(situation).caught:
        return "W"
    problem = Problem(situation, "oracle")
    if any(earliest_catch(problem, n, waiting=False) is not None for n in SIZES):
        return "W"
    return "Q" if known.plan.caught else "U"


def earliest_catch(
    problem: Problem, n: int, *, waiting: bool = True, after: float = 0.0, before: float = math.inf
) -> Plan | None:
    """The best of the plans that an inner set's meetings give.

    Parameters
    ----------
    problem : Problem
    n : int
        Cells along a side of the lattice.
    waiting : bool
        Whether the hand may wait on its way to a meeting.
    after, before : float
        Catches before the one are known to be impossible, after the other of no use [s].

    Returns
    -------
    Plan
        None if no plan catches by then.
    """
    inner = ReachableSet(
        problem, n, exact=True, waiting=waiting, after=after, before=LOOSE * before
    )
    best: Plan | None = None
    tries: Counter[int] = Counter()
    for met in inner.meetings():
        if met[0].leave >= before or tries.total() >= MEETINGS:
            break
        for meeting in met:
            if meeting.time < LOOSE * before and tries[meeting.cell] < A_CELL:
                tries[meeting.cell] += 1
                plan = _catch_by(inner, meeting, before)
                if plan is not None:
                    best, before = plan, (1.0 - WORTH) * _time(plan)
    return best


def _time(plan: Plan) -> float:
    """Return the catch time of a plan [s]; infinite without a catch."""
    return math.inf if plan.catch_time is None else plan.catch_time


def _why(known: Bounds) -> Reason:
    """Return the reason why a plan is missing."""
    if math.isinf(known.lower):
        return Reason(Failure.IMPOSSIBLE)
    return Failure.UNDECIDED.with_numbers(since=known.lower)


def _unhindered(problem: Problem) -> float:
    """Earliest interception by a hand that nothing hinders [s]; 0 if that is not known.

    It is infinite without any interception.  In 3D the outer set alone would miss that: for it a
    target is where its solid is near, not where its cut with the plane is.
    """
    arm, instant = problem.situation.arm, problem.rules.instant
    if instant * arm.max_hand_speed > FINE:  # too coarse for targets that rush through
        return 0.0
    rules = problem.rules._replace(catch=arm.grasp, speed=arm.max_hand_speed * (1.0 + 1e-9))
    end = problem.situation.horizon + instant
    t, *_ = first_interception(anywhere(problem.scene), rules, *arm.hand, 0.0, 0.0, end)
    return math.inf if t < 0.0 else max(t - instant, 0.0)


def _refined(problem: Problem, n: int, known: Bounds) -> Bounds:
    """Refine both known bounds on a lattice of n x n cells."""
    lower, upper, plan = known.lower, known.upper, known.plan
    outer = ReachableSet(problem, n, exact=False, before=upper)
    if outer.sound:
        met = next(outer.meetings(), None)
        lower = max(lower, upper if met is None else met[0].time)
    if lower < upper:
        found = earliest_catch(problem, n, after=lower, before=upper)
        plan = plan if found is None else found
    return Bounds(min(lower, _time(plan)), _time(plan), plan)


def _catch_by(inner: ReachableSet, meeting: Meeting, before: float) -> Plan | None:
    """The earliest plan that follows the path to a meeting.

    The path is pulled tight, and from each of its stops the hand may dash for the target.
    """
    problem = inner.problem
    came, left, stops = inner.path_to(meeting.cell)
    left[-1] = meeting.leave
    arrival, departure, origin = pull(inner.regime, came, left, stops)
    end = min(before, meeting.time + inner.regime.rules.instant)
    for dash in sorted(_dashes(inner, stops, arrival, came, left, end)):
        chain = [dash.stop]
        while dash.tight and origin[chain[0]] >= 0:
            chain.insert(0, int(origin[chain[0]]))
        first, tight = chain[0], chain[1:]
        time, hand = _sampled(
            np.concatenate([came[: first + 1], arrival[tight]]),
            np.concatenate([left[:first], departure[tight], [dash.leave]]),
            np.concatenate([stops[: first + 1], stops[tight]]),
        )
        attempt = finish(problem, hand, time)
        plan = None if attempt is None else checked(problem, attempt)[0]
        if plan is not None and _time(plan) < before:
            return plan
    return None


class Dash(NamedTuple):
    """A clear straight leg from a stop to a target."""

    time: float
    """Catch time [s]."""
    stop: int
    leave: float
    """Instant at which it leaves the stop [s]."""
    tight: bool
    """The stop is reached by the path pulled tight, else by the path as it was."""


def _dashes(
    inner: ReachableSet,
    stops: np.ndarray,
    arrival: np.ndarray,
    came: np.ndarray,
    left: np.ndarray,
    end: float,
) -> Iterator[Dash]:
    """Yield dashes from all stops: at arrival on the tight path, or after waits of the original."""
    regime = inner.regime
    for k, (x, y) in enumerate(stops):
        chances = [(arrival[k], True)]
        if left[k] > came[k] or k + 1 == len(stops):
            chances.append((left[k], False))
        for leave, tight in chances:
            time = leg_from(regime, x, y, leave, max(leave, regime.after), end)
            if time >= 0.0:
                yield Dash(time, k, leave, tight)


def _sampled(
    came: np.ndarray, left: np.ndarray, stops: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Sample a path with waits at its stops: times (m,) and hands (m, 2), at least two."""
    time, hand = [came[:1], left[:1]], [stops[:1], stops[:1]]
    for k in range(1, len(stops)):
        piece = straight_path(stops[k - 1], stops[k])
        time += [np.linspace(left[k - 1], came[k], len(piece))[1:], left[k : k + 1]]
        hand += [piece[1:-1], stops[k : k + 1], stops[k : k + 1]]
    return np.concatenate(time), np.concatenate(hand)
