"""Is a memory needed in space, and what is it worth with the same experience?

python -m experiments 17_is_memory_needed/space DATASET train   the encoders, one after the other
python -m experiments 17_is_memory_needed/space DATASET ask     what is missing, then the outcomes

DATASET is a folder of `gcm-learn generate data/specs/space.toml`.  Finished parts are kept in
out/space and not repeated.
"""

from __future__ import annotations

import argparse
import json
from itertools import chain
from pathlib import Path

import fronts
from answers import Judged, answered
from report import write_figure
from space_asked import planners, suite
from space_entrants import equal, needed, shipped
from space_lessons import catches_of, names, train_all

from experiments import recompute
from experiments.common import outcomes
from experiments.common.judging import Referee
from gcm_learn import dataset

HERE = Path(__file__).resolve().parent
OUT = HERE / "out" / "space"
FROZEN = HERE / "frozen-space.json"
"""The commit that froze code and generator, the seed that its hash gives, and how many of W and of
Q were asked in the time that there was: of all, and of fronts and fallbacks."""


def main() -> None:
    """Do one of the parts."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("dataset", type=Path)
    parser.add_argument("part", choices=("train", "ask"))
    parser.add_argument("--names", nargs="+", default=names(), help="of some trainings")
    given = parser.parse_args()
    if given.part == "train":
        train_all(given.names, dataset.open(given.dataset), OUT)
    else:
        ask(given.dataset)


def ask(folder: Path) -> None:
    """Ask what was not asked yet; write the outcomes, and what is computed from them."""
    frozen = json.loads(FROZEN.read_text("utf-8"))
    out, referee = OUT / f"fresh-{frozen['seed']}", Referee()
    rows = suite(frozen["seed"], out / "draws", frozen["each"])
    whole = catches_of(dataset.open(folder), OUT / "catches.npz")
    found = [
        answered(out / "answers", "fresh", who, rows, Judged(referee, 1))
        for who in chain(equal(whole, OUT), needed(whole, OUT), shipped(whole, OUT))
    ]
    outcomes.write(HERE / "outcomes-space.csv.gz", chain.from_iterable(found))
    some = [row for n, row in enumerate(rows) if n % frozen["each"] < frozen["fronts"]]
    answers = fronts.parts(some, referee, planners())
    outcomes.write(HERE / "outcomes-fronts-space.csv.gz", answers)
    recompute.update(HERE)
    write_figure(HERE / "figure-space.png", outcomes.read(HERE / "outcomes-space.csv.gz"))


if __name__ == "__main__":
    main()
