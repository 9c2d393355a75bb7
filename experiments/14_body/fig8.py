"""The paper's pendulum experiment with NAO's arm in physics, varied; writes fig8.json.

python -m experiments 14_body/fig8               1,000 variations: ten minutes on one core
python -m experiments 14_body/fig8 --count 10    a quick look
python -m experiments 14_body/fig8 --minutes 9   what can be done in nine minutes

What is done is kept in out/ and not done again; Ctrl-C is safe.
"""

from __future__ import annotations

import argparse
import json
import math
from collections import Counter
from dataclasses import replace
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np

from gcm_learn import seeding
from gcm_learn.arms import SpatialArm, forward_in_space
from gcm_learn.execution import (
    Controller,
    Execution,
    body_for,
    execute,
    execution_to_json,
    with_motor_limits,
)
from gcm_learn.families import paper_scene
from gcm_learn.motion import start_clearance
from gcm_learn.planners import InTube, Tube, get_planner
from gcm_learn.scene import pack, pose
from gcm_learn.situation import Capsule, Situation
from gcm_learn.storage import write_whole

HERE = Path(__file__).resolve().parent
SEED = 1408
COUNT = 1000
RELEASE = (20.0, 40.0)  # [degrees] the paper's scene has 30
CORD = (1.00, 1.15)  # [m] 1.10
BOX = ((-0.03, 0.05), (-0.10, 0.10))  # [m] ahead and aside, from 0.10 m before the shoulder
START = 0.2  # [rad] of every joint, to either side
STEP = 0.002  # [s] of the physics
CLEAR = 1e-3  # [m] clearance of plans that do not pass close by
NEAR, SOON = 0.02, 0.005  # [m, s] what Rollin' Justin needs
ANSWERS, RESULTS = HERE / "out" / "fig8.jsonl", HERE / "fig8.json"

Spatial = Situation[SpatialArm]


def varied(index: int) -> Spatial:
    """A variation of the scene in which the arm touches nothing at the start."""
    scene: Any = paper_scene("fig8-space")
    ball, cord, box = scene.bodies
    for again in range(100):
        rng = seeding.rng(SEED, index, again)
        angle, length = -math.radians(rng.uniform(*RELEASE)), rng.uniform(*CORD)
        swing = replace(ball.motion, angle=angle, length=length, hang=length)
        free = 0.5 * (length - ball.shape.radius)
        ahead, aside = (rng.uniform(*span) for span in BOX)
        x, y, z = box.motion.position
        low, high = np.array(scene.arm.joint_range).T
        joints = np.clip(scene.arm.joints + rng.uniform(-START, START, 4), low, high)
        out = replace(
            scene,
            name=f"fig8-space {index}",
            arm=replace(scene.arm, joints=tuple(joints.tolist())),
            bodies=(
                replace(ball, motion=swing),
                replace(
                    cord,
                    shape=Capsule(cord.shape.radius, free),
                    motion=replace(swing, hang=free),
                ),
                replace(box, motion=replace(box.motion, position=(x + ahead, y + aside, z))),
            ),
        )
        if start_clearance(pack(out)) > 0.0:
            return out
    raise RuntimeError(f"variation {index}: the arm touches something wherever it starts")


def told(done: Execution, plan: Any) -> dict[str, Any]:
    """The report, with how far hand and catch were from the plan.

    ``late`` counts from when the plan says that it catches, ``late_of_plan`` from when an arm that
    follows it exactly has the ball within grasp, which may be a little before.
    """
    out = execution_to_json(done)
    plant, planned = done.plant, done.planned
    if plant is None or planned is None:
        return out
    k = min(round(planned / STEP), plant.steps)
    hand = forward_in_space(plan.trajectory.arm, plant.joints_log[k])[1]
    out["error_as_planned"] = float(np.linalg.norm(hand - plan.trajectory.hand_at(k * STEP)))
    if done.catch_time is not None:
        out["late"] = done.catch_time - planned
        out["late_of_plan"] = done.catch_time - met(plant.situation, plan)
    return out


def met(situation: Spatial, plan: Any) -> float:
    """When an arm that follows a plan exactly has the ball within grasp [s]."""
    ball, times = situation.bodies[0].shape, np.arange(0.0, plan.catch_time, STEP)
    places = np.array([pose(situation, 0, t)[0] for t in times])
    off = np.linalg.norm(plan.trajectory.hand_at(times) - places, axis=1) - ball.radius
    within = np.flatnonzero(off <= situation.arm.grasp)
    return float(times[within[0]]) if within.size else float(plan.catch_time)


def tube() -> Tube:
    """The tube about NAO's plans, measured on other situations by run.py."""
    known = json.loads((HERE / "tubes.json").read_text())["nao"]["known"]
    return Tube(known["still"], known["per_speed"])


