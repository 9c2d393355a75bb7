"""Which planner catches what in space, at what cost, and what a plane misses; writes table.md.

python -m experiments 13_space               13 situations of each family: half an hour
python -m experiments 13_space --count 2     a quick look
python -m experiments 13_space --minutes 10  what can be done in ten minutes

Finished parts are kept in out/ and not repeated; Ctrl-C is safe.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np
from report import HELD, YARDSTICK

from experiments import recompute
from experiments.common import outcomes
from experiments.common.judging import complaints
from gcm_learn import seeding
from gcm_learn.arms import SPATIAL, SpatialArm
from gcm_learn.families import draw, family_names
from gcm_learn.planners import (
    STRRTStarPlanner,
    get_planner,
    planner_names,
    takes,
    yardstick,
)
from gcm_learn.situation import Body, Situation, SolidQuadratic, Sphere
from gcm_learn.storage import write_whole

HERE = Path(__file__).resolve().parent
SEED = 1300
COUNT = 13  # situations of each family
TREES = "st-rrt-star"
PASSED_OVER = ("oracle", "layered", TREES)  # `layered` is `search` here
THOUGHT = 0.1  # deadline of the search that looks for an earlier catch [s]
BUDGETS_MS = (100.0, 1000.0)  # of ST-RRT*
TREES_MS = 10_000.0  # of the yardstick's
BYSTANDERS = (0, 8, 32)  # bodies that are added
COSTLY = 3  # of the situations of each family, the first for which cost is measured

Spatial = Situation[SpatialArm]


def families() -> list[str]:
    """Names of the families with a spatial arm."""
    return family_names("spatial")


def drawn(family: str, index: int) -> Spatial:
    """A situation without limits of acceleration, which only `search` and `marching` keep."""
    situation: Any = draw(family, SEED, index)
    return replace(
        situation,
        arm=replace(situation.arm, max_joint_acceleration=None, joint_rates=None),
    )


def held(situation: Spatial) -> Spatial:
    """The same scene with shoulder pitch and elbow yaw held: what is left moves in a plane.

    The hand's surface is a cone or a torus instead if the yaw is not 0 at the start. It has two
    dimensions all the same.
    """
    arm = situation.arm
    ranges = list(arm.joint_range)
    for j in (0, 2):
        ranges[j] = (arm.joints[j], arm.joints[j])
    return replace(situation, arm=replace(arm, joint_range=tuple(ranges)))


def crowded(situation: Spatial, count: int) -> Spatial:
    """The same with small balls that drift about 1 to 2.5 reaches away from the shoulder."""
    arm, rng = situation.arm, seeding.rng(SEED, count)
    bodies = list(situation.bodies)
    for k in range(count):
        away = rng.normal(size=3)
        place = arm.base.origin + away / np.linalg.norm(away) * arm.reach * rng.uniform(1.0, 2.5)
        drift = rng.normal(size=3) * 0.2 * arm.reach
        flight = SolidQuadratic(tuple(place), tuple(drift), (0.0, 0.0, 0.0))
        bodies.append(Body("obstacle", f"bystander {k}", Sphere(0.03 * arm.reach), flight))
    return replace(situation, bodies=tuple(bodies))


def judged(situation: Spatial, plan: Any, ms: float) -> list[Any]:
    """Catch time [s] or null, time for planning [ms], and what the referee complains of."""
    if not plan.caught:
        return [None, ms, []]
    return [plan.catch_time, ms, complaints(situation, plan)]


def timed(situation: Spatial, planner: Any, **limits: float) -> list[Any]:
    """The same for a planner, by processor time."""
    before = process_time()
    plan = planner.plan(situation, **limits)
    return judged(situation, plan, 1e3 * (process_time() - before))


def answered(situation: Spatial, before: dict[str, list[Any]]) -> dict[str, list[Any]]:
    """Return the answer of every planner that has not answered before."""
    out = dict(before)
    taking = [get_planner(name) for name in planner_names() if name not in PASSED_OVER]
    asked = {p.name: p for p in taking if takes(p, SPATIAL)}
    for name, planner in asked.items():
        if name not in out:
            out[name] = timed(situation, planner)
    longer = f"search, {1e3 * THOUGHT:.0f} ms"
    if longer not in out:
        out[longer] = timed(situation, get_planner("search"), deadline=THOUGHT)
    names = [f"{TREES} {budget:.0f} ms" for budget in BUDGETS_MS]
    if names[0] not in out:
        plans = STRRTStarPlanner().plan_anytime(situation, BUDGETS_MS)
        for name, plan in zip(names, plans, strict=True):
            out[name] = judged(situation, plan, plan.planning_ms)
    return out


def costs(situation: Spatial) -> dict[str, list[Any]]:
    """Return the answers of `search` among more bodies."""
    search = get_planner("search")
    return {f"bystanders +{k:02d}": timed(crowded(situation, k), search) for k in BYSTANDERS}


def measured(family: str, index: int) -> dict[str, Any]:
    """Everything about one situation."""
    situation = drawn(family, index)
    known = yardstick(situation, TREES_MS, earliest=False)
    plane = held(situation)
    return {
        "family": family,
        "index": index,
        "stratum": known.stratum,
        "lower": None if np.isinf(known.lower) else known.lower,
        "yardstick": {name: plan.catch_time for name, plan in known.plans.items()},
        "answers": answered(situation, {}),
        "plane, yardstick": yardstick(plane, BUDGETS_MS[-1], earliest=False).stratum,
        "costs": costs(situation) if index < COSTLY else {},
    }


def lines_of(row: dict[str, Any]) -> Iterator[dict[str, Any]]:
    """Yield the outcomes of a situation; `lower` is before which nobody catches [s]."""
    about = {
        "situation": f"{row['family']}-{row['index']:02d}",
        "stratum": row["stratum"],
        "family": row["family"],
        "lower": row["lower"],
    }
    times = [time for time in row["yardstick"].values() if time is not None]
    caught = row["stratum"] != "U"
    yield about | {"method": YARDSTICK, "caught": caught, "catch_time": min(times, default=None)}
    yield about | {"method": HELD, "caught": row["plane, yardstick"] != "U"}
    for name, (time, ms, found) in (row["answers"] | row["costs"]).items():
        told = {"caught": time is not None, "catch_time": time, "ms": ms}
        yield about | {"method": name, "complaints": len(found)} | told


def main() -> None:
    """Run what is missing; write the outcomes, and the tables from them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=COUNT, help="situations of each family")
    parser.add_argument("--minutes", type=float, default=np.inf, help="no new one after that")
    arguments = parser.parse_args()
    file, started = HERE / "out" / "answers.jsonl", perf_counter()
    file.parent.mkdir(exist_ok=True)
    lines = file.read_text().splitlines() if file.exists() else []
    rows = [json.loads(line) for line in lines]
    done = {(row["family"], row["index"]) for row in rows}
    _warm_up()
    for row in rows:  # planners may have come since
        row["answers"] = answered(drawn(row["family"], row["index"]), row["answers"])
    write_whole(file, "".join(json.dumps(row) + "\n" for row in rows))
    with file.open("a") as stream:
        for index, family in ((k, f) for k in range(arguments.count) for f in families()):
            if (family, index) in done or perf_counter() - started > 60.0 * arguments.minutes:
                continue
            rows.append(measured(family, index))
            stream.write(json.dumps(rows[-1]) + "\n")
            stream.flush()
    outcomes.write(HERE / "outcomes.csv.gz", (line for row in rows for line in lines_of(row)))
    recompute.update(HERE)


def _warm_up() -> None:
    """Load all kernels, so that nobody is charged for that."""
    situation = drawn(families()[0], 10_000)
    work: list[Callable[[], object]] = [lambda: answered(situation, {}), lambda: costs(situation)]
    for each in work:
        each()


if __name__ == "__main__":
    main()
