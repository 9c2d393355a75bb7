"""Adaptation: remembered catches are moved to a new situation, and tested for validity there.

Retrieved paths are repaired rather than replayed in Lightning and Thunder (Berenson, Abbeel and
Goldberg, ICRA 2012; Coleman, Sucan, Moll, Okada and Correll, ICRA 2015). Here a path gets new ends
without search, as dynamic movement primitives do, because that has to cost less than planning anew.
The verification that every plan goes through finds its faults.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Literal

import numpy as np

from gcm_learn.motion import SPACING, Movement, first_interception, refine, spread
from gcm_learn.planners import (
    Attempt,
    EndSearch,
    JointProblem,
    JointWay,
    Plan,
    Problem,
    at_once,
    attempt_of,
    earliest_straight,
    ends_by_touch,
    new_way,
    search_in_space,
)
from gcm_learn.recall import held_moves, trials
from gcm_learn.recall.hand_paths import HandQuery, HandWork, hand_work
from gcm_learn.recall.headings import heading_of, signs_of
from gcm_learn.recall.held_moves import HeldQuery
from gcm_learn.recall.joint_moves import JointQuery, JointWork, joint_work
from gcm_learn.recall.styles import CARTESIAN, HURRY, KEEP, POLAR, Style
from gcm_learn.recall.timed_moves import TimedQuery
from gcm_learn.recall.trials import Offer, TrialLimits
from gcm_learn.recall.waypoints import Waypoints, ring_share
from gcm_learn.situation import Situation

INSTANTS = 129  # of a quick check of a hand path
SLICE = 4  # held memories from one look at the clock to the next
SEED = 1  # of trees that memories grow
MOST_BENDS = 3  # changes at most of a joint movement, however many are allowed
STYLES = {"polar": POLAR, "cartesian": CARTESIAN}
TEMPOS = {"hurry": HURRY, "keep": KEEP}


@dataclass(frozen=True)
class Adaptation:
    """Settings of the adaptation of memories."""

    style: Literal["polar", "cartesian"] = "polar"
    """Coordinates in which the differences of the ends are spread along the path."""
    tempo: Literal["hurry", "keep", "both"] = "hurry"
    """Times that are kept: waits only ("hurry"), all of the memory's ("keep"), or one after the
    other."""
    bends: int = 5
    """Changes at most, one upon the other, of a path that looks as if it touched: it is pushed
    aside, or held back. Only what comes out of them is checked. In space there are three at
    most. Under limits of acceleration a path that touches is tried with other times, and pushed
    aside if it touches at all of them; 0 keeps the first time that the limits allow."""

    @cached_property
    def styles(self) -> np.ndarray:
        """Columns (s, 2): style and tempo of each try of a memory, in order."""
        tempos = ("hurry", "keep") if self.tempo == "both" else (self.tempo,)
        return np.array([[STYLES[self.style], TEMPOS[tempo]] for tempo in tempos])


DEFAULT = Adaptation()


def query_of(problem: Problem) -> HandQuery:
    """Return the `HandQuery` of a problem; all memories share the same query."""
    scene, rules, arm = problem.scene, problem.rules, problem.situation.arm
    x, y = arm.hand
    horizon = problem.situation.horizon
    soonest, _, _, _ = first_interception(scene, rules, x, y, 0.0, 0.0, horizon)
    return HandQuery(
        scene=scene,
        rules=rules,
        table=np.full((INSTANTS, len(scene.bodies.rows), 12), np.nan),
        angle=float(np.arctan2(y, x)),
        ring=float(ring_share(arm, np.hypot(x, y))),
        soonest=max(float(soonest), 0.0),
    )


class Tries(ABC):
    """Memories tried on a situation.

    Parameters
    ----------
    problem : Problem or JointProblem
    how : Adaptation
    """

    def __init__(self, problem: Any, how: Adaptation) -> None:
        self.problem, self.how = problem, how

    @property
    def begun(self) -> EndSearch | None:
        """Search whose trees memories grow; None for memories of touches."""
        return None

    @cached_property
    @abstractmethod
    def query(self) -> Any:
        """The situation in the form that the kernels of adaptation take."""

    @property
    def styles(self) -> np.ndarray:
        """Columns (s, 2): style and tempo of each try of a memory."""
        return self.how.styles

    @property
    def bends(self) -> int:
        """Changes at most of a path that touches."""
        return self.how.bends

    @abstractmethod
    def work(self) -> Any:
        """Return buffers of kernels."""

    @abstractmethod
    def attempt(self, work: Any, count: int, body: int) -> Attempt | None:
        """Return the path in the buffers as an attempt at a target."""

    def finished(self, plan: Plan) -> Plan:
        """Return a verified plan, continued past the catch where the situation asks for more."""
        return plan

    def first_valid(
        self, paths: tuple[np.ndarray, np.ndarray], offer: Offer, budget: TrialLimits
    ) -> tuple[int, int, Attempt | None]:
        """Find the first of the offered memories that is valid.

        Parameters
        ----------
        paths : (ndarray, ndarray)
            Knots and goals of all memories.
        offer : Offer
        budget : TrialLimits

        Returns
        -------
        place : int
            Position in the offer, -1 if none is valid.
        checked : int
            Paths that were checked.
        attempt : Attempt or None
            Path that the verification has still to confirm.
        """
        work = self.work()
        k, body, tried, count = trials.first_valid(
            self.query, _read_only(*paths), offer, self.styles, budget, work
        )
        return k, tried, self.attempt(work, count, int(body)) if k >= 0 else None

    def catch_times(self, knots: np.ndarray, goals: np.ndarray, chosen: np.ndarray) -> np.ndarray:
        """Return when memories catch, see `transfer`."""
        out: np.ndarray = trials.catch_times(
            self.query, _read_only(knots, goals), chosen, self.styles, self.bends, self.work()
        )
        return out


def _read_only(*arrays: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return views for kernels, which are compiled once more for arrays that can be written to."""
    views = tuple(array.view() for array in arrays)
    for view in views:
        view.flags.writeable = False
    return views


