"""Is a memory needed, and what is it worth with the same experience? Writes the tables and figure.

python -m experiments 17_is_memory_needed DATASET train     the encoders, one after the other
python -m experiments 17_is_memory_needed DATASET ask       what is missing, then the tables

DATASET is a folder of `gcm-learn generate data/specs/recall.toml`, with a `count` of 40,000: its
first 15,000 records hold enough for all but 30,000 catches.  Finished parts are kept in out/ and
not repeated.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import report
from answers import answered
from entrants import equal, longer, needed, opened, resting, shipped
from lessons import at_rest
from questions import SPLITS, development, outside
from trainings import train, train_all

from experiments.common.judging import Referee
from experiments.common.questions import Question, asked, suite
from gcm_learn.dataset import Dataset
from gcm_learn.errors import EncoderError
from gcm_learn.planners import get_planner

HERE = Path(__file__).resolve().parent
OUT = HERE / "out"
FROZEN = HERE / "frozen.json"
"""The commit that froze code and generator, and the seed that its hash gives."""
FROZEN_LONGER = HERE / "frozen-longer.json"
"""The same of the suite of encoders that learned longer: these were added once answers of the first
suite were known."""


def main() -> None:
    """Do one of the parts."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("dataset", type=Path)
    parser.add_argument("part", choices=("train", "ask"))
    parser.add_argument("--name", help="of one training")
    parser.add_argument("--only", nargs="+", choices=PARTS, default=list(PARTS))
    parser.add_argument("--development", type=Path, help="suites W and Q that are asked instead")
    parser.add_argument("--count", type=int, default=400, help="of each, of these")
    given = parser.parse_args()
    if given.part == "train" and given.name:
        train(given.name, given.dataset, OUT)
    elif given.part == "train":
        train_all(given.dataset, OUT)
    else:
        ask(given)


PARTS = ("equal", "needed", "shipped", "resting", "outside", "longer", "report")


def ask(given: argparse.Namespace) -> None:
    """Ask what was not asked yet, and write the tables of what there is."""
    if given.development:
        out, whole = OUT / "development", development(given.development, given.count)
    else:
        out, whole = _fresh(FROZEN)
    records, referee, rows = opened(given.dataset), Referee(), asked(whole)
    for name, part in {"equal": equal, "needed": needed, "shipped": shipped}.items():
        if name in given.only:
            for who, make in part(records, OUT):
                _answered(out / "answers" / f"{who}.json", make, rows, referee)
    if "resting" in given.only:
        for group, some in waitless(whole).items():
            for who, make in resting(records, OUT):
                _answered(out / group / f"{who}.json", make, some, referee)
    if "outside" in given.only:
        _ask_outside(records, referee)
    if "longer" in given.only:
        later, more = _fresh(FROZEN_LONGER)
        for who, make in longer(records, OUT):
            _answered(later / "answers" / f"{who}.json", make, asked(more), referee)
    if "report" in given.only:
        report.write(HERE, OUT, out, rows, _fresh(FROZEN_LONGER)[0])


def _fresh(frozen: Path) -> tuple[Path, list[Question]]:
    """Folder of the answers of a suite, and the suite."""
    seed = json.loads(frozen.read_text("utf-8"))["seed"]
    out = OUT / f"fresh-{seed}"
    return out, suite(seed, out / "draws")


def _ask_outside(records: Dataset, referee: Referee) -> None:
    """The shipped memory and its controls, of what training leaves out."""
    for split in SPLITS:
        some = outside(split, records.spec, OUT / "outside")
        for who, make in shipped(records, OUT):
            if who != "shipped-family-stratum":
                _answered(OUT / "outside" / split / f"{who}.json", make, some, referee)


def _answered(file: Path, make: Any, rows: list[Question], referee: Referee) -> None:
    """Ask one of them, unless it has been asked, or is not trained yet."""
    if file.exists():
        return
    try:
        who = make()
    except (EncoderError, FileNotFoundError) as error:
        print(f"{file.stem}: not asked ({error})", flush=True)
        return
    answered(file, who, rows, referee)


def waitless(whole: list[Question]) -> dict[str, list[Question]]:
    """W in which something moves, and whatever needs a detour once nothing does."""
    groups: dict[str, list[Question]] = {"W": [], "at rest": []}
    for question in whole:
        still = at_rest(question.situation)
        if still is None or still == question.situation:
            continue
        if question.stratum == "W":
            groups["W"].append(question)
        detour = not get_planner("straight").plan(still).caught
        if detour and get_planner("layered").plan(still).caught:
            groups["at rest"].append(question._replace(situation=still))
    return groups


if __name__ == "__main__":
    main()
