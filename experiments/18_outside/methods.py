"""Methods that are compared, and their answers as rows of outcomes.

A method that thinks for a time is asked about the situation as it is after that time, and its arm
rests meanwhile.  An answer that takes longer counts as lost.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from time import process_time
from typing import Any, NamedTuple

import frozen
from suites import Question

from gcm_learn.arms import CHAIN
from gcm_learn.errors import ArmKindError
from gcm_learn.evaluation import after, complaints
from gcm_learn.planners import Plan, STRRTStarPlanner, get_planner, takes
from gcm_learn.scene import pack

CHARGES_MS = (0.0, 20.0, 100.0)
OURS = "search"
"""Planner whose processor time is the unit of ST-RRT*'s budgets."""
PLANNERS = (OURS, "straight-wait", "recall", "hybrid")
"""Planners of the package; those that do not take chains are left out."""
TREES, VAMP = "st-rrt-star", "vamp, frozen"
BUDGETS_MS = (1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)
SHORTEST_MS, LONGEST_MS = 0.5, 1000.0  # of budgets from our time
SHARES = (0.25, 0.5, 0.7, 0.85, 0.95)  # of the time to think, for a search that has to end by then


class Answer(NamedTuple):
    """Answer of a method."""

    plan: Plan
    ms: float
    """Processor time to the first catch, or to giving up [ms]."""
    more: dict[str, Any]
    """Further columns."""


class Judged:
    """Verdicts of the tests' referee on the catches of a situation, each movement judged once."""

    def __init__(self) -> None:
        self._known: dict[bytes, list[str]] = {}

    def complaints(self, situation: Any, plan: Plan) -> list[str]:
        """Return what the referee complains of."""
        moves: Any = plan.trajectory
        key = moves.time.tobytes() + moves.joints.tobytes()
        if key not in self._known:
            self._known[key] = complaints(situation, plan)
        return self._known[key]


Method = Callable[[Question, Any, float, float], dict[str, Answer]]
"""Answers by name, of a question, its situation when thought is over, the time to think and our
processor time on it [ms]."""


def planned(name: str) -> Method:
    """Return a planner of the package as a method."""
    planner: Any = get_planner(name)

    def answer(question: Question, situation: Any, charge: float, ours: float) -> dict[str, Answer]:
        since = process_time()
        plan = planner.plan(situation)
        return {name: Answer(plan, 1e3 * (process_time() - since), {})}

    return answer


def trees(question: Question, situation: Any, charge: float, ours: float) -> dict[str, Answer]:
    """Return ST-RRT* with our time, ten times it, and 100 ms; some goals are near the suite's.

    Packing the situation is not part of our time.
    """
    postures = () if question.goal is None else (question.goal,)
    planner = STRRTStarPlanner(postures=postures)
    if charge > 0.0:
        budgets = tuple(share * charge for share in SHARES)
        plans = planner.plan_anytime(situation, budgets)
        timely = [plan for plan in plans if plan.planning_ms <= charge]
        return {f"{TREES}, 100 ms": _first(timely or plans[:1])}
    ours = max(ours - _packing(question), SHORTEST_MS)
    wanted = {"our time": ours, "10 x": min(10.0 * ours, LONGEST_MS), "100 ms": BUDGETS_MS[-1]}
    budgets = tuple(sorted({*BUDGETS_MS, *wanted.values()}))
    plans = planner.plan_anytime(situation, budgets)
    return {
        f"{TREES}, {label}": _first(plans[: 1 + budgets.index(budget)])
        for label, budget in wanted.items()
    }


def _packing(question: Question) -> float:
    """Return the processor time to pack a situation, which all planners of the package need."""
    since = process_time()
    pack(question.situation)
    return 1e3 * (process_time() - since)


def _first(plans: list[Plan]) -> Answer:
    """Return the last plan, and when there was a first catch."""
    ms = [plan.planning_ms for plan in plans if plan.caught]
    return Answer(plans[-1], min(ms, default=plans[-1].planning_ms), {})


def replanned(question: Question, situation: Any, charge: float, ours: float) -> dict[str, Answer]:
    """Return VAMP on the frozen world, which has a period to plan where thought is charged."""
    limit = charge if charge > 0.0 else float("inf")
    done = frozen.Frozen(situation, question.goal, limit).run()
    more = {"inner_ms": round(done.inner_ms, 3), "slowest_ms": round(done.slowest_ms, 3)}
    if done.plan.caught:
        more["kept"] = int(done.good)
        more["met"] = int(charge == 0.0 or done.first_ms <= charge)
        more["own_touch"] = int(frozen.touches(situation, done.plan))
    return {VAMP: Answer(done.plan, done.first_ms, more)}


def methods() -> dict[str, Method]:
    """Return all methods that can be asked here, ours first."""
    taken = [name for name in PLANNERS if takes(get_planner(name), CHAIN)]
    return {name: planned(name) for name in taken} | {TREES: trees, VAMP: replanned}


def rows_of(question: Question, asked: dict[str, Method]) -> Iterator[dict[str, Any]]:
    """Yield the answers of all methods to a question as rows.

    Catches without charged thought are judged by the tests' referee, all others by `verify`.
    """
    ours, judged, packing = 0.0, Judged(), _packing(question)
    for charge in CHARGES_MS:
        fate, situation = _begun(question.situation, charge)
        for name, method in asked.items():
            if name == VAMP and not frozen.takes(question.situation):
                continue
            about = question.about() | {"charge": charge, "pack_ms": round(packing, 3)}
            if fate:
                for label in _labels(name):
                    yield about | {"method": label, "caught": fate == "caught", "fate": fate}
                continue
            try:
                answers = method(question, situation, charge, ours)
            except ArmKindError:  # a memory holds catches of arms with other joints
                continue
            for label, answer in answers.items():
                if label == OURS and charge == 0.0:
                    ours = answer.ms
                yield about | {"method": label} | _row(answer, situation, charge, judged)


def _labels(name: str) -> list[str]:
    """Return the names of a method's answers."""
    return [f"{TREES}, 100 ms"] if name == TREES else [name]


def _begun(situation: Any, charge: float) -> tuple[str, Any]:
    """Return what becomes of an arm that rests meanwhile, and the situation after it."""
    moved = after(situation, 1e-3 * charge)
    return (moved, None) if isinstance(moved, str) else ("", moved)


def _row(answer: Answer, situation: Any, charge: float, judged: Judged) -> dict[str, Any]:
    """Return the columns of an answer."""
    plan, row = answer.plan, {"ms": round(answer.ms, 3), "caught": answer.plan.caught}
    row |= {"fate": plan.status} | answer.more
    if not plan.caught:
        return row
    assert plan.catch_time is not None
    row["catch_time"] = plan.catch_time + 1e-3 * charge
    if charge > 0.0:
        row["caught"] = answer.ms <= charge and bool(answer.more.get("kept", 1))
        return row
    found = judged.complaints(situation, plan)
    if "kept" in answer.more:  # a movement that was acted claims no clearance
        found = [text for text in found if not text.startswith("clearance")]
    return row | {"complaints": len(found), "complaint": found[0].split(",")[0] if found else ""}