class HandTries(Tries):
    """Hand paths tried on a situation of a planar arm."""

    @cached_property
    def query(self) -> HandQuery:
        """The situation as a `HandQuery`."""
        return query_of(self.problem)

    def work(self) -> HandWork:
        """Return buffers of kernels."""
        made: HandWork = hand_work(self.query)
        return made

    def attempt(self, work: HandWork, count: int, body: int) -> Attempt:
        """Return the path in the buffers as an attempt, sampled for the joints, too."""
        arm = self.problem.situation.arm
        path = spread(work.best_time[:count], work.best_hand[:count], SPACING)
        return attempt_of(self.problem, *refine(arm, *path), body)


class JointTries(Tries):
    """Joint movements tried on a situation of a spatial arm or a chain.

    They have one tempo only; under limits of acceleration several times of the end are tried.
    """

    @cached_property
    def query(self) -> JointQuery | TimedQuery:
        """The situation as a `JointQuery`, or as a `TimedQuery` under limits of acceleration."""
        study, situation = self.problem.study, self.problem.situation
        made = TimedQuery if self.problem.accelerates else JointQuery
        shift = heading_of(study.scene.limb, study.scene).shift
        return made(study, signs_of(situation), shift)

    @property
    def styles(self) -> np.ndarray:
        """The only `Style` of joint movements, as a row (1, 2)."""
        return np.array([[POLAR, KEEP if self.how.tempo == "keep" else HURRY]])

    @property
    def bends(self) -> int:
        """Changes at most of a movement that touches."""
        return min(self.how.bends, MOST_BENDS)

    def work(self) -> JointWork:
        """Return buffers of kernels."""
        return joint_work(len(self.problem.situation.arm.joints))

    def attempt(self, work: JointWork, count: int, body: int) -> Attempt:
        """Return the movement in the buffers as an attempt."""
        rates = work.track.rates if self.problem.accelerates else None
        time, joints = work.best_time[:count], work.best_joints[:count]
        arm = self.problem.situation.arm
        return Attempt(Movement(arm, time, joints, rates), body)

    def first_valid(
        self, paths: tuple[np.ndarray, np.ndarray], offer: Offer, budget: TrialLimits
    ) -> tuple[int, int, Attempt | None]:
        """Find the first of the offered memories that is valid; see `Tries`."""
        if not self.problem.accelerates:
            budget = budget._replace(changes=self.bends)
        return super().first_valid(paths, offer, budget)


