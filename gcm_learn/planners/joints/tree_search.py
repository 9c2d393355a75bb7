"""The search in joints and time for any arm: straight moves, then trees from both ends."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, ClassVar

import numpy as np

from gcm_learn.collision import WORK
from gcm_learn.motion import Failure, Movement
from gcm_learn.planners.completion import Attempt, JointProblem, checked, ends_by_touch
from gcm_learn.planners.joints.carry import carried, has_place
from gcm_learn.planners.joints.end_search import EndSearch
from gcm_learn.planners.joints.meeting_trees import search_trees
from gcm_learn.planners.joints.ramped_ways import (
    cut_samples,
    hasten_ramped,
    ramped_samples,
    shorten_ramped,
)
from gcm_learn.planners.joints.ramps import END_FREE
from gcm_learn.planners.joints.still_trees import GOALS, search_still, straighten, timed
from gcm_learn.planners.joints.straight import at_once, earliest_straight
from gcm_learn.planners.joints.timely_trees import search_timely
from gcm_learn.planners.joints.tree_moves import LINES
from gcm_learn.planners.joints.trees import Trees, new_trees, roomier
from gcm_learn.planners.joints.ways import JointWay, hasten, new_way, samples_of, shorten
from gcm_learn.planners.plan import Deadline, Plan, deadline_of, end_of, in_joints
from gcm_learn.planners.stages import crossing
from gcm_learn.scene import TOP_SPEED
from gcm_learn.situation import AnySituation

SLICE = 100
"""Postures that catch to draw between two readings of the clock."""
ROUNDS = 6000
PATIENCE = 40
TWICE = 2
"""Times as many ends of movements as touches that are drawn; they are rarer."""
AFRESH = 1500
"""Ends of movements to draw before trees begin anew."""
VAIN = 10
"""Pairs of trees in a row that find nothing earlier, after which the search ends."""
MANY = 16
"""Times as many postures as the first pair of trees that later ones draw at most, by a deadline."""
LINKS = 16
"""Links of an arm that make a distance along a move twice as dear."""
FINISH = 300
"""Price of finishing a way, in distances along moves."""
TURNS = 16
"""One of so many turns draws a goal each round; the others are for trees in steps."""
ROOM = 1000
"""Nodes that new trees can hold."""
search_touching = partial(search_trees, LINES)
"""Trees whose roots are touches."""
Before = Callable[[JointProblem, float, int, int], Plan]
"""Plans a catch until an instant [s], by a seed and a number of postures that are drawn."""


@dataclass(frozen=True)
class TreeSearch:
    """Straight moves to postures that catch and trees from both ends, grown in turn.

    Every posture that catches is first tried by a straight move from the start.  Limits of
    acceleration are kept by every move.
    """

    name: str = "search"
    rounds: int = ROUNDS
    """Postures that catch to draw; the limit of work."""
    patience: int = 0
    """Postures to draw in vain for an earlier catch.  If positive, the straight line to the first
    interception comes before all: if it is free, hardly anything is earlier."""
    seed: int = 1

    takes = staticmethod(in_joints)

    anytime: ClassVar[bool] = True

    def plan(
        self,
        situation: AnySituation,
        bound: float | None = None,
        deadline: float | Deadline | None = None,
        begun: EndSearch | None = None,
    ) -> Plan:
        """Answer a situation.

        Parameters
        ----------
        situation : Situation
        bound : float, optional
            Only catches before this time are wanted [s]; e.g. that of a catch that is known.
        deadline : float or Deadline, optional
            See `Anytime`.  With it new trees look for an earlier catch until then.
        begun : EndSearch, optional
            Of the same situation and deadline, whose trees go on growing.
        """
        end = end_of(situation, bound)
        if begun is not None:
            return self._to_the_end(begun.problem, end, begun)
        problem = JointProblem(situation, self.name, deadline=deadline_of(deadline))
        early: Plan | None = problem.early_answer(keeps_acceleration=True, keeps_ends=True)
        if early is not None:
            return early
        if not ends_by_touch(problem.situation):
            return self._to_the_end(problem, end)
        simple = earliest_straight if self.patience and not problem.accelerates else at_once
        first = simple(problem)
        if first is not None and first.catch_time is not None and first.catch_time <= end:
            return first
        if problem.deadline is None:
            links = np.size(getattr(problem.scene.limb, "radii", 0))
            problem.budget[0] = WORK / (1.0 + links / LINKS)
        seed, rounds = self.seed, self.rounds
        plan = self._before(problem, end, seed, rounds)
        while not plan.caught and problem.deadline is not None and not problem.over:
            seed, rounds = seed + 1, min(2 * rounds, MANY * self.rounds)
            plan = self._before(problem, end, seed, rounds)
        if plan.caught:
            plan = self._sooner(problem, plan, self._before)
        return replace(plan, planning_ms=problem.elapsed_ms, nodes=problem.nodes)

    def _to_the_end(
        self, problem: JointProblem, end: float, begun: EndSearch | None = None
    ) -> Plan:
        """A catch until `end` [s] that is held, or after which the arm rests."""
        if problem.deadline is None:
            problem.budget[0] = WORK
        seed, left = self.seed, TWICE * self.rounds
        while True:
            plan = self.placed(problem, _with_end(problem, end, seed, left, begun))
            seed, left, begun = seed + 1, left - AFRESH, None
            if left <= 0 and problem.deadline is not None:
                left = AFRESH
            if plan.caught or problem.over or problem.budget[0] < 0 or left <= 0:
                break
        if problem.deadline is not None and plan.placed is None:
            plan = self._sooner(problem, plan, _with_end)
        return replace(plan, planning_ms=problem.elapsed_ms, nodes=problem.nodes)

    def placed(self, problem: JointProblem, plan: Plan) -> Plan:
        """Extend a plan until the caught target is in its place, if the target has a place."""
        if not plan.caught or not has_place(problem.situation, plan):
            return plan
        return carried(problem, plan, crossing(problem.situation.arm), self._with_rounds)

    def _with_rounds(self, rounds: int, situation: AnySituation) -> Plan:
        return replace(self, rounds=rounds).plan(situation)

    def _sooner(self, problem: JointProblem, plan: Plan, before: Before) -> Plan:
        """Look for earlier catches than a plan's, until the deadline or in patience."""
        rounds, tries = (self.patience, 1) if problem.deadline is None else (self.rounds, VAIN)
        seed, vain = self.seed, 0
        while plan.catch_time is not None and vain < tries and rounds and not problem.over:
            end, seed = plan.catch_time - problem.gain, seed + 1
            if end <= 0.0 or problem.budget[0] < 0:
                break
            sooner = before(problem, end, seed, rounds)
            plan, vain = (sooner, 0) if sooner.caught else (plan, vain + 1)
        return plan

    def _before(self, problem: JointProblem, end: float, seed: int, rounds: int) -> Plan:
        """A catch until `end` [s], by trees that are grown from new."""
        study, way = problem.study, new_way(problem.study.goal.size)
        obstacles = study.desk.obstacles.size > 0 and not problem.accelerates
        calm = obstacles and not study.scene.bodies.rows[:, TOP_SPEED].any()
        trees = new_trees(study, ROOM, seed, problem.accelerates)
        found, turn, left = None, 0, float(rounds)
        if calm:
            trees = new_trees(study, ROOM, seed, False)
        while left > 0 and found is None and not problem.over and problem.budget[0] >= 0:
            timely = obstacles and not calm and turn % TURNS > 0
            size, turn = min(SLICE, math.ceil(left)), turn + 1
            left -= GOALS * size if calm else 0 if timely else size
            if int(trees.size.max()) + 3 * size > trees.time.shape[1]:
                trees = roomier(trees)
            grow = search_still if calm else search_timely if timely else search_touching
            if not grow(study, trees, size, end, way):
                continue
            if not calm:
                found = _finished(problem, trees.moves, way, end)
                continue
            found = _stilled(problem, trees, way, end)
            problem.budget[0] -= FINISH
            problem.nodes += int(trees.size.sum()) - 1
            trees.size[:] = 1, 0  # another way may be quicker
        problem.nodes += int(trees.size.sum()) - 1  # the start was there
        if found is not None:
            return found
        return problem.answer(Failure.OUT_OF_TIME if problem.over else Failure.NO_TREE)


