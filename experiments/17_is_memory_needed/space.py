"""Is a memory needed in space, and what is it worth with the same experience?

python -m experiments 17_is_memory_needed/space DATASET train   the encoders, one after the other
python -m experiments 17_is_memory_needed/space DATASET ask     what is missing, then the tables

DATASET is a folder of `gcm-learn generate data/specs/space.toml`.  Finished parts are kept in
out/space and not repeated.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import fronts
import report
from run import _answered
from space_asked import RefereeInSpace, planners, suite
from space_entrants import equal, needed, shipped
from space_lessons import catches_of, names, train_all

from experiments import recompute
from experiments.common import outcomes
from gcm_learn import dataset

HERE = Path(__file__).resolve().parent
OUT = HERE / "out" / "space"
FROZEN = HERE / "frozen-space.json"
"""The commit that froze code and generator, the seed that its hash gives, and how many of W and of
Q were asked in the time that there was: of all, and of fronts and fallbacks."""
PARTS = {"equal": equal, "needed": needed, "shipped": shipped}


def main() -> None:
    """Do one of the parts."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("dataset", type=Path)
    parser.add_argument("part", choices=("train", "ask"))
    parser.add_argument("--names", nargs="+", default=names(), help="of some trainings")
    parser.add_argument("--only", nargs="+", default=[*PARTS, "fronts", "report"])
    given = parser.parse_args()
    if given.part == "train":
        train_all(given.names, dataset.open(given.dataset), OUT)
    else:
        ask(given.dataset, given.only)


def ask(folder: Path, only: list[str]) -> None:
    """Ask what was not asked yet, and write the tables of what there is."""
    frozen = json.loads(FROZEN.read_text("utf-8"))
    out, referee = OUT / f"fresh-{frozen['seed']}", RefereeInSpace()
    rows = suite(frozen["seed"], out / "draws", frozen["each"])
    whole = catches_of(dataset.open(folder), OUT / "catches.npz")
    for name, part in PARTS.items():
        if name in only:
            for who, make in part(whole, OUT):
                _answered(out / "answers" / f"{who}.json", make, rows, referee)
    if "fronts" in only:
        numbers = [n for n in range(len(rows)) if n % frozen["each"] < frozen["fronts"]]
        some = [rows[n] for n in numbers]
        answers = fronts.parts(some, referee, planners())
        outcomes.write(HERE / "outcomes-fronts-space.csv.gz", answers)
        recompute.update(HERE)
    if "report" in only:
        report.write_space(HERE, out, rows)


if __name__ == "__main__":
    main()
