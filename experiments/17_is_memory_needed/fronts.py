"""Ask fronts that answer first, and fallbacks that plan after them; thinking is charged.

python -m experiments 17_is_memory_needed/fronts     the first 200 of W and of Q: writes outcomes
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from experiments import recompute
from experiments.common import outcomes
from experiments.common.judging import Referee, judged, outcome
from experiments.common.questions import Question, asked, suite
from gcm_learn.evaluation.kinds import resting
from gcm_learn.planners import Planner, get_planner
from gcm_learn.scene import later

HERE = Path(__file__).resolve().parent
TIMED = 200  # situations of W and of Q
CHARGED = 0.02  # thinking [s]
BUDGET_MS = 15.0  # of ST-RRT*: with its opening and verification it is to be ready by 20 ms
WARM = 5  # situations that are asked before the clock runs
TREES = "ST-RRT*"
FRONTS = {
    "learned": "recall", "raw": "recall-raw", "random": "recall-random",
    "splines": "splines-random",
}  # fmt: skip
FALLBACKS = {"gcm": "gcm", "marching": "marching", "layered": "layered", TREES: "st-rrt-star"}


def planners() -> dict[str, Planner]:
    """Fronts and fallbacks by name."""
    found = {name: get_planner(known) for name, known in (FRONTS | FALLBACKS).items()}
    trees: Any = found[TREES]
    return found | {TREES: replace(trees, budget_ms=BUDGET_MS)}


def parts(
    rows: Sequence[Question], referee: Referee, who: Mapping[str, Planner]
) -> Iterator[dict[str, Any]]:
    """Yield outcomes of each planner in every situation as it is after 20 ms of rest.

    `rests` says what becomes of an arm that is touched or catches meanwhile: nobody is asked then.
    """
    for question in rows[:WARM]:
        for planner in who.values():
            planner.plan(question.situation)
    for question in rows:
        about = question.about() | {"rests": resting(question.situation, CHARGED)}
        after = later(question.situation, CHARGED)
        for name, planner in who.items():
            if about["rests"]:
                row: dict[str, Any] = {"caught": about["rests"] == "caught", "ms": 0.0}
            elif name == TREES:  # thinks in a process of its own
                plan = planner.plan(after)
                row = judged(plan, after, referee, plan.planning_ms)
            else:
                row = outcome(planner, after, referee)
            yield about | {"method": name} | row


def main() -> None:
    """Ask all of the frozen suite; write the outcomes, and the tables from them."""
    seed = json.loads((HERE / "frozen.json").read_text("utf-8"))["seed"]
    folder = HERE / "out" / f"fresh-{seed}" / "draws"
    rows = asked(suite(seed, folder, TIMED), TIMED)
    outcomes.write(HERE / "outcomes-fronts.csv.gz", parts(rows, Referee(), planners()))
    recompute.update(HERE)


if __name__ == "__main__":
    main()
