"""Does a Panda with mass catch what was planned for it? Writes panda.json.

python -m experiments 14_body/panda

It needs the Panda's tube (`run.py tubes --kind chain`) and takes minutes.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from gcm_learn.execution import Execution, body_for, execute, with_motor_limits
from gcm_learn.execution.body.model import STEP
from gcm_learn.families import draw
from gcm_learn.planners import InTube, Tube, get_planner
from gcm_learn.storage import write_whole

HERE = Path(__file__).resolve().parent
PRESET, SEED, COUNT = "panda-easy", 1412, 100


def followed(planner: Any) -> list[Execution]:
    """Return executions of a planner's plans, under limits of acceleration from the motors."""
    done = []
    for index in range(COUNT):
        free: Any = draw(PRESET, SEED, index)
        situation = with_motor_limits(free, body_for(free.arm))
        done.append(execute(planner.plan(situation), situation))
    return done


def summed(done: list[Execution]) -> dict[str, Any]:
    """Return outcomes, and errors until the catch: median, 95 % quantile and maximum."""
    caught = [one for one in done if one.caught]
    counts = {s: sum(one.status == s for one in done) for s in ("caught", "collided", "late")}
    errors = np.array([one.error for one in caught])
    return counts | {
        "plans": sum(counts.values()),
        "hand_at_the_catch_mm": spread(1e3 * errors[:, 2]),
        "hand_at_most_mm": spread(1e3 * errors[:, 1]),
        "joint_at_most_mrad": spread(1e3 * np.array([joint_error(one) for one in caught])),
        "torque": spread(np.array([one.torque for one in caught])),
    }


def joint_error(done: Execution) -> float:
    """Return how far a joint was from its plan at most until the catch [rad]."""
    assert done.plant is not None and done.plan is not None
    steps = np.arange(done.plant.ended + 1)
    wanted = done.plan.states_at(steps * STEP)[0]
    return float(np.abs(done.plant.joints_log[steps] - wanted).max())


def spread(values: np.ndarray) -> list[float]:
    """Return median, 95 % quantile and maximum."""
    found = np.median(values), np.quantile(values, 0.95), values.max()
    return [round(float(value), 4) for value in found]


def main() -> None:
    """Plan and execute, without and with the tube."""
    given = json.loads((HERE / "tubes.json").read_text())["panda"]["known"]
    planner = get_planner("search")
    tube = Tube(given["still"], given["per_speed"])
    ways = {"bare": planner, "in its tube": InTube(planner, tube)}
    table: dict[str, Any] = {"preset": PRESET, "seed": SEED, "situations": COUNT}
    table |= {way: summed(followed(who)) for way, who in ways.items()}
    write_whole(HERE / "panda.json", (json.dumps(table, indent=1) + "\n").encode())
    print(json.dumps(table, indent=1))


if __name__ == "__main__":
    main()
