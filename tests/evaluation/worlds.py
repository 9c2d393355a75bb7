"""Situations and entrants of the tests of sheets."""

from __future__ import annotations

import copy
import json
from time import process_time

import numpy as np

from gcm_learn import Arm, Body, Disc, Movement, Plan, PlanarQuadratic, Situation

FAR = {
    "format": "gcm-learn/situation@1",
    "name": "far",
    "horizon": 1.0,
    "arm": {"hand": [1.5, 0.0], "max_hand_speed": 3.0},
    "bodies": [
        {
            "role": "target",
            "name": "ball",
            "shape": {"kind": "disc", "radius": 0.05},
            "motion": {
                "kind": "quadratic",
                "position": [9.0, 0.0],
                "velocity": [0.0, 0.0],
                "acceleration": [0.0, 0.0],
            },
        }
    ],
}
NEAR = copy.deepcopy(FAR) | {"name": "near"}
NEAR["bodies"][0]["motion"]["position"] = [1.2, 0.6]
LATER = copy.deepcopy(NEAR) | {"name": "later", "horizon": 2.0}
LATER["bodies"][0]["motion"]["velocity"] = [0.0, 0.1]


def three(path):
    """Write a file of a warm-up and three situations, one of them out of reach."""
    lines = [
        {"suite": "three", "family": "", "stratum": stratum, "situation": values}
        for stratum, values in (
            ("warm-up", NEAR | {"name": "before"}), ("L", NEAR), ("L", LATER), ("U", FAR)
        )
    ]  # fmt: skip
    path.write_text("".join(json.dumps(line) + "\n" for line in lines), "utf-8")
    return path


def moving(role, position, velocity, name=""):
    """A disc on its way."""
    return Body(role, name or role, Disc(0.1), PlanarQuadratic(position, velocity, (0.0, 0.0)))


def scene(*bodies, name="scene", horizon=1.0, **more):
    """A situation with the hand at (1.5, 0)."""
    return Situation(name, horizon, Arm((1.5, 0.0), 3.0), bodies, **more)


def slow_straight(situation):
    """Go straight to a target as late as may be; spend 30 ms on it."""
    until = process_time() + 0.03
    while process_time() < until:
        pass
    motion, end = situation.targets[0].motion, situation.horizon
    if np.linalg.norm(motion.position) > 2.0:
        return Plan(situation.name, "slow", "unreachable", "", 0.0)
    goal = np.array(motion.position) + end * np.array(motion.velocity)
    moves = Movement.of_hand(
        situation.arm, np.linspace(0.0, end, 60), np.linspace(situation.arm.hand, goal, 60)
    )
    name = situation.targets[0].name
    return Plan(situation.name, "slow", "caught", "", 0.0, end, name, trajectory=moves)


def boasting(situation):
    """Promise a catch by a leap."""
    goal = np.array(situation.targets[0].motion.position)
    goal = goal / max(1.0, np.linalg.norm(goal) / 1.9)
    time = np.array([0.0, 1e-3])
    moves = Movement.of_hand(situation.arm, time, np.array([situation.arm.hand, goal]))
    name = situation.targets[0].name
    return Plan(situation.name, "boasts", "caught", "", 0.0, 1e-3, name, trajectory=moves)


def failing(situation):
    """Raise an error."""
    raise RuntimeError("no idea")
