"""Is a memory needed, and what is it worth with the same experience? Writes outcomes, then tables.

python -m experiments 17_is_memory_needed DATASET train     the encoders, one after the other
python -m experiments 17_is_memory_needed DATASET ask       what is missing, then the outcomes

DATASET is a folder of `gcm-learn generate data/specs/recall.toml`, with a `count` of 40,000: its
first 15,000 records hold enough for all but 30,000 catches.  Finished parts are kept in out/ and
not repeated.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from itertools import chain
from pathlib import Path
from typing import Any

from answers import Judged, answered
from entrants import equal, needed, resting, shipped
from questions import SPLITS, outside, waitless
from report import write_figure
from trainings import train, train_all

from experiments import recompute
from experiments.common import outcomes
from experiments.common.judging import Referee
from experiments.common.questions import asked, suite
from gcm_learn import dataset

HERE = Path(__file__).resolve().parent
OUT = HERE / "out"
FROZEN = HERE / "frozen.json"
"""The commit that froze code and generator, and the seed that its hash gives."""


def main() -> None:
    """Do one of the parts."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("dataset", type=Path)
    parser.add_argument("part", choices=("train", "ask"))
    parser.add_argument("--name", help="of one training")
    given = parser.parse_args()
    if given.part == "train" and given.name:
        train(given.name, given.dataset, OUT)
    elif given.part == "train":
        train_all(given.dataset, OUT)
    else:
        rows = ask(dataset.open(given.dataset))
        outcomes.write(HERE / "outcomes.csv.gz", chain.from_iterable(rows))
        recompute.update(HERE)
        write_figure(HERE / "figure.png", outcomes.read(HERE / "outcomes.csv.gz"))


def ask(records: dataset.Dataset) -> Iterator[list[dict[str, Any]]]:
    """Yield the outcomes of each entrant; those that lie in the folder are not asked again."""
    seed = json.loads(FROZEN.read_text("utf-8"))["seed"]
    whole, every = asked(suite(seed, OUT / f"fresh-{seed}" / "draws")), Judged(Referee(), 1)
    answers, fourth = OUT / "answers", every._replace(each=4)
    for group, some in waitless(whole).items():
        for who in resting(records, OUT):
            yield answered(answers, group, who, some, every)
    for split in SPLITS:
        some = outside(split, records.spec, OUT / "outside")
        for who in shipped(records, OUT):
            if who.method != "shipped-family-stratum":
                yield answered(answers, split, who, some, every)
    for who in chain(equal(records, OUT), needed(records, OUT), shipped(records, OUT)):
        yield answered(answers, "fresh", who, whole, fourth)


if __name__ == "__main__":
    main()
