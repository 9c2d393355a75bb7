"""Ask if memory is worth most where planning is dear: W and Q in space, thinking charged.

python -m experiments 15_anytime choose            who is the fastest without memory
python -m experiments 15_anytime choose --limits   likewise, acceleration limited
python -m experiments 15_anytime run --seed 7      free joints: a suite of this seed
python -m experiments 15_anytime run --seed 7 --limits   joints with limited acceleration
python -m experiments 15_anytime report            dear.json, dear.png

`--minutes 9` begins no new situation after that; what is done is kept in out/ and not done again.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from time import monotonic, process_time
from typing import Any, NamedTuple

import numpy as np

from experiments.common.charging import after
from experiments.common.judging import complaints, first_answer
from experiments.common.memories import random_by_family
from gcm_learn.dataset import make_item, read_spec
from gcm_learn.planners import (
    GAIN,
    SpatialProblem,
    STRRTStarPlanner,
    TreeSearch,
    any_straight,
    get_planner,
    search_in_space,
)
from gcm_learn.recall import HybridPlanner, RecallPlanner
from gcm_learn.storage import write_whole

HERE = Path(__file__).resolve().parent
REPOSITORY = HERE.parents[1]
OUT = HERE / "out"
CHOICE = HERE / "dear-choice.json"
SPECS = {"free": "space", "limits": "space-accelerated"}
AS_TRAINED = ("train", "validation", "test")  # splits: whatever a seed draws, no memory has seen
VALIDATION, EACH = 1515, 60  # seed and situations of W by which the control is chosen
WARM = 3  # situations that are asked about first and not counted
LIMIT = 1.0  # processor time after which there is no answer [s]
SHORT = 0.02  # one period of perception [s]
NEAR, ENOUGH = 0.1, 0.05  # of the horizon: well caught; so near that nothing better is looked for
CURVE = (1.0, 2.0, 5.0, 10.0, 50.0, 100.0, 200.0)  # budgets beside the two [ms]
CURVED = 120  # situations of each kind of joints for which they are asked
INSTANTS = 96  # at which straight movements are looked for, as by the yardstick
TREES_MS = (5.0, 10.0, 20.0, 50.0, 100.0)


class Case(NamedTuple):
    """A situation of W or Q."""

    item: int
    family: str
    stratum: str
    situation: Any


def drawn(kind: str, seed: int, strata: str = "WQ") -> Iterator[Case]:
    """Situations as the specification draws them, sorted by `search`, without end."""
    spec = read_spec(REPOSITORY / "data" / "specs" / f"{SPECS[kind]}.toml")
    spec = replace(spec, seed=seed, audit=0.0, count=10**6)
    for k in range(spec.count):
        record = make_item(spec, k)
        if record.situation is None or record.split not in AS_TRAINED:
            continue
        if record.stratum in strata and not _straight(kind, record.situation):
            yield Case(k, record.family, record.stratum, record.situation)


def _straight(kind: str, situation: Any) -> bool:
    """Return whether a straight movement catches after all."""
    if kind == "limits":
        return False
    return any_straight(SpatialProblem(situation, "straight"), instants=INSTANTS).caught


@cache
def configurations() -> dict[str, Any]:
    """All that plan without memory."""
    return {
        "search": get_planner("search"),
        "search, first catch": TreeSearch(),
        "search, less patient": search_in_space(effort=0.25),
        "marching": get_planner("marching"),
        "straight-wait": get_planner("straight-wait"),
    }


def trees(situation: Any) -> float:
    """When ST-RRT* has a catch [s], the limit if it has none by the largest of its budgets."""
    plans = STRRTStarPlanner().plan_anytime(situation, TREES_MS)
    return min((1e-3 * plan.planning_ms for plan in plans if plan.caught), default=LIMIT)


def choose(kind: str, minutes: float) -> None:
    """Ask all configurations on validation draws; the fastest on W is the control."""
    path, started = OUT / f"dear-choice-{kind}.jsonl", monotonic()
    OUT.mkdir(exist_ok=True)
    lines = path.read_text("utf-8").splitlines() if path.exists() else []
    rows = [json.loads(line) for line in lines]
    with path.open("a", encoding="utf-8") as stream:
        for number, case in enumerate(drawn(kind, VALIDATION, "W")):
            if number == EACH + WARM or monotonic() - started > 60.0 * minutes:
                break
            if WARM <= number < WARM + len(rows):
                continue
            mine = {
                name: first(planner, case.situation)
                for name, planner in configurations().items()
                if kind == "free" or name.startswith("search")  # keep limits of acceleration
            }
            if kind == "free":
                mine["st-rrt-star"] = trees(case.situation)
            if number >= WARM:  # kernels are loaded now
                rows.append(mine)
                stream.write(json.dumps(mine) + "\n")
                stream.flush()
    times = {name: np.array([row[name] for row in rows]) for name in rows[0]}
    median = {name: 1e3 * float(np.median(took)) for name, took in times.items()}
    control = min(median, key=lambda name: median[name])
    made = json.loads(CHOICE.read_text("utf-8")) if CHOICE.exists() else {}
    made[kind] = {
        "control": control,
        "budget ms": round(0.5 * median[control], 2),
        "situations": len(rows),
        "median ms": {name: round(ms, 2) for name, ms in median.items()},
        "90 % ms": {name: round(1e3 * np.quantile(t, 0.9), 2) for name, t in times.items()},
        "caught": {name: float(np.mean(took < LIMIT)) for name, took in times.items()},
    }
    write_whole(CHOICE, json.dumps(made, indent=1) + "\n")


def first(planner: Any, situation: Any) -> float:
    """Processor time until a first catch [s], at most the limit."""
    since = process_time()
    plan = planner.plan(situation)
    took = process_time() - since
    return min(took, LIMIT) if plan.caught else LIMIT


class Arms:
    """Planners that are compared, by the family of the situation: only memory differs.

    All plan as the control does where nothing is recalled.
    """

    def __init__(self, kind: str) -> None:
        self.control = configurations()[json.loads(CHOICE.read_text("utf-8"))[kind]["control"]]
        hybrid: Any = get_planner("hybrid")
        own = hybrid.recall.other()  # for arms in space
        self.hybrid = HybridPlanner(replace(own, name="hybrid"), fallback=self.control)
        self.random = random_by_family(own.memory)

    def of(self, family: str) -> dict[str, Any]:
        """Planners by name."""
        chance = RecallPlanner(self.random.get(family, self.random[""]), name="hybrid-random")
        return {
            "control": self.control,
            "hybrid": self.hybrid,
            "hybrid-random": HybridPlanner(chance, fallback=self.control),
        }


def charged(case: Case, arms: dict[str, Any], budget: float) -> dict[str, Any] | str:
    """Answers if the world goes on for a budget [s] while one thinks, or the fate of all."""
    moved = after(case.situation, budget)
    if isinstance(moved, str):
        return moved
    return {name: first_answer(planner, moved) for name, planner in arms.items()}


def improved(planner: Any, control: Any, situation: Any, enough: float) -> list[list[float]]:
    """Catches [s] and when they were known [ms], until one comes by `enough` [s] or none is found.

    After the first answer the control is asked again, under the bound of what there is. A catch
    that the referee complains of is left out.
    """
    known, took, bound = [], 0.0, None
    while True:
        since = process_time()
        plan = planner.plan(situation) if bound is None else control.plan(situation, bound=bound)
        took += process_time() - since
        if plan.catch_time is None or took > LIMIT:
            return known
        if not complaints(situation, plan):
            known.append([plan.catch_time, round(1e3 * took, 3)])
        bound = plan.catch_time - GAIN * situation.horizon
        if plan.catch_time <= enough or bound <= 0.0:
            return known


def answered(kind: str, case: Case, arms: Arms, more: bool) -> dict[str, Any]:
    """Return the answers of all arms to a situation."""
    mine, situation = arms.of(case.family), case.situation
    row: dict[str, Any] = {
        "item": case.item, "family": case.family, "stratum": case.stratum,
        "horizon": situation.horizon,
    }  # fmt: skip
    own = json.loads(CHOICE.read_text("utf-8"))[kind]["budget ms"]
    budgets = {"half": 1e-3 * own, "short": SHORT}
    row["charged"] = {name: charged(case, mine, budget) for name, budget in budgets.items()}
    if more:
        row["curve"] = {f"{ms:g}": charged(case, mine, 1e-3 * ms) for ms in CURVE}
    best = get_planner("search").plan(situation, deadline=LIMIT).catch_time
    row["reference"] = best
    enough = -np.inf if best is None else best + ENOUGH * situation.horizon
    row["improved"] = {
        name: improved(planner, arms.control, situation, enough) for name, planner in mine.items()
    }
    return row


def balanced(kind: str, seed: int, count: int) -> Iterator[Case]:
    """The first W and the first Q of a suite, `count` of each, as they come."""
    left = dict.fromkeys("WQ", count)
    for case in drawn(kind, seed):
        if left[case.stratum] > 0:
            left[case.stratum] -= 1
            yield case
        if not any(left.values()):
            return


def run(kind: str, seed: int, count: int, minutes: float) -> None:
    """Answer what is missing of a suite."""
    path, started = OUT / f"dear-{kind}-{seed}.jsonl", monotonic()
    OUT.mkdir(exist_ok=True)
    lines = path.read_text("utf-8").splitlines() if path.exists() else []
    known = {json.loads(line)["item"] for line in lines}
    arms = Arms(kind)
    for _, case in zip(range(WARM), drawn(kind, VALIDATION), strict=False):
        answered(kind, case, arms, True)  # kernels are loaded now
    with path.open("a", encoding="utf-8") as stream:
        for number, case in enumerate(balanced(kind, seed, count)):
            if monotonic() - started > 60.0 * minutes:
                break
            if case.item not in known:
                row = answered(kind, case, arms, number < CURVED)
                stream.write(json.dumps(row) + "\n")
                stream.flush()


def main() -> None:
    """Choose, run or report."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("what", choices=("choose", "run", "report"))
    parser.add_argument("--seed", type=int, default=VALIDATION + 1)
    parser.add_argument("--limits", action="store_true", help="of acceleration")
    parser.add_argument("--count", type=int, default=300, help="of W, and of Q")
    parser.add_argument("--minutes", type=float, default=np.inf, help="no new one after that")
    given = parser.parse_args()
    kind = "limits" if given.limits else "free"
    if given.what == "choose":
        choose(kind, given.minutes)
    elif given.what == "run":
        run(kind, given.seed, given.count, given.minutes)
    else:
        from report import report

        report(OUT, given.seed, json.loads(CHOICE.read_text("utf-8")))


if __name__ == "__main__":
    main()
