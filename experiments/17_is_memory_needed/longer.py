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
import subprocess
import sys
from collections.abc import Callable, Iterator
from functools import partial
from itertools import chain
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
KEPT = (30, 100, 300, 1000, 3441)  # memories; the last are all that are shipped
PICK = 18  # purpose of random numbers


def main() -> None:
    """Do one of the parts."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("dataset", type=Path)
    parser.add_argument("part", choices=("train", "ask"))
    parser.add_argument("--name", help="of one training")
    given = parser.parse_args()
    if given.part == "train" and given.name:
        train_one(given.name, given.dataset)
    elif given.part == "train":
        train_all(given.dataset)
    else:
        ask(dataset.open(given.dataset))


def train_one(name: str, folder: Path) -> None:
    """Train an encoder for few turns or for many."""
    kind, rest = name.split("-", 1)
    if kind == "long":
        train(f"strict-{rest}", folder, LONG, TIMES * TURNS)
    else:
        train(f"strict-{rest}", folder, OUT)


def train_all(folder: Path) -> None:
    """Train what is missing, each in a process of its own."""
    for seed in SEEDS:
        for size in SIZES:
            for kind, out in (("brief", OUT), ("long", LONG)):
                if not (out / "encoders" / f"strict-{size}-{seed}" / "paths.npz").exists():
                    script = ("-m", "experiments", f"{HERE.name}/{Path(__file__).stem}")
                    name = ("train", "--name", f"{kind}-{size}-{seed}")
                    subprocess.run([sys.executable, *script, str(folder), *name], check=True)


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
        for count in KEPT[:-1]:
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
