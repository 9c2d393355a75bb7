"""Is what was called caught ever not? Random situations, planned for, judged by the referee.

    python -m experiments benchmarks/promise plane --count 3000
    python -m experiments benchmarks/promise space --planner search straight
    python -m experiments benchmarks/promise space --acceleration

COUNT situations of each family of a kind of arm. Answers are kept in out/; the same command goes on
after Ctrl-C. Claims that are broken are printed with what draws them again. Exit code 1 if any is.
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from gcm_learn import families, rng
from gcm_learn.evaluation import Case, ask

OUT = Path(__file__).parent / "out"
KINDS = {"plane": "planar", "space": "spatial", "chains": "chain"}
"""Kinds of arms by the words of the command line."""


def forced(situation: Any, seed: int, index: int) -> Any:
    """Return a situation whose joints need a while to their top speeds, and may move already."""
    r, arm = rng(seed, index, 1), situation.arm
    speeds = np.array(arm.max_joint_speed)
    limits = tuple(speeds / r.uniform(0.05, 0.3))
    rates = tuple(0.5 * speeds * r.uniform(-1.0, 1.0, len(speeds))) if r.random() < 0.5 else None
    return replace(situation, arm=replace(arm, max_joint_acceleration=limits, joint_rates=rates))


def main() -> int:
    """Ask, and say whether anything is broken."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("arm", choices=list(KINDS))
    parser.add_argument("--count", type=int, default=50, help="situations of each family")
    parser.add_argument("--planner", nargs="+", default=["search"])
    parser.add_argument("--acceleration", action="store_true", help="limit it, but in the plane")
    parser.add_argument("--seed", type=int, default=14)
    given, found = parser.parse_args(), []
    for name in families.family_names(KINDS[given.arm]):
        for index in range(given.count):
            drawn: Any = families.draw(name, given.seed, index)
            made = forced(drawn, given.seed, index) if given.acceleration else drawn
            found.append(Case(made, name, name))
    sheet = ask(given.planner, found, keep=OUT / f"promise-{given.arm}")
    wrong = sheet.where(outcome="broken")
    for row in zip(*(wrong[name] for name in ("entrant", "name", "reason")), strict=True):
        print("broken by {}: {} of seed {}: {}".format(*row[:2], given.seed, row[2]))
    print(f"{sheet.caught.sum() + len(wrong)} claims, {len(wrong)} broken")
    return 1 if len(wrong) else 0


if __name__ == "__main__":
    sys.exit(main())
