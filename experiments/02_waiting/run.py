"""Which planner catches what: the same situations of every stratum for all; writes table.md.

python experiments/02_waiting/run.py                     draw, plan, judge: hours on two cores
python experiments/02_waiting/run.py --per-stratum 50    a quick look, minutes

What is done is kept in out/ and not done again; Ctrl-C is safe.
"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1])]

from answers import answers_of  # noqa: E402
from report import write_figure, write_table  # noqa: E402
from suite import make  # noqa: E402


def main() -> None:
    """Run what is missing and write table.md and figure.png."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--per-stratum", type=int, help="situations of each stratum")
    parser.add_argument("--workers", type=int, default=2)
    arguments = parser.parse_args()
    config = json.loads((HERE / "config.json").read_text())
    if arguments.per_stratum is not None:
        config["per_stratum"] = arguments.per_stratum
    out = HERE / "out" / str(config["per_stratum"])
    cases, seen = make(config, out / "draws", arguments.workers)
    answers = answers_of(config, cases, out / "answers", arguments.workers)
    write_table(HERE / "table.md", config, cases, seen, answers)
    write_figure(HERE / "figure.png", cases, answers)


if __name__ == "__main__":
    main()
