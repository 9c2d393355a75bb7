"""Who catches what with an arm in space: kinematic, and with mass. Writes space.json.

python experiments/11_comparison/space.py              144 situations, 12 of each family
python experiments/11_comparison/space.py --minutes 8  what can be done in eight minutes

What is done is kept in out/ and not done again; Ctrl-C is safe.
"""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import replace
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np
from scipy.stats import binomtest

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parents[1])]

from gcm_learn.execution import body_for, execute, with_motor_limits  # noqa: E402
from gcm_learn.families import draw, family_names, get_family  # noqa: E402
from gcm_learn.planners import STRRTStarPlanner, get_planner, plan_to_json  # noqa: E402
from gcm_learn.situation import Situation, SpatialArm, situation_to_json  # noqa: E402
from gcm_learn.storage import write_whole  # noqa: E402
from tests.referee_in_space import judge  # noqa: E402

SEED = 1420
COUNT = 12  # situations of each family
BUDGET_MS = 100.0  # of ST-RRT*
PLANNERS = ("straight", "straight-wait", "potential", "gcm", "marching", "layered")
KEEPING = ("marching", "layered")
"""Keep limits of acceleration; plans of the others are followed as they are, corners and all."""
OUT = HERE / "out" / "space.jsonl"

Spatial = Situation[SpatialArm]


def drawn(family: str, index: int) -> Spatial:
    """A situation with one of the two arms that have bodies, without limits of acceleration."""
    config: Any = get_family(family)
    arms = replace(config.arm, human=0.5, nao=0.5)
    situation: Any = draw(replace(config, arm=arms), SEED, index)
    return replace(
        situation,
        arm=replace(situation.arm, max_joint_acceleration=None, joint_rates=None),
    )


def planned(name: str, situation: Spatial) -> tuple[Any, float]:
    """A planner's answer and its processor time [ms]; for ST-RRT* that is its budget."""
    if name == "st-rrt-star":
        return STRRTStarPlanner().plan_anytime(situation, (BUDGET_MS,))[0], BUDGET_MS
    since = process_time()
    plan = get_planner(name).plan(situation)
    return plan, 1e3 * (process_time() - since)


def answer(family: str, index: int) -> dict[str, Any]:
    """All methods on one situation, without mass and with it."""
    free = drawn(family, index)
    body = body_for(free.arm)
    limited = with_motor_limits(free, body)
    row: dict[str, Any] = {"family": family, "index": index, "body": body.name}
    for name in (*PLANNERS, "st-rrt-star"):
        plan, ms = planned(name, free)
        told: dict[str, Any] = {"caught": plan.caught, "ms": round(ms, 2)}
        if plan.caught:
            found = judge(situation_to_json(free), plan_to_json(plan, free)).complaints
            told["complaints"] = found
        if name in KEEPING:
            plan, told["limited ms"] = planned(name, limited)
            told["limited"] = plan.caught
        world = limited if name in KEEPING else free
        done = execute(plan, world, body)
        told["body"] = done.status
        told["error"] = None if done.error is None else round(1e3 * done.error[1], 2)
        row[name] = told
    return row


def table(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Shares with 95 % intervals, by whether a straight line catches."""
    out: dict[str, Any] = {"situations": len(rows)}
    groups = {
        "straight": [row for row in rows if row["straight"]["caught"]],
        "rest": [row for row in rows if not row["straight"]["caught"]],
    }
    for group, mine in groups.items():
        out[group] = {"situations": len(mine), "methods": {}}
        for name in (*PLANNERS, "st-rrt-star"):
            told = [row[name] for row in mine]
            ms = [one["ms"] for one in told]
            out[group]["methods"][name] = {
                "kinematic": share(sum(one["caught"] for one in told), len(told)),
                "broken": sum(bool(one.get("complaints")) for one in told),
                "with mass": share(sum(one["body"] == "caught" for one in told), len(told)),
                "collided": sum(one["body"] == "collided" for one in told),
                "ms": [float(np.median(ms)), float(np.quantile(ms, 0.9))] if ms else None,
            }
    return out


def share(count: int, of: int) -> list[float] | None:
    """A share and its 95 % interval."""
    if of == 0:
        return None
    interval = binomtest(count, of).proportion_ci(method="wilson")
    return [count / of, interval.low, interval.high]


def main() -> None:
    """Answer what is missing, then write the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--minutes", type=float, default=np.inf, help="no new one after that")
    asked, started = parser.parse_args(), perf_counter()
    OUT.parent.mkdir(exist_ok=True)
    rows = [json.loads(line) for line in OUT.read_text().splitlines()] if OUT.exists() else []
    known = {(row["family"], row["index"]) for row in rows}
    answer(family_names("spatial")[0], 10_000)  # kernels are loaded now
    with OUT.open("a") as stream:
        for index in range(COUNT):
            for family in family_names("spatial"):
                late = perf_counter() - started > 60.0 * asked.minutes
                if late or (family, index) in known:
                    continue
                rows.append(answer(family, index))
                stream.write(json.dumps(rows[-1]) + "\n")
                stream.flush()
    made = table(rows)
    write_whole(HERE / "space.json", json.dumps(made, indent=1) + "\n")
    print(json.dumps(made, indent=1))


if __name__ == "__main__":
    main()
