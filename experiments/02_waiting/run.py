"""Which planner catches what: the same situations of every stratum for all; writes outcomes.

python -m experiments 02_waiting                     draw, plan, judge: an hour
python -m experiments 02_waiting --per-stratum 50    a quick look, minutes

Finished parts are kept in out/ and not repeated; Ctrl-C is safe.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from answers import answers_of
from report import write_figure

from experiments import recompute
from experiments.common import outcomes
from experiments.common.suite import make

HERE = Path(__file__).resolve().parent
OUTCOMES = HERE / "outcomes.csv.gz"


def main() -> None:
    """Run what is missing; write the outcomes, and table and figure from them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--per-stratum", type=int, help="situations of each stratum")
    parser.add_argument("--workers", type=int, default=2)
    arguments = parser.parse_args()
    config = json.loads((HERE / "config.json").read_text())
    if arguments.per_stratum is not None:
        config["per_stratum"] = arguments.per_stratum
    out = HERE / "out" / str(config["per_stratum"])
    cases, _ = make(config, out / "draws", arguments.workers)
    outcomes.write(OUTCOMES, answers_of(config, cases, out / "answers", arguments.workers))
    recompute.update(HERE)
    write_figure(HERE / "figure.png", outcomes.read(OUTCOMES))


if __name__ == "__main__":
    main()
