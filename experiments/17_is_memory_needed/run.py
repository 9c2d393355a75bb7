"""Is a memory needed, and what is it worth with the same experience? Writes the tables and figure.

python experiments/17_is_memory_needed/run.py DATASET train     the encoders, one after the other
python experiments/17_is_memory_needed/run.py DATASET ask       what is missing, then the tables

DATASET is a folder of `gcm-learn generate data/specs/recall.toml`.  What is done is kept in out/
and not done again.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "02_waiting"), str(HERE.parents[1])]

OUT = HERE / "out"


def main() -> None:
    """Do one of the parts."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("dataset", type=Path)
    parser.add_argument("part", choices=("train", "ask"))
    parser.add_argument("--name", help="of one training")
    given = parser.parse_args()
    if given.part == "train":
        from trainings import train, train_all

        if given.name:
            train(given.name, given.dataset, OUT)
        else:
            train_all(given.dataset, OUT)


if __name__ == "__main__":
    main()
