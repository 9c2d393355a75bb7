"""What does a hold spare an arm, and what does latency cost it? Writes gripper.json and pick.gif.

python -m experiments 14_body/gripper

It takes minutes.
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from gcm_learn.arms import Chain
from gcm_learn.execution import (
    Execution,
    Loop,
    Perception,
    Planning,
    as_touch,
    body_for,
    execute,
    execute_seen,
    tube_about,
)
from gcm_learn.families import draw
from gcm_learn.planners import InTube, get_planner
from gcm_learn.plots import animate_execution
from gcm_learn.situation import (
    Approach,
    Body,
    Box,
    Hold,
    Place,
    Situation,
    SolidQuadratic,
    Sphere,
    shipped_arm,
)
from gcm_learn.storage import write_whole

HERE = Path(__file__).resolve().parent
PRESETS, SEED, COUNT = ("panda-easy", "panda-crowded"), 1413, 40
HOLD = Hold(0.2, 0.1)
LIMITS = (15.0, 7.5, 10.0, 12.5, 15.0, 20.0, 20.0)
"""Of accelerations: the Panda's own [rad/s^2]."""
HOME = (0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785)
LATENCIES = (0, 20, 50)  # [ms]
THINKING = 0.02
"""Time that every thought takes [s]."""
PLANNER: Any = get_planner("search")


def held(preset: str, index: int) -> Any:
    """Return a situation whose target is to be held."""
    free: Any = draw(preset, SEED, index)
    arm = replace(free.arm, max_joint_acceleration=LIMITS)
    bodies = tuple(replace(b, hold=HOLD) if b.role == "target" else b for b in free.bodies)
    return replace(free, arm=arm, bodies=bodies, end="rest", format="gcm-learn/situation@4")


def known(situation: Any) -> Execution:
    """Return the execution of a plan in its tube, whose hand grips."""
    body = body_for(situation.arm)
    plan = PLANNER.plan(situation)
    if plan.caught:
        plan = InTube(PLANNER, tube_about(plan, situation, body)).plan(situation)
    return execute(plan, situation, body, grips=True)


def late(situation: Any, latency: float) -> Execution:
    """Return the execution in the closed loop, with exact eyes that are late."""
    loop = Loop(Perception(latency=latency), looks=2, thinking=THINKING, latency=latency)
    return execute_seen(Planning(PLANNER), situation, loop, SEED, body=body_for(situation.arm))


def spread(values: Any) -> list[float]:
    """Return median, tenth and nine tenths."""
    return [float(f"{v:.3g}") for v in np.quantile(np.asarray(values), (0.5, 0.1, 0.9))]


def impacts(pairs: list[tuple[Execution, Execution]]) -> dict[str, Any]:
    """Return impulses and torques of holds and of touches of the same situations."""
    both = [(one.grip, two.grip) for one, two in pairs if one.grip and two.grip]
    hold, touch = (
        np.array([(grip.impulse, grip.torque) for grip in column])
        for column in zip(*both, strict=True)
    )
    ratio = hold / touch
    return {
        "gripped": sum(one.caught for one, _ in pairs),
        "pairs": len(both),
        "impulse_mNs": {"hold": spread(1e3 * hold[:, 0]), "touch": spread(1e3 * touch[:, 0])},
        "torque_mNm": {"hold": spread(1e3 * hold[:, 1]), "touch": spread(1e3 * touch[:, 1])},
        "impulse_ratio": spread(ratio[:, 0]),
        "at_most_a_fifth": int((ratio[:, 0] <= 0.2).sum()),
    }


def film() -> None:
    """Film a Panda that picks a box from a belt."""
    limits: Any = {"max_joint_acceleration": LIMITS, "max_joint_jerk": (3750.0,) * 7}
    panda = Chain(shipped_arm("panda"), HOME, grasp=0.03, **limits)
    still = (0.0, 0.0, 0.0)
    belt = SolidQuadratic((0.5, -0.4, 0.2), (0.0, 0.3, 0.0), still)
    swing = SolidQuadratic((0.6, 0.5, 0.7), (0.0, -0.4, 0.0), still)
    down, hold, place = (
        Approach((0.0, 0.0, -1.0), 0.3),
        Hold(0.2, 0.05),
        Place((0.3, 0.4, 0.4), 0.02),
    )
    part = Body("target", "part", Box((0.03,) * 3), belt, (down,), hold, place)
    bodies = part, Body("obstacle", "ball", Sphere(0.12), swing)
    situation: Any = Situation("pick", 2.0, panda, bodies, end="rest")
    done = execute(PLANNER.plan(situation), situation)
    animate_execution(situation, done, HERE / "pick.gif", frames=28, views=8)


def main() -> None:
    """Execute holds and touches, with all known and in the closed loop."""
    table: dict[str, Any] = {"seed": SEED, "situations": COUNT}
    asked: list[Any] = []
    for preset in PRESETS:
        pairs = []
        for situation in (held(preset, index) for index in range(COUNT)):
            done = known(situation)
            if done.caught:
                pairs.append((done, known(as_touch(situation))))
                asked.append(situation)
        table[preset] = impacts(pairs)
    table["latency"] = {"asked": len(asked)}
    for name, of in (("hold", lambda s: s), ("touch", as_touch)):
        for latency in LATENCIES:
            done = [late(of(situation), latency / 1e3) for situation in asked]
            counts = {s: sum(one.status == s for one in done) for s in ("caught", "collided")}
            table["latency"][f"{name} {latency}"] = counts
            print(name, latency, counts, flush=True)
    film()
    write_whole(HERE / "gripper.json", (json.dumps(table, indent=1) + "\n").encode())
    print(json.dumps(table, indent=1))


if __name__ == "__main__":
    main()
