"""Ask recall and its controls of the fresh suites in the plane; writes outcomes, then tables.

python -m experiments 05_recall             the fresh suite: half an hour
python -m experiments 05_recall standin     situations unlike the families'

Draws of the fresh suite are kept in out/. Neighbours are found by a learned index, by clearance
features or raw parameters that nothing was learned from, and at random.
"""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import standin
from entrants import entrants
from neighbours import ClearanceIndex

from experiments import recompute
from experiments.common import outcomes
from experiments.common.judging import Referee, outcome
from experiments.common.questions import Question, asked, suite
from gcm_learn.recall import RandomIndex, RawIndex, RecallPlanner, shipped_memory

HERE = Path(__file__).resolve().parent
SEED = 3887612067
WARM = 5  # situations that are asked before the clock runs


def all_entrants() -> dict[str, RecallPlanner]:
    """Return all that answer, with twenty checks and with one, by name."""
    memory = shipped_memory("recall")
    situations = memory.situations()
    indexes: dict[str, Any] = {
        "recall-clearance": ClearanceIndex.fit(situations),
        "recall-raw": RawIndex.fit(situations),
        "recall-random": RandomIndex(),
    }
    return entrants(memory, indexes)


def suite_of(name: str) -> list[Question]:
    """Return the situations of a suite."""
    if name == "standin":
        return standin.suite(SEED)
    return asked(suite(SEED, HERE / "out" / f"draws-{SEED}"))


def main() -> None:
    """Ask everybody, write the outcomes and what is computed from them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("suite", nargs="?", default="fresh", choices=("fresh", "standin"))
    name = parser.parse_args().suite
    questions, rows, referee = suite_of(name), [], Referee()
    for method, planner in all_entrants().items():
        for question in questions[:WARM]:
            planner.plan(question.situation)
        for question in questions:
            about = question.about() | {"method": method}
            rows.append(about | outcome(planner, question.situation, referee))
        print(method, flush=True)
    outcomes.write(HERE / f"outcomes-{name}.csv.gz", rows)
    recompute.update(HERE)


if __name__ == "__main__":
    main()
