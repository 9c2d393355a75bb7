"""Equal experience with encoders of five times the turns, and fewer memories by the shipped order.

python -m experiments 17_is_memory_needed/longer DATASET train   the encoders that are missing
python -m experiments 17_is_memory_needed/longer DATASET ask     what is missing, then the outcomes

DATASET is a folder of `gcm-learn generate data/specs/recall.toml`, with a `count` of 15,000 or
more.  Finished parts are kept in out/ and not repeated.  H8 is decided as before: the learned index
is ahead of raw neighbours with 1 and within 20 checks at each size, after Holm.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Iterator
from functools import partial
from itertools import chain, product
from pathlib import Path

import numpy as np
from answers import Ask, Entrant, Judged, answered, by
from entrants import encoded, equal, shipped
from lessons import medoids
from trainings import TURNS, train

from experiments import recompute
from experiments.common import outcomes
from experiments.common.judging import Referee
from experiments.common.questions import asked, suite
from gcm_learn import dataset, seeding
from gcm_learn.recall import MEMORIES, Memory, shipped_memory

HERE = Path(__file__).resolve().parent
OUT = HERE / "out"
LONG = OUT / "longer"
FROZEN = HERE / "frozen-longer.json"
"""The commit that froze this code, and the seed that its hash gives."""
TIMES = 5  # the turns of the other encoders
SIZES = (1000, 10_000)
SEEDS = (0, 1, 2)
KEPT = (30, 100, 300, 1000)  # of the shipped memories
PICK = 18  # purpose of random numbers


def main() -> None:
    """Do one of the parts."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("dataset", type=Path)
    parser.add_argument("part", choices=("train", "ask"))
    given = parser.parse_args()
    if given.part == "train":
        train_all(given.dataset)
    else:
        ask(dataset.open(given.dataset))


def train_all(folder: Path) -> None:
    """Train what is missing, for few turns and for many."""
    for seed, size, (out, turns) in product(SEEDS, SIZES, ((OUT, TURNS), (LONG, TIMES * TURNS))):
        name = f"strict-{size}-{seed}"
        if not (out / "encoders" / name / "paths.npz").exists():
            train(name, folder, out, turns)


def ask(records: dataset.Dataset) -> None:
    """Ask what was not asked yet; write the outcomes, and what is computed from them."""
    seed = json.loads(FROZEN.read_text("utf-8"))["seed"]
    out = LONG / f"fresh-{seed}"
    whole, judged = asked(suite(seed, out / "draws")), Judged(Referee(), 4)
    everybody = chain(equal(records, LONG, SEEDS, SIZES), brief(), fewer(), shipped(records, OUT))
    rows = [answered(out / "answers", "fresh", who, whole, judged) for who in everybody]
    outcomes.write(HERE / "outcomes-longer.csv.gz", chain.from_iterable(rows))
    recompute.update(HERE)


def brief() -> Iterator[Entrant]:
    """Yield the same catches, filed by encoders of few turns."""
    for seed in SEEDS:
        for size in SIZES:
            yield encoded(f"brief-{size}", OUT, f"strict-{size}", seed)


def fewer() -> Iterator[Entrant]:
    """Yield the shipped encoder over some of its memories: medoids of paths, or drawn at random."""
    for seed in SEEDS:
        for count in KEPT:
            yield Entrant(f"medoids-{count}", seed, partial(_fewer, count, seed, medoids))
            yield Entrant(f"drawn-{count}", seed, partial(_fewer, count, seed, drawn))


def drawn(places: np.ndarray, count: int, seed: int) -> np.ndarray:
    """Return `count` of the rows (n, d), drawn by a seed."""
    return seeding.rng(seed, PICK).permutation(len(places))[:count]


def _fewer(count: int, seed: int, choose: Callable[..., np.ndarray]) -> Ask:
    memory = shipped_memory("recall")
    features = MEMORIES.of(memory.kind).path_features(memory.knots, memory.goals)
    kept = choose(features, count, seed)
    parts = (memory.embeddings[kept], memory.knots[kept], memory.goals[kept])
    return by(Memory.of(memory.index, *parts))


if __name__ == "__main__":
    main()
