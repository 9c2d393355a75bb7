"""Pick and place: a catch, then a carry of the caught target to its place."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np

from gcm_learn.motion import Ask, Carry, Failure, Movement, verify
from gcm_learn.planners.completion import JointProblem
from gcm_learn.planners.plan import Plan
from gcm_learn.scene import pack
from gcm_learn.situation import AnySituation

SPANS = (0.25, 0.5, 1.0, 2.0, 4.0)
"""Times in which a target is carried, in those that an arm takes to cross its reach."""
ROUNDS = (60, 600)
"""Ends of movements that are drawn for each of them, at first and then."""

SHORTER = 0.7
"""Share of the time of a carry in which a quicker one is looked for."""


def has_place(situation: AnySituation, plan: Plan) -> bool:
    """Return whether the target that a plan catches has a place."""
    return any(t.name == plan.catch_body and t.place for t in situation.targets)


def carried(
    problem: JointProblem, plan: Plan, crossing: float, solved: Callable[[int, Any], Plan]
) -> Plan:
    """Extend a plan from the end of its hold until the target is placed.

    Parameters
    ----------
    problem : JointProblem
    plan : Plan
        Holds a target and then rests.
    crossing : float
        Time in which the arm crosses its reach [s].
    solved : callable
        Plans for a situation that ends at rest, with a number of ends that may be drawn.
    """
    situation, held, moves = problem.situation, plan.held_until, plan.trajectory
    assert held is not None and moves is not None
    index = [body.name for body in situation.bodies].index(str(plan.catch_body))
    carry, reason = Carry(situation, index, moves, held), ""

    def made(rounds: int, span: float) -> Plan | None:
        nonlocal reason
        way = solved(rounds, carry.at(held, span, ignores=True))
        reason = way.message
        return _joined(problem, plan, carry, way) if way.caught else None

    for rounds, share in product(ROUNDS, SPANS):
        if problem.over:
            reason = Failure.OUT_OF_TIME.value
            break
        better = found = made(rounds, share * crossing)
        while better is not None and not problem.over:
            found = better
            better = made(ROUNDS[0], SHORTER * (float(found.placed or 0.0) - held))
        if found is not None:
            return found
    why = Failure.NO_CARRY.with_numbers(target=repr(plan.catch_body), reason=reason)
    return problem.answer(why)


def _joined(problem: JointProblem, plan: Plan, carry: Carry, way: Plan) -> Plan | None:
    """Join a hold and a carry to one plan; None if the whole movement fails verification."""
    held, moves, after = carry.held, carry.moves.until(carry.held), way.trajectory
    assert after is not None and moves.rates is not None and after.rates is not None
    whole = Movement(
        problem.situation.arm,
        np.concatenate([moves.time, held + after.time[1:]]),
        np.vstack([moves.joints, after.joints[1:]]),
        np.vstack([moves.rates, after.rates[1:]]),
    )
    placed, time = whole.duration, float(plan.catch_time or 0.0)
    ask = Ask.of(problem.situation, [(carry.number, time, held)])
    scene = pack(problem.situation, max(problem.situation.horizon, placed))
    verdict = verify(scene, problem.rules, whole, carry.number, ask)
    if not verdict.good:
        return None
    failure, clearance, _ = carry.fault(placed, whole)
    if failure is not None:
        return None
    return replace(
        plan,
        trajectory=whole,
        placed=placed,
        clearance=min(clearance, float(plan.clearance or 0.0), verdict.clearance),
        message=f"{plan.message}, placed at {placed:.3f} s",
    )
