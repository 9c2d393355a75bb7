"""Ask recall and its controls of arms in joints, also off their training; writes outcomes.

python -m experiments 05_recall/space                                         2,000 situations
python -m experiments 05_recall/space --spec space-accelerated --count 1000   under limits
python -m experiments 05_recall/space --spec recall-panda --count 600         a Panda

Situations are drawn as a specification of data/specs says, with a seed of their own. Answers
are kept in out/ and not asked again. The tests' referee judges every catch.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from entrants import entrants

from experiments import recompute
from experiments.common import outcomes
from experiments.common.judging import Referee, outcome
from gcm_learn.arms import CHAIN
from gcm_learn.dataset import make_item, read_spec
from gcm_learn.planners import get_planner
from gcm_learn.recall import RandomIndex, RawIndex, shipped_memory

HERE = Path(__file__).resolve().parent
SEEDS = {"space": 3437426931, "space-accelerated": 885590443, "recall-panda": 240_101}
"""By specification. In space they are heads of the hashes of the commits that froze code, memory
and encoder; that of the Panda was written down before its memory was trained."""
WARM = 8  # further situations, asked before the clock runs
SHIPPED = ("recall", "recall-1", "recall-raw", "recall-random", "hybrid", "layered")


def shipped() -> dict[str, Any]:
    """Return planners by their names."""
    return {name: get_planner("search" if name == "layered" else name) for name in SHIPPED}


def of_panda() -> dict[str, Any]:
    """Return the Panda's memory by its own index and by others."""
    memory = shipped_memory("recall", CHAIN)
    situations = memory.situations()
    indexes: dict[str, Any] = {
        "recall-raw": RawIndex.fit(situations),
        "recall-random": RandomIndex(),
    }
    return entrants(memory, indexes)


def caught(planner: Any, situation: Any, _referee: Referee) -> dict[str, Any]:
    """Return the outcome of a planner, without counts of memories and the referee."""
    since = time.process_time()
    plan = planner.plan(situation)
    took = 1e3 * (time.process_time() - since)
    return {"caught": plan.caught, "catch_time": plan.catch_time, "ms": took}


METHODS = {
    "space": (shipped, outcome),
    "space-accelerated": (shipped, outcome),
    "recall-panda": (of_panda, caught),
}


def answered(
    spec: Any, k: int, methods: Mapping[str, Any], ask: Callable[..., dict[str, Any]]
) -> list[dict[str, Any]]:
    """Return the outcomes of item k; of one that no planner of records catches that is all."""
    record = make_item(spec, k)
    if record.situation is None:
        return []
    about = {
        "situation": k,
        "split": record.split,
        "stratum": record.stratum,
        "family": record.family,
    }
    if record.stratum == "U":
        return [about | {"method": spec.planners[-1], "caught": False}]
    return [
        about | {"method": name} | ask(planner, record.situation, Referee())
        for name, planner in methods.items()
    ]


def main() -> None:
    """Ask what was not asked yet; write the outcomes, and the table from them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--spec", default="space", choices=SEEDS, help="of data/specs")
    parser.add_argument("--count", type=int, default=2000, help="situations")
    parser.add_argument("--minutes", type=float, default=np.inf, help="no new one after that")
    given, began = parser.parse_args(), time.monotonic()
    file = HERE.parents[1] / "data" / "specs" / f"{given.spec}.toml"
    spec = replace(read_spec(file), seed=SEEDS[given.spec], count=given.count, audit=0.0)
    kept = HERE / "out" / f"{given.spec}-{spec.seed}.jsonl"
    kept.parent.mkdir(exist_ok=True)
    lines = kept.read_text("utf-8").splitlines() if kept.exists() else []
    rows = [json.loads(line) for line in lines]
    make, ask = METHODS[given.spec]
    methods = make()
    for k in range(given.count, given.count + WARM):
        answered(replace(spec, count=given.count + WARM), k, methods, ask)  # kernels are loaded now
    with kept.open("a", encoding="utf-8") as stream:
        for k in range(len(rows), given.count):
            if time.monotonic() - began > 60.0 * given.minutes:
                break
            rows.append(answered(spec, k, methods, ask))
            stream.write(json.dumps(rows[-1]) + "\n")
            stream.flush()
    outcomes.write(HERE / f"outcomes-{given.spec}.csv.gz", (one for row in rows for one in row))
    recompute.update(HERE)


if __name__ == "__main__":
    main()
