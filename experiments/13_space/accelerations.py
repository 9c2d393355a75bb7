"""Which share of kinematic catches is left under limits of acceleration?

Situations of all families in space are planned by `search` without limits of acceleration, and
then with limits under which a joint comes to its full speed in a given time.  Every catch is judged
by the referee of the tests.

python -m experiments 13_space/accelerations     goes on from where it was stopped
"""

from __future__ import annotations

import argparse
import json
import time as clock
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from experiments.common.judging import complaints
from gcm_learn.arms import SpatialArm
from gcm_learn.families import draw, family_names
from gcm_learn.planners import get_planner
from gcm_learn.situation import Situation

HERE = Path(__file__).parent
SEED = 1301
EACH = 20  # situations of every family
RAMPS = (0.0, 0.025, 0.05, 0.1, 0.2)  # from rest to full speed [s]; 0: no limit
ANSWERS = HERE / "out" / "accelerations.jsonl"


def limited(situation: Situation[SpatialArm], ramp: float) -> Situation[SpatialArm]:
    """The situation with limits of acceleration; it begins at rest."""
    if ramp == 0.0:
        return situation
    limits = tuple(speed / ramp for speed in situation.arm.max_joint_speed)
    return replace(situation, arm=replace(situation.arm, max_joint_acceleration=limits))


def answer(family: str, index: int, ramp: float) -> dict[str, Any]:
    """One plan: whether it catches, when, how, after how long, and whether it holds."""
    situation = limited(draw(family, SEED, index), ramp)
    since = clock.process_time()
    plan = get_planner("search").plan(situation)
    took = 1e3 * (clock.process_time() - since)
    broken = False
    if plan.caught:
        broken = bool(complaints(situation, plan))
    return {
        "family": family,
        "index": index,
        "ramp": ramp,
        "caught": plan.caught,
        "catch_time": plan.catch_time,
        "ms": round(took, 2),
        "broken": broken,
        "dash": plan.caught and ramp > 0.0 and plan.trajectory.time.size <= 3,
    }


def main() -> None:
    """Answer what is missing, then write the table."""
    argparse.ArgumentParser(description=__doc__.splitlines()[0]).parse_args()
    ANSWERS.parent.mkdir(exist_ok=True)
    rows = (
        [json.loads(line) for line in ANSWERS.read_text().splitlines()] if ANSWERS.exists() else []
    )
    done = {(row["family"], row["index"], row["ramp"]) for row in rows}
    get_planner("search").plan(limited(draw("late-target-space", 0, 0), 0.1))  # compiled now
    with ANSWERS.open("a") as stream:
        for index in range(EACH):
            for family in family_names("spatial"):
                for ramp in RAMPS:
                    if (family, index, ramp) not in done:
                        rows.append(answer(family, index, ramp))
                        stream.write(json.dumps(rows[-1]) + "\n")
                        stream.flush()
    (HERE / "accelerations.json").write_text(json.dumps(table(rows), indent=1) + "\n")


def table(rows: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """By ramp: how many are caught, of those that are without limits, and what it costs."""
    free = {(r["family"], r["index"]) for r in rows if r["ramp"] == 0.0 and r["caught"]}
    out = []
    for ramp in RAMPS:
        mine = [r for r in rows if r["ramp"] == ramp]
        caught = [r for r in mine if r["caught"]]
        kept = sum((r["family"], r["index"]) in free for r in caught)
        ms = np.array([r["ms"] for r in caught])
        out.append(
            {
                "ramp": ramp,
                "situations": len(mine),
                "caught": len(caught),
                "kept_of_kinematic": kept / max(len(free), 1),
                "by_a_dash": sum(r["dash"] for r in caught),
                "broken": sum(r["broken"] for r in mine),
                "ms_median": float(np.median(ms)) if len(ms) else None,
                "ms_90": float(np.quantile(ms, 0.9)) if len(ms) else None,
            }
        )
    return out


if __name__ == "__main__":
    main()