class HeldTries(Tries):
    """Held catches tried on a situation of a chain, in trees that they share."""

    @cached_property
    def begun(self) -> EndSearch:
        """The search whose trees memories grow."""
        return EndSearch(self.problem, SEED)

    @cached_property
    def query(self) -> HeldQuery:
        """The situation as a `HeldQuery`, with the trees of the search."""
        scene, search = self.problem.scene, self.begun
        shift = heading_of(scene.limb, scene).shift
        signs = signs_of(self.problem.situation)
        return HeldQuery(search.study, search.ends, search.trees, signs, shift)

    def work(self) -> JointWay:
        """Return buffers of kernels."""
        return new_way(len(self.problem.situation.arm.joints))

    def attempt(self, work: JointWay, count: int, body: int) -> Attempt | None:
        """Return the way with its end as an attempt."""
        return self.begun.attempt(work)

    def finished(self, plan: Plan) -> Plan:
        """Return the plan, continued by search until the target is in its place, if it has one."""
        return search_in_space().placed(self.problem, plan)

    def first_valid(
        self, paths: tuple[np.ndarray, np.ndarray], offer: Offer, budget: TrialLimits
    ) -> tuple[int, int, Attempt | None]:
        """Find the first of some memories by which the trees meet; see `Tries`.

        With a deadline a call tries at most `SLICE` memories, and none once it has passed.
        """
        if self.problem.over:
            return -1, 0, None
        way, budget = self.work(), budget._replace(tries=self.problem.slices(SLICE, budget.tries))
        k, tried, _ = self._in_turn(paths, offer, budget, False, way)
        return k, tried, self.attempt(way, 0, 0) if k >= 0 else None

    def catch_times(self, knots: np.ndarray, goals: np.ndarray, chosen: np.ndarray) -> np.ndarray:
        """Return when memories catch, each alone; see `transfer`."""
        count = len(chosen)
        places, left = np.zeros((count, 1), np.float32), np.ones(count, dtype=bool)
        offer, every = Offer(chosen, np.zeros(count), places, left), TrialLimits(0, count, 0.0, 0.0)
        return self._in_turn((knots, goals), offer, every, True, self.work())[2]

    def _in_turn(
        self, paths: tuple[np.ndarray, ...], offer: Offer, budget: TrialLimits, alone: bool,
        way: JointWay,
    ) -> tuple[int, int, np.ndarray]:  # fmt: skip
        """Return place, number tried, and times of `held_moves.in_turn`."""
        times = np.full(len(offer.chosen), -1.0)
        given = self.query, _read_only(*paths), offer, budget, alone, times, way
        return *held_moves.in_turn(*given), times


def tries_in_joints(problem: JointProblem, how: Adaptation) -> Tries:
    """Return `JointTries` for a problem in joints if a touch ends it, else `HeldTries`."""
    return JointTries(problem, how) if ends_by_touch(problem.situation) else HeldTries(problem, how)


def early_answer_in_space(problem: JointProblem) -> Plan | None:
    """Return the answer that needs no memory: hopeless, blocked, or caught at t = 0."""
    early = problem.early_answer(keeps_acceleration=True, keeps_ends=True)
    return at_once(problem) if early is None and ends_by_touch(problem.situation) else early


def straight_in_joints(problem: JointProblem) -> Plan:
    """Return the plan straight to the earliest interception, if a touch will do."""
    return problem.early_answer(keeps_acceleration=True) or earliest_straight(problem)


def adapt(
    problem: Problem,
    waypoints: Waypoints,
    how: Adaptation = DEFAULT,
    query: HandQuery | None = None,
) -> Attempt | None:
    """Adapt one memory to a situation, in the first style of `how` that meets a target in time.

    Parameters
    ----------
    problem : Problem
    waypoints : Waypoints
    how : Adaptation
    query : HandQuery, optional
        Query of the problem, if the caller has it at hand.

    Returns
    -------
    Attempt or None
        Not verified.
    """
    tries = HandTries(problem, how)
    query = tries.query if query is None else query
    work, paths = hand_work(query), (waypoints.knots[None], waypoints.goal[None])
    for style in how.styles:
        count, _, body = trials.adapted(query, paths, 0, Style(*style), work, how.bends)
        if count:
            return tries.attempt(work, count, int(body))
    return None


def transfer(
    situation: Situation | Problem,
    knots: np.ndarray,
    goals: np.ndarray,
    chosen: np.ndarray | None = None,
    how: Adaptation = DEFAULT,
) -> np.ndarray:
    """Return the catch times of memories adapted to a situation: labels for learning.

    Parameters
    ----------
    situation : Situation or Problem
        In any frame. The limb must be free at t = 0, or no memory is valid.
    knots, goals : (n, KNOTS, 4), (n, 2) ndarray of float32
        Memories, as of `Waypoints`.
    chosen : (m,) ndarray of int, optional
        Memories to adapt; all by default.

    Returns
    -------
    (m,) ndarray
        Catch time [s], negative for memories that do not catch.
    """
    problem = situation if isinstance(situation, Problem) else Problem(situation, "transfer")
    rows = np.arange(len(knots)) if chosen is None else chosen
    rows = np.ascontiguousarray(rows, dtype=np.int64)
    return HandTries(problem, how).catch_times(knots, goals, rows)
