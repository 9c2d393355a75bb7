"""Several catches in one movement, leg after leg."""

from __future__ import annotations

import time as clock
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from gcm_learn.motion import Movement
from gcm_learn.planners.orders import LegCourse, bounded, growing
from gcm_learn.planners.outside import GOING_ON, judged_anew
from gcm_learn.planners.plan import Catch, Deadline, Plan, deadline_of
from gcm_learn.situation import AnySituation

LEGS = 24  # that are planned without a deadline


def caught_in_turn(
    planner: Any, situation: AnySituation, deadline: float | Deadline | None = None
) -> Plan:
    """Catch targets one after the other, in an order by branch and bound.

    Each leg begins where the one before ends and is planned for one target.  The whole movement is
    verified once more.

    Parameters
    ----------
    planner : Planner
        Plans the legs.
    situation : Situation
        Asks for "all" of its targets, or for "most" of them.
    deadline : float or Deadline, optional
        Processor time of the whole answer [s].  A leg that has begun is ended.  Legs of a planner
        that is `Anytime` have little time at first, see `orders.growing`.  Without a deadline
        at most `LEGS` legs are planned.

    Returns
    -------
    Plan
        Of the order that catches most, of these the one that ends first.
    """
    since, limit = clock.perf_counter(), deadline_of(deadline)
    best = LegCourse(replace(situation, catch="most"))
    order = growing if limit is not None and getattr(planner, "anytime", False) else bounded
    asked: list[Plan] = []

    goes_on = situation.format in GOING_ON

    def leg(now: Any, **given: Any) -> Plan:
        if goes_on:  # a leg begins as the one before ended: at rest
            now = replace(now, end="rest")
        asked.append(planner.plan(now, **given))
        return asked[-1]

    def halt() -> bool:
        return len(asked) >= LEGS if limit is None else bool(asked) and limit.over

    for course in order(leg, best, halt):
        best = course
    legs = [*best.legs, *(plan for plan in asked if not plan.caught)]
    return joined(situation, legs or [leg(best.now)], 1e3 * (clock.perf_counter() - since))


def joined(situation: AnySituation, legs: Sequence[Plan], spent: float) -> Plan:
    """Join all legs to one verified plan; without a catch, the plan has the reason.

    Parameters
    ----------
    situation : Situation
    legs : sequence of Plan
        Each in the situation that the one before leaves; catches come first.
    spent : float
        Time of planning [ms].
    """
    caught = [leg for leg in legs if leg.caught]
    missing, form = len(situation.targets) - len(caught), situation.format
    if not caught:
        return replace(legs[0], planning_ms=spent)
    if situation.catch == "all" and missing:
        message = f"{len(caught)} of {len(situation.targets)} targets are caught in the best order"
        return Plan(situation.name, legs[0].planner, "unreachable", message, spent, format=form)
    moves, since = _movement(situation, caught)
    bodies = [target.name for target in situation.targets]
    catches = [_later(leg, start, moves) for leg, start in zip(caught, since, strict=True)]
    # ties in the order of the bodies
    catches.sort(key=lambda catch: (catch.time, bodies.index(catch.body)))
    last = catches[-1]
    if situation.end == "free":
        moves = moves.until(max(t for t in last[1:] if t is not None))
    plan = Plan(
        situation.name, legs[0].planner, "caught", "", spent, last.time, last.body, None, moves,
        nodes=sum(leg.nodes for leg in legs), on_the_way=tuple(catches[:-1]),
        held_until=last.held_until, placed=last.placed, format=form,
    )  # fmt: skip
    fault, clearance = judged_anew(situation, plan)
    if fault is not None:
        message = f"the legs do not join: {fault}"
        return Plan(situation.name, legs[0].planner, "unreachable", message, spent, format=form)
    events = ", ".join(f"{one.body!r} at {one.time:.3f} s" for one in catches)
    return replace(plan, message=f"caught {events}", clearance=clearance)


def _later(leg: Plan, since: float, moves: Movement) -> Catch:
    """Return the catch of a leg that begins at a time, at samples of the whole movement [s]."""
    times = [None if t is None else since + t for t in (leg.catch_time, leg.held_until, leg.placed)]
    found = [
        None if t is None else float(moves.time[np.abs(moves.time - t).argmin()]) for t in times
    ]
    return Catch(str(leg.catch_body), found[0] or 0.0, *found[1:])


def _movement(situation: AnySituation, legs: list[Plan]) -> tuple[Movement, list[float]]:
    """Return the movement of all legs, and when each begins [s]."""
    parts: list[Any] = [leg.trajectory for leg in legs]
    ends = np.cumsum([part.duration for part in parts])
    first = [0] + [1] * (len(parts) - 1)  # where a leg begins, the one before has ended

    def end_to_end(columns: list[np.ndarray]) -> np.ndarray:
        return np.concatenate([column[k:] for column, k in zip(columns, first, strict=True)])

    time = end_to_end(
        [part.time + end - part.duration for part, end in zip(parts, ends, strict=True)]
    )
    curved = all(part.rates is not None for part in parts)
    rates = end_to_end([part.rates for part in parts]) if curved else None
    moves = Movement(situation.arm, time, end_to_end([part.joints for part in parts]), rates)
    return moves, (ends - [part.duration for part in parts]).tolist()