def measured(index: int) -> dict[str, Any]:
    """What is planned for a variation, and what becomes of it, with three others beside it."""
    free = varied(index)
    limited = with_motor_limits(free, body_for(free.arm))
    planner, since = get_planner("search"), process_time()
    plan: Any = planner.plan(limited)
    ms = 1e3 * (process_time() - since)
    loose: Any = planner.plan(free)
    wide: Any = InTube(planner, tube()).plan(limited)
    return {
        "index": index,
        "ms": round(ms, 1),
        "clearance": plan.clearance,
        "executed": told(execute(plan, limited), plan),
        "tube": told(execute(wide, limited), wide),
        "gravity": told(execute(plan, limited, controller=Controller("gravity")), plan),
        "kinematic": told(execute(loose, free), loose),
    }


def spread(values: list[float]) -> list[float]:
    """Median, nine tenths and largest, in four digits."""
    if not values:
        return []
    return [float(f"{v:.4g}") for v in (*np.quantile(values, (0.5, 0.9)), max(values))]


def summed(reports: list[dict[str, Any]]) -> dict[str, Any]:
    """Counts, and how well plans were followed."""
    planned = [r for r in reports if r["status"] != "no plan"]
    caught = [r for r in planned if r["status"] == "caught"]
    precise = {
        "within_2_cm": [r["error_as_planned"] < NEAR for r in caught],
        "within_5_ms": [abs(r["late"]) < SOON for r in caught],
        "within_5_ms_of_plan": [r["late_of_plan"] < SOON for r in caught],
    }
    return {
        "situations": len(reports),
        "planned": len(planned),
        "caught": len(caught),
        "collided": dict(Counter(r["contact"]["name"] for r in planned if r["contact"])),
        "late": sum(r["status"] == "late" for r in planned),
        "error_at_catch": spread([r["error_at_end"] for r in caught]),
        "error_largest": spread([r["error_max"] for r in caught]),
        "torque": spread([r["torque"] for r in caught]),
        "catch_time": spread([r["catch_time"] for r in caught]),
        "off_in_time": spread([abs(r["late"]) for r in caught]),
        "later_than_the_plan_has_it": spread([r["late_of_plan"] for r in caught]),
        **{name: sum(hits) for name, hits in precise.items()},
        "stays": sum(r["stays"] for r in caught),
        "braked_into": dict(Counter(r["braked_into"]["name"] for r in caught if r["braked_into"])),
    }


def clear(row: dict[str, Any]) -> bool:
    """Whether there is a plan, and it does not pass close to anything."""
    return row["clearance"] is not None and row["clearance"] >= CLEAR


def table(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """What RESULTS holds."""
    rows = sorted(rows, key=lambda row: row["index"])
    return {
        "seed": SEED,
        "ranges": {
            "release [degrees]": RELEASE,
            "cord [m]": CORD,
            "box ahead, aside [m]": BOX,
            "start [rad]": START,
        },
        "tube [m, s]": [tube().still, tube().per_speed],
        "planning_ms": spread([row["ms"] for row in rows]),
        **{
            name: summed([row[name] for row in rows])
            for name in ("executed", "tube", "gravity", "kinematic")
        },
        "clear": [
            sum(row["executed"]["status"] == status for row in rows if clear(row))
            for status in ("caught", "collided")
        ],
        "close_and_collided": spread(
            [row["clearance"] for row in rows if row["executed"]["status"] == "collided"]
        ),
        "no_plan": dict(
            Counter(
                row["executed"]["message"] for row in rows if row["executed"]["status"] == "no plan"
            )
        ),
        "rows": [_short(row) for row in rows],
    }


def _short(row: dict[str, Any]) -> list[Any]:
    """Index, status, planned and real time of the catch [s]."""
    done = row["executed"]
    times = [done[key] for key in ("planned_catch_time", "catch_time")]
    return [row["index"], done["status"], *(t if t is None else round(t, 4) for t in times)]


def written(results: dict[str, Any]) -> str:
    """JSON with a line for each entry, and for each row."""
    rows = ",\n  ".join(json.dumps(row) for row in results["rows"])
    rest = [f' "{k}": {json.dumps(v)}' for k, v in results.items() if k != "rows"]
    return "{\n" + ",\n".join(rest) + f',\n "rows": [\n  {rows}\n ]\n}}\n'


def main() -> None:
    """Answer what is missing, then write the results."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=COUNT, help="variations")
    parser.add_argument("--minutes", type=float, default=np.inf, help="no new one after that")
    arguments, since = parser.parse_args(), perf_counter()
    ANSWERS.parent.mkdir(exist_ok=True)
    lines = ANSWERS.read_text().splitlines() if ANSWERS.exists() else []
    rows = [json.loads(line) for line in lines]
    done = {row["index"] for row in rows}
    with ANSWERS.open("a") as stream:
        for index in range(arguments.count):
            if index in done or perf_counter() - since > 60.0 * arguments.minutes:
                continue
            rows.append(measured(index))
            stream.write(json.dumps(rows[-1]) + "\n")
            stream.flush()
    write_whole(RESULTS, written(table(rows)))
    print(json.dumps(table(rows)["executed"]))


if __name__ == "__main__":
    main()
