"""Compare methods with an arm in space, kinematic and with mass; write space.json.

python -m experiments 11_comparison/space              144 situations, 12 of each family
python -m experiments 11_comparison/space --minutes 8  what can be done in eight minutes
python -m experiments 11_comparison/space --only ppo-space,ppo-space@20   only these methods

Answers are kept in out/ and reused; Ctrl-C is safe.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from dataclasses import fields, replace
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np
from scipy.stats import binomtest

from gcm_learn.arms import SPATIAL, SpatialArm
from gcm_learn.evaluation import complaints, get_method
from gcm_learn.execution import (
    OUTCOMES,
    PhysicalSettings,
    SpatialSettings,
    body_for,
    execute,
    pool_for,
    with_motor_limits,
)
from gcm_learn.families import draw, family_names, get_family
from gcm_learn.planners import Plan, STRRTStarPlanner
from gcm_learn.policies import actor_names, shipped_actor
from gcm_learn.situation import ArmBody, Situation
from gcm_learn.storage import write_whole

HERE = Path(__file__).resolve().parent
SEED = 1420
COUNT = 12  # situations of each family
BUDGET_MS = 100.0  # of ST-RRT*
PLANNERS = ("straight", "straight-wait", "potential", "marching", "search")
POLICIES = ("ppo-space", "ppo-space@20")
"""A trained actor that acts as it goes, unverified, and the same tried out and verified first."""
METHODS = (*PLANNERS, "st-rrt-star", *POLICIES)
KEEPING = ("marching", "search", "ppo-space@20")
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
    method: Any = get_method(name)
    since = process_time()
    plan = method.planner.plan(situation)
    return plan, 1e3 * (process_time() - since)


def followed(name: str, free: Spatial, body: ArmBody) -> dict[str, Any]:
    """A planner: what it finds, and what comes of that with mass."""
    plan, ms = planned(name, free)
    told: dict[str, Any] = {"caught": plan.caught, "ms": round(ms, 2)}
    if plan.caught:
        told["complaints"] = complaints(free, plan)
    limited = with_motor_limits(free, body)
    if name in KEEPING:
        plan, told["limited ms"] = planned(name, limited)
        told["limited"] = plan.caught
    done = execute(plan, limited if name in KEEPING else free, body)
    told["body"] = done.status
    told["error"] = None if done.error is None else round(1e3 * done.error[1], 2)
    return told


def acted(name: str, free: Spatial, body: ArmBody) -> dict[str, Any]:
    """A policy that acts as it goes, unverified.

    With mass its path under the motors' limits is followed as plans are. Beside it, the motors
    servo to its commands, as in the arena with mass.
    """
    result = get_method(name).answer(free)
    told: dict[str, Any] = {
        "caught": result.outcome == "caught",
        "touched": result.outcome == "touched",
        "ms": round(result.ms, 2),
    }
    if told["caught"]:
        told["complaints"] = judged(free, result.plans[0].trajectory)
    limited = with_motor_limits(free, body)
    under = get_method(name).answer(limited)
    told["limited"] = under.outcome == "caught"
    plan = Plan(free.name, name, "caught", "", 0.0, trajectory=under.plans[0].trajectory)
    told["body"] = execute(plan, limited, body).status
    actor = shipped_actor(name)
    same = {field.name: getattr(actor.settings, field.name) for field in fields(SpatialSettings)}
    arena = replace(actor, settings=PhysicalSettings(**same))
    done = arena.play(pool_for(arena.settings, [free], body), np.zeros(1, np.int64))
    told["servo"] = OUTCOMES[int(done.outcomes[0])]
    return told


def judged(situation: Spatial, moves: Any) -> list[str]:
    """Return the referee's complaints about a movement, with the target that has the fewest.

    Complaints about clearance do not count, because a movement claims none.
    """
    plan = Plan(
        situation.name, "policy", "caught", "", 0.0, catch_time=moves.duration, trajectory=moves
    )
    found = []
    for target in situation.targets:
        texts = complaints(situation, replace(plan, catch_body=target.name))
        found.append([text for text in texts if not text.startswith("clearance")])
    return min(found, key=len)


def answer(family: str, index: int, methods: Sequence[str], row: dict[str, Any]) -> dict[str, Any]:
    """Methods on one situation, without mass and with it, beside those that are in the row."""
    free = drawn(family, index)
    body = body_for(free.arm)
    new = {
        name: (acted if name in actor_names(SPATIAL) else followed)(name, free, body)
        for name in methods
        if name not in row
    }
    return {"family": family, "index": index, "body": body.name, **row, **new}


def table(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Shares with 95 % intervals, by whether a straight line catches."""
    out: dict[str, Any] = {"situations": len(rows)}
    groups = {
        "straight": [row for row in rows if row["straight"]["caught"]],
        "rest": [row for row in rows if not row["straight"]["caught"]],
    }
    for group, mine in groups.items():
        out[group] = {"situations": len(mine), "methods": {}}
        for name in (name for name in METHODS if all(name in row for row in mine)):
            told = [row[name] for row in mine]
            ms, acts = [one["ms"] for one in told], all("touched" in one for one in told)
            out[group]["methods"][name] = {
                "kinematic": share(sum(one["caught"] for one in told), len(told)),
                "broken": sum(bool(one.get("complaints")) for one in told),
                "with mass": share(sum(one["body"] == "caught" for one in told), len(told)),
                "collided": sum(one["body"] == "collided" for one in told),
                **(unverified(told) if acts else {}),
                "ms": [float(np.median(ms)), float(np.quantile(ms, 0.9))] if ms else None,
            }
    return out