def _with_end(
    problem: JointProblem, end: float, seed: int, rounds: int, begun: EndSearch | None = None
) -> Plan:
    """A catch until `end` [s] that is held, or after which the arm rests."""
    search = EndSearch(problem, seed) if begun is None else begun
    return search.plan(end, min(rounds, AFRESH))


def search_in_space(effort: float = 1.0) -> TreeSearch:
    """Return the search for spatial arms; `effort` scales the number of postures drawn."""
    rounds, patience = (max(round(effort * most), 1) for most in (ROUNDS, PATIENCE))
    return TreeSearch(rounds=rounds, patience=patience)


def _stilled(problem: JointProblem, trees: Trees, way: JointWay, end: float) -> Plan | None:
    """Make a plan of a way in a world at rest; straighten a way that ends after `end` [s]."""
    study, short = problem.study, new_way(problem.study.goal.size)
    timed(study, way)
    shorten(study, way, short)
    if short.reached[short.size[0] - 1] > end:
        straighten(study, short)
    return _finished(problem, trees.moves, short, end)


def _finished(problem: JointProblem, moves: Any, way: JointWay, end: float) -> Plan | None:
    """Make a plan of a way, without needless postures and with an earlier catch.

    None if verification fails, or the way ends later than `end` [s].
    """
    study, short = problem.study, new_way(problem.study.goal.size)
    samples: tuple[np.ndarray, ...]
    if problem.accelerates:
        shorten_ramped(study, way, moves, END_FREE, short)
        hasten_ramped(study, short, moves)
        *samples, body = cut_samples(study, *ramped_samples(study, short, moves), short.body[0])
    else:
        shorten(study, way, short)
        hasten(study, short)
        *samples, body = samples_of(study, short)
    if samples[0][-1] > end:
        return None
    path = Movement(problem.situation.arm, *samples)
    return checked(problem, Attempt(path, int(body)))[0]
