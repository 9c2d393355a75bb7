"""Does one search serve all arms? Asks cells, a lattice, trees and memory; writes table.md.

python -m experiments 19_one_search                 asks today's code
python -m experiments 19_one_search --only lattice  asks the search in space of an older commit

The second is run in a working tree of the commit that README.md names, with this folder in it.
Answers of methods that are not asked are kept.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from time import process_time
from typing import Any

from chains import as_chain

from experiments import recompute
from experiments.common import outcomes
from experiments.common.judging import complaints
from gcm_learn import families, seeding
from gcm_learn.cli.progress import Progress
from gcm_learn.dataset import read_spec
from gcm_learn.planners import get_planner

HERE = Path(__file__).resolve().parent
SPECS = {"space": "space", "space, limits of acceleration": "space-accelerated"}
SEED, COUNT = 1900, 300
SOLID = tuple(name for name in families.family_names("planar") if name.endswith("-solid"))
EACH = 25  # situations of each planar family
DEADLINES = {"": None, ", 20 ms": 0.02, ", 100 ms": 0.1}
TREES, LATTICE, CELLS = "trees", "lattice", "cells"


def in_space(kind: str) -> Iterator[tuple[str, Any]]:
    """Yield the draws of a specification: names of families, and situations."""
    spec = read_spec(HERE.parents[1] / "data" / "specs" / f"{SPECS[kind]}.toml")
    for k in range(COUNT):
        source = seeding.rng(SEED, k)
        family = spec.choose(source)
        yield family.family, family.source.draw(source, f"{kind} {k:03d}")


def in_plane() -> Iterator[tuple[str, Any, Any]]:
    """Yield families of planar arms among solids, situations, and these with a chain."""
    for family in SOLID:
        for k in range(EACH):
            situation = families.draw(family, SEED, k)
            yield family, replace(situation, name=f"{family} {k:02d}"), as_chain(situation)


def answers(situation: Any, planner: Any, complain: Any) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield what a planner answers without and with deadlines."""
    for words, deadline in DEADLINES.items():
        before = process_time()
        plan = planner.plan(situation, deadline=deadline)
        ms = 1e3 * (process_time() - before)
        complaints = len(complain(situation, plan)) if plan.caught else 0
        found = {"caught": plan.caught, "catch_time": plan.catch_time, "ms": ms}
        yield words, found | {"complaints": complaints}


def rows_in_space(planners: dict[str, str]) -> Iterator[dict[str, Any]]:
    """Yield the answers of planners in space, by the names of the methods."""
    asked = {method: get_planner(name) for method, name in planners.items()}
    for kind in SPECS:
        drawn = list(in_space(kind))
        for _, situation in drawn[:: COUNT // 12]:  # kernels are loaded
            for planner in asked.values():
                list(answers(situation, planner, complaints))
        with Progress(len(drawn), "situations") as bar:
            for family, situation in drawn:
                about = {"situation": situation.name, "stratum": kind, "family": family}
                for method, planner in asked.items():
                    for words, found in answers(situation, planner, complaints):
                        yield about | found | {"method": method + words}
                bar.advance()


def rows_in_plane() -> Iterator[dict[str, Any]]:
    """Yield the answers of `search` to planar arms and to the same as chains."""
    drawn, planner = list(in_plane()), get_planner("search")
    for _, *pair in drawn[:: 2 * EACH]:
        for situation in pair:
            for deadline in DEADLINES.values():
                planner.plan(situation, deadline=deadline)
    with Progress(len(drawn), "situations") as bar:
        for family, planar, chain in drawn:
            about = {"situation": planar.name, "stratum": "plane", "family": family}
            for words, found in answers(planar, planner, complaints):
                yield about | found | {"method": CELLS + words}
            for words, found in answers(chain, planner, complaints):
                yield about | found | {"method": TREES + words}
            bar.advance()


def main() -> None:
    """Ask, and write what was asked beside what was known."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", choices=[LATTICE], help="ask the older search in space alone")
    given = parser.parse_args()
    file = HERE / "outcomes.csv.gz"
    if given.only is None:
        rows = [*rows_in_space({TREES: "search", "hybrid": "hybrid"}), *rows_in_plane()]
    else:
        rows = list(rows_in_space({LATTICE: "search"}))
    asked = {(row["stratum"], row["method"]) for row in rows}
    if file.exists():
        kept = outcomes.read(file)
        names = list(kept.columns)
        for values in zip(*(kept[name].tolist() for name in names), strict=True):
            row = dict(zip(names, values, strict=True))
            if (row["stratum"], row["method"]) not in asked:
                rows.append(row)
    outcomes.write(file, rows)
    recompute.update(HERE)


if __name__ == "__main__":
    main()