def unverified(told: list[dict[str, Any]]) -> dict[str, Any]:
    """Return further counts of a policy."""
    return {
        "touched": sum(one["touched"] for one in told),
        "servoed": share(sum(one["servo"] == "caught" for one in told), len(told)),
        "servoed, touched": sum(one["servo"] == "touched" for one in told),
    }


def beside(made: dict[str, Any], path: Path) -> dict[str, Any]:
    """A table with the methods that only an older one of as many situations has."""
    old: dict[str, Any] = json.loads(path.read_text()) if path.exists() else {}
    for group in ("straight", "rest"):
        if old.get(group, {}).get("situations") == made[group]["situations"]:
            made[group]["methods"] = old[group]["methods"] | made[group]["methods"]
    return made


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
    parser.add_argument("--only", default=",".join(METHODS), help="methods, with commas")
    asked, started = parser.parse_args(), perf_counter()
    there = (*PLANNERS, "st-rrt-star", *actor_names(SPATIAL))
    wanted = ("straight", *asked.only.split(","))  # by which situations are told apart
    methods = [name for name in dict.fromkeys(wanted) if name.partition("@")[0] in there]
    OUT.parent.mkdir(exist_ok=True)
    lines = OUT.read_text().splitlines() if OUT.exists() else []
    known = {(row["family"], row["index"]): row for row in map(json.loads, lines)}
    answer(family_names("spatial")[0], 10_000, methods, {})  # kernels are loaded now
    with OUT.open("a") as stream:
        for index in range(COUNT):
            for family in family_names("spatial"):
                row = known.get((family, index), {})
                late = perf_counter() - started > 60.0 * asked.minutes
                if late or all(name in row for name in methods):
                    continue
                known[family, index] = answer(family, index, methods, row)
                stream.write(json.dumps(known[family, index]) + "\n")  # the last line counts
                stream.flush()
    rows = list(known.values())
    made = beside(table(rows), HERE / "space.json")
    if len(rows) == COUNT * len(family_names("spatial")):  # a part is only told
        write_whole(HERE / "space.json", json.dumps(made, indent=1) + "\n")
    print(json.dumps(made, indent=1))


if __name__ == "__main__":
    main()
