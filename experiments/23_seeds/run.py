"""Are recalled postures, instants and gates good seeds of trees? Writes outcomes, then tables.

python -m experiments 23_seeds DATASET train    the order of seeds and the model of postures
python -m experiments 23_seeds DATASET ask      the answers, then the outcomes

DATASET is a folder of `gcm-learn generate data/specs/recall-panda.toml`.  Finished parts are kept
in out/ and not repeated.  Ask on a machine that does nothing else.

H15 is decided by the shipped order, of `COUNT` seeds; the order of seeds was
added so that a failure is not the order's.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from time import process_time
from typing import Any, NamedTuple

import orders
import postures
from report import write_figure
from sources import Recalled

from experiments.common.asking import ask_in_turns, publish
from experiments.common.charging import after
from experiments.common.judging import Referee, judged
from gcm_learn import dataset
from gcm_learn.arms import CHAIN
from gcm_learn.families import draw
from gcm_learn.planners import TreeSearch
from gcm_learn.recall import (
    HybridPlanner,
    LearnedIndex,
    Memory,
    RandomIndex,
    RecallPlanner,
    load_encoder,
    remember,
    shipped_memory,
)

HERE = Path(__file__).resolve().parent
OUT = HERE / "out"
FROZEN = HERE / "frozen.json"
"""The commit that froze code and generator, and the seed that its hash gives."""
FAMILY = "panda-crowded"
SITUATIONS = 600
SEED = 1  # of both trainings
TURNS, STEPS = 100, 2000  # of the order, of the model
COUNT = 10  # seeds that are planted
BUDGET = 0.01  # thinking that is charged [s]
ROUNDS = 1500  # postures that the search draws at most: some hundred milliseconds
WARM = 3  # situations that are asked first and not counted


@dataclass
class Noted:
    """Seeds, and whether they alone made the trees meet the last time."""

    begin: Any
    met: bool = False

    def __call__(self, *given: Any) -> bool:
        """Plant them."""
        self.met = self.begin(*given)
        return self.met


class Method(NamedTuple):
    """Planner of the comparison."""

    name: str
    planner: Any
    seeds: Noted | None


def train(records: dataset.Dataset) -> None:
    """Train what is missing."""
    if not (OUT / "order" / "config.json").exists():
        orders.train(records, OUT / "order", SEED, TURNS)
    if not (OUT / "postures.pt").exists():
        net = postures.trained(remember(_learned_from(records), RandomIndex()), SEED, STEPS)
        postures.save(net, OUT / "postures.pt")


def _learned_from(records: dataset.Dataset) -> dataset.Dataset:
    return records.where(split="train")


def methods(records: dataset.Dataset) -> Iterator[Method]:
    """Yield all methods; the same search follows all seeds."""
    stored = remember(_learned_from(records), RandomIndex(), seed=SEED)
    shipped = stored.refiled(shipped_memory("recall", CHAIN).index)
    order = stored.refiled(LearnedIndex(load_encoder(OUT / "order")))
    said = postures.Said(postures.load(OUT / "postures.pt"), COUNT, gates=True)
    search = TreeSearch(rounds=ROUNDS)
    yield Method("search", search, None)
    yield _seeded("recalled, shipped order", Recalled(shipped, COUNT, gates=True))
    yield _seeded("recalled, order of seeds", Recalled(order, COUNT, gates=True))
    yield _seeded("recalled, no gates", Recalled(order, COUNT, gates=False))
    yield _seeded("stored, random", Recalled(stored, COUNT, gates=True))
    yield _seeded("model of postures", said)
    yield Method("whole movements", _whole(shipped, search), None)


def _seeded(name: str, begin: Any) -> Method:
    noted = Noted(begin)
    return Method(name, TreeSearch(rounds=ROUNDS, begin=noted), noted)


def _whole(memory: Memory, search: TreeSearch) -> HybridPlanner:
    return HybridPlanner(RecallPlanner(memory), fallback=search)


def ask(records: dataset.Dataset) -> None:
    """Ask all methods what is missing."""
    seed, mine = int(json.loads(FROZEN.read_text("utf-8"))["seed"]), [*methods(records)]
    cases = [(k, draw(FAMILY, seed, k)) for k in range(SITUATIONS)]
    for number, situation in cases[:WARM]:  # kernels are loaded now
        list(answers(number, situation, mine))
    file = OUT / f"answers-{seed}.jsonl"
    ask_in_turns(file, cases, mine, answers)
    publish(HERE, [file], write_figure)


def answers(number: int, situation: Any, asked: Sequence[Method]) -> Iterator[dict[str, Any]]:
    """Yield the outcomes of a situation that goes on while one thinks."""
    moved, referee = after(situation, BUDGET), Referee()
    for method in asked:
        row = {"situation": number, "stratum": "", "family": situation.name.split("-", 3)[3]}
        row |= {"method": method.name, "seed": None}
        if isinstance(moved, str):
            yield row | {"caught": moved == "caught", "ms": None, "alone": 0}
            continue
        since = process_time()
        plan = method.planner.plan(moved)
        row |= judged(plan, moved, referee, 1e3 * (process_time() - since))
        yield row | {"alone": int(method.seeds is not None and method.seeds.met)}


def main() -> None:
    """Do one of the parts."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("dataset", type=Path)
    parser.add_argument("part", choices=("train", "ask"))
    given = parser.parse_args()
    records = dataset.open(given.dataset)
    if given.part == "train":
        train(records)
    else:
        ask(records)


if __name__ == "__main__":
    main()
