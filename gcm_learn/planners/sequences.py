"""Several catches in one movement, leg after leg."""

from __future__ import annotations

import time as clock
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from gcm_learn.motion import Movement
from gcm_learn.planners.orders import Course, with_targets
from gcm_learn.planners.outside import verified_anew
from gcm_learn.planners.plan import Deadline, Plan
from gcm_learn.situation import AnySituation


def caught_in_turn(
    planner: Any, situation: AnySituation, deadline: float | Deadline | None = None
) -> Plan:
    """Catch targets one after the other, whichever the planner catches first.

    Each leg begins where the one before ends and is planned for the targets that are left. If "all"
    have to be caught and one is missed, another order begins with it. The whole
    movement is verified once more.

    Parameters
    ----------
    planner : Planner
        Plans the legs.
    situation : Situation
        Asks for "all" of its targets, or for "most" of them.
    deadline : float or Deadline, optional
        Processor time of the whole answer [s], shared evenly among legs.

    Returns
    -------
    Plan
        Of the order that catches most, of these the one that ends first.
    """
    since, targets = clock.perf_counter(), [target.name for target in situation.targets]
    given: dict[str, Any] = {}
    if deadline is not None:
        shared = isinstance(deadline, int | float)
        given["deadline"] = deadline / len(targets) if shared else deadline  # type: ignore
    best: list[Plan] = []
    first: str | None = None
    for _ in targets:
        legs = list(_legs(planner, situation, first, given))
        if not best or _worth(legs) > _worth(best):
            best = legs
        caught = {leg.catch_body for leg in legs if leg.caught}
        missed = [name for name in targets if name not in caught and name != first]
        if situation.catch == "most" or not missed:
            break
        first = missed[0]
    spent = 1e3 * (clock.perf_counter() - since)
    return joined(situation, best, spent)


def _legs(
    planner: Any, situation: AnySituation, first: str | None, given: dict[str, Any]
) -> Iterator[Plan]:
    """Yield plans, each in the situation that the one before leaves; the last may be no catch."""
    course = Course(replace(situation, catch="most"))
    while course.left:
        aimed = course.now if first is None else with_targets(course.now, {first})
        plan = planner.plan(aimed, **given)
        yield plan
        if not plan.caught:
            return
        course, first = course.with_leg(plan), None


def _worth(legs: list[Plan]) -> tuple[int, float]:
    """Return what makes an order better: catches, then an early end."""
    caught = [leg for leg in legs if leg.caught]
    return len(caught), -sum(leg.catch_time or 0.0 for leg in caught)


def joined(situation: AnySituation, legs: Sequence[Plan], spent: float) -> Plan:
    """Return the plan of all legs, verified, or the reason for its absence.

    Parameters
    ----------
    situation : Situation
    legs : sequence of Plan
        Each in the situation that the one before leaves; catches come first.
    spent : float
        Time of planning [ms].
    """
    caught = [leg for leg in legs if leg.caught]
    missing = len(situation.targets) - len(caught)
    if not caught:
        return replace(legs[0], planning_ms=spent)
    if situation.catch == "all" and missing:
        message = f"{len(caught)} of {len(situation.targets)} targets are caught in the best order"
        return Plan(situation.name, legs[0].planner, "unreachable", message, spent)
    moves, ends = _movement(situation, caught)
    names = [str(leg.catch_body) for leg in caught]
    fault, clearance = verified_anew(situation, moves, names[-1])
    if fault is not None:
        message = f"the legs do not join: {fault}"
        return Plan(situation.name, legs[0].planner, "unreachable", message, spent)
    events = ", ".join(f"{name!r} at {t:.3f} s" for name, t in zip(names, ends, strict=True))
    return Plan(
        situation.name, legs[0].planner, "caught", f"caught {events}", spent, ends[-1], names[-1],
        clearance, moves, nodes=sum(leg.nodes for leg in legs),
        on_the_way=tuple(zip(names[:-1], ends[:-1], strict=True)),
    )  # fmt: skip


def _movement(situation: AnySituation, legs: list[Plan]) -> tuple[Movement, list[float]]:
    """Return the movement of all legs, and when each ends [s]."""
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
    last = np.cumsum([len(part.time) for part in parts]) - 1 - np.arange(len(parts))
    return moves, time[last].tolist()
