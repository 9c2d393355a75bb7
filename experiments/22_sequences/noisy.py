"""Sequences in the closed loop: percepts are inexact, and one plans anew on the way.

python -m experiments 22_sequences/noisy        what is missing, then the outcomes and noisy.md

Finished situations are kept in out/ and not repeated. Ask on a machine that does nothing else.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import islice, product
from typing import Any

from run import FROZEN, HERE, OUT, ROUNDS, WARM, WORLDS, answer, drawn

from experiments import recompute
from experiments.common import outcomes
from experiments.common.asking import ask_in_turns, rows_of
from experiments.common.freezing import frozen_seed
from gcm_learn.execution import ExactPlant, Loop, Occasion, Perception, run_closed_loop
from gcm_learn.motion import Movement
from gcm_learn.planners import TreeSearch, get_planner
from gcm_learn.planners.orders import with_targets

COUNT = 100  # sequences
DEVIATIONS = (0.0, 0.005, 0.01)  # of a place [forearms]
HABITS = ("once", "broken")
PERIODS = 5  # of thinking, each time
OUTCOMES = ("running", "caught", "touched", "late")


@dataclass
class Sequencing:
    """An agent that plans several catches, in an order of its own.

    It thinks once, or whenever what it follows catches fewer of the promised targets, in the world
    as it is believed to be.
    """

    order: str
    leg: Any
    habit: str
    budget: float
    """Of a thought [s]."""
    promised: set[str] = field(default_factory=set)
    """Targets that the followed plan catches."""

    def wants(self, occasion: Occasion) -> bool:
        """Return whether it thinks now."""
        return occasion.thoughts == 0 or (self.habit == "broken" and self._breaks(occasion))

    def _breaks(self, occasion: Occasion) -> bool:
        believed = ExactPlant(occasion.believed)
        believed.follow(occasion.left, occasion.believed.horizon)
        left = self.promised & {target.name for target in occasion.believed.targets}
        return not left <= {catch.body for catch in believed.catches} or not left

    def plan(self, believed: Any) -> Movement | None:
        """Return the movement of the best plan within the budget, if there is one."""
        asked = with_targets(believed, {target.name for target in believed.targets})
        found, _ = answer(self.order, self.leg, asked, self.budget)
        if found is None:
            return None
        self.promised = {name for name, _ in found.on_the_way} | {str(found.catch_body)}
        moves: Movement | None = found.trajectory
        return moves


def legs() -> dict[str, tuple[str, Any]]:
    """Return the order and the planner of legs of all methods by name."""
    short = TreeSearch(rounds=ROUNDS["short search"])
    return {
        "time, search": ("time", TreeSearch(rounds=ROUNDS["search"])),
        "bound, short search": ("bound", short),
        "grow, search": ("grow", get_planner("search")),
        "bound, shipped memory before short search": ("bound", get_planner("hybrid")),
    }


def answers(
    number: int, situation: Any, asked: Sequence[tuple[str, tuple[str, Any]]]
) -> Iterator[dict[str, Any]]:
    """Yield the outcomes of all methods, with all habits and deviations."""
    about = {"situation": number, "targets": len(situation.targets), "stratum": "", "family": ""}
    budget = PERIODS * Perception().period
    for (name, (order, leg)), deviation, habit in product(asked, DEVIATIONS, HABITS):
        mind, loop = (
            Sequencing(order, leg, habit, budget),
            Loop(Perception(deviation), thinking=budget),
        )
        course = run_closed_loop(mind, ExactPlant(situation), situation, loop, 0, number)
        row = about | {"method": name, "deviation": deviation, "habit": habit}
        row |= {"got": len(course.catches), "caught": bool(course.catches)}
        yield row | {
            "touched": int(OUTCOMES[course.outcome] == "touched"),
            "thoughts": len(course.thoughts),
        }


def main() -> None:
    """Ask what is missing, and compute the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=COUNT, help="sequences (default: %(default)s)")
    given = parser.parse_args()
    seed, mine = frozen_seed(FROZEN, "space"), list(legs().items())
    cases = list(islice(drawn(WORLDS["space"], seed), WARM + given.count))
    for number, situation in cases[:WARM]:  # kernels are loaded now
        list(answers(number, situation, mine))
    file = OUT / f"noisy-{seed}.jsonl"
    ask_in_turns(file, cases[WARM:], mine, answers)
    outcomes.write(HERE / "outcomes-noisy.csv.gz", rows_of([file]))
    recompute.update(HERE)


if __name__ == "__main__":
    main()
