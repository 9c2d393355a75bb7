"""Ask methods side by side about problems that others made.

python -m experiments 18_outside --motionbenchmaker problems.tar.bz2 --table-tennis rallies.json
    --si-rrt scene_task.json mass_test.json --seed 7
python -m experiments 18_outside --development ...   the part of the suites for development

The environment variables MOTIONBENCHMAKER, SI_RRT and TABLE_TENNIS name the files as well. A suite
without files is left out. Answers are kept in out/ and not asked again. Catches that take longer
than what is charged are late. The table and the figure beside this file are of an earlier run.
"""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import frozen
import suites
from suites import Question

from gcm_learn.arms import CHAIN
from gcm_learn.evaluation import Case, Condition, Entrant, ask, mark_late, page, pairs, shares
from gcm_learn.planners import Plan, STRRTStarPlanner

OUT = Path(__file__).resolve().parent / "out"
SEED = 0x1542C6D1
"""First eight hexadecimal digits of the commit that froze code and draws."""
PLANNERS = ("search", "straight-wait", "recall", "hybrid")
BUDGETS_MS = (10.0, 100.0)  # of ST-RRT*
CONDITIONS = [Condition(thinking) for thinking in (0.0, 0.02, 0.1)]


class Peer:
    """A planner of others, told the suites' own goal postures by the situations' names."""

    def __init__(self, goals: dict[str, Any], budget_ms: float | None = None) -> None:
        self.goals, self.budget = goals, budget_ms

    def takes(self, kind: Any) -> bool:
        """Return whether it takes arms of a kind."""
        return kind is CHAIN

    def plan(self, situation: Any) -> Plan:
        """Answer by ST-RRT* within the budget, without one by VAMP in a frozen world."""
        goal = self.goals.get(situation.name)
        if self.budget is None:
            return frozen.Frozen(situation, goal, float("inf")).run().plan
        postures = () if goal is None else (goal,)
        return STRRTStarPlanner(postures=postures).plan_anytime(situation, (self.budget,))[-1]


def questions(given: argparse.Namespace) -> Iterator[Question]:
    """Yield the questions of all suites that have files."""
    if given.motionbenchmaker is not None:
        yield from suites.problems(
            given.motionbenchmaker, given.seed, given.each, given.development
        )
    if given.si_rrt:
        yield from suites.scenes(given.si_rrt)
    if given.table_tennis is not None:
        yield from suites.balls(given.table_tennis, given.seed, given.balls, given.development)


def main() -> None:
    """Ask, and write what came of it."""
    given = _arguments().parse_args()
    asked, out = list(questions(given)), OUT / f"{given.seed:08x}{'d' * given.development}"
    free = [q for q in asked if not (q.start_blocked or q.goal_blocked)]
    goals = {q.name: q.goal for q in asked}
    entrants = [*PLANNERS, Entrant("vamp, frozen", Peer(goals))]
    entrants += [Entrant(f"st-rrt-star, {ms:g} ms", Peer(goals, ms)) for ms in BUDGETS_MS]
    found = [Case(q.situation, q.suite, q.family) for q in free]
    sheet = mark_late(ask(entrants, found, CONDITIONS, keep=out))
    sheet.save(out / "sheet.parquet")
    told = [f"{len(asked) - len(free)} situations begin or end blocked by our capsules."]
    told += [str(shares(sheet, ("suite", "entrant"))), str(pairs(sheet, "search", "suite"))]
    (out / "table.md").write_text("\n\n".join(told) + "\n", "utf-8")
    print(f"Open {page(sheet, out, reference='search').as_uri()} in a browser.")


def _arguments() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])

    def paths(name: str) -> list[Path]:
        return [Path(one) for one in os.environ.get(name, "").split(os.pathsep) if one]

    def path(name: str) -> Path | None:
        return next(iter(paths(name)), None)

    parser.add_argument("--motionbenchmaker", type=Path, default=path("MOTIONBENCHMAKER"))
    parser.add_argument("--si-rrt", type=Path, nargs="*", default=paths("SI_RRT"))
    parser.add_argument("--table-tennis", type=Path, default=path("TABLE_TENNIS"))
    parser.add_argument("--seed", type=lambda text: int(text, 16), default=SEED, help="hexadecimal")
    parser.add_argument("--each", type=int, default=suites.EACH, help="problems of each set")
    parser.add_argument("--balls", type=int, default=suites.BALLS)
    parser.add_argument("--development", action="store_true", help="the part for development")
    return parser


if __name__ == "__main__":
    main()
