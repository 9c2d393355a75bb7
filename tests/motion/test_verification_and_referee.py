"""Verification in space beside the referee, on random movements.

A movement's limits are as it needs them, but one, which is a hair too tight or too wide. What
verification lets pass the referee has to let pass. What it refuses the referee has to refuse as
well, at the latest where all limits are tighter by the margins that verification keeps.
"""

from __future__ import annotations

import copy
from collections import Counter

import numpy as np
import pytest

from gcm_learn import seeding
from gcm_learn.errors import SituationError
from gcm_learn.motion import Movement, rules_of, verify
from gcm_learn.motion.rules import CATCH_SAFETY, SAFETY
from gcm_learn.planners import Plan, plan_to_json
from gcm_learn.referee import judge
from gcm_learn.scene import pack
from gcm_learn.situation import situation_from_json
from tests.geometry import arm_of, curve_in, hand_of, lowest_gap, signed_distance
from tests.worlds import SHAPES, body, law

BONES = [
    ([1.0, 0.0, 0.0], [1.0, 0.0, 0.0]),
    ([0.105, 0.015, 0.0], [0.1137, 0.0, -0.01231]),
    ([0.3, -0.2, 0.5], [0.1, 0.9, 0.2]),
]
LIMIT = 1e-6  # relative, as the contract grants
HAIRS = (-1e-2, -1e-5, -3e-6, -3e-7, 0.0, 3e-7, 3e-6, 1e-5, 1e-2)


def moved(rng, motion, middle, size):
    """A law of motion about another middle, at another scale."""
    lengths = ("position", "velocity", "acceleration", "pivot", "length", "gravity", "hang")
    motion = motion | {k: np.multiply(size, motion[k]).tolist() for k in lengths if k in motion}
    for key in motion.keys() & {"position", "pivot"}:
        motion[key] = np.add(middle, motion[key]).tolist()
    return motion


def solid(rng, middle, size):
    """A random shape and law of motion."""
    shape = copy.deepcopy(SHAPES[rng.integers(4)])
    for key in shape.keys() - {"kind"}:
        shape[key] = np.multiply(size * rng.uniform(0.3, 1.0), shape[key]).tolist()
    kind = "quadratic" if rng.random() < 0.7 else "pendulum"
    return shape, moved(rng, law(rng, kind), middle, size)


def path_of(rng):
    """A random movement of one to four pieces, half of them on cubic curves."""
    n = int(rng.integers(2, 6))
    joints = rng.uniform(-1.0, 1.0, 4) + 0.6 * rng.normal(size=(n, 4)).cumsum(axis=0)
    path = {"time": np.append(0.0, rng.uniform(0.05, 0.3, n - 1).cumsum()), "joints": joints}
    if rng.random() < 0.5:
        path["rates"] = rng.normal(0.0, 3.0, (n, 4))
    return {name: column.tolist() for name, column in path.items()}


BARE = {"grasp": 0.0, "joint_range": [[-9.0, 9.0]] * 4, "max_joint_speed": [9.0] * 4}


def needs_of(arm, path):
    """What a movement needs of its limits: ranges, rates, accelerations, hand speed."""
    curve = curve_in(path)
    low, high = curve.extremes(0)
    rates, bends = curve.most(1), curve.most(2)
    read = arm_of(BARE | arm | {"joints": path["joints"][0]})
    fastest = 0.0
    for piece, span in zip(curve.powers, curve.spans, strict=True):
        s, step = np.linspace(2e-6, span - 2e-6, 800), 1e-6
        at = [(piece @ (s + d) ** np.arange(4)[:, None]).T for d in (step, -step)]
        a, b = (hand_of(read, joints)[0] for joints in at)
        fastest = max(fastest, np.linalg.norm(a - b, axis=1).max() / (2.0 * step))
    return low.min(axis=0), high.max(axis=0), rates.max(axis=0), bends.max(axis=0), fastest


def movement(rng):
    """A situation that its movement just keeps, with room to spare in everything, and both."""
    upper, fore = BONES[rng.integers(3)]
    size, turn = np.linalg.norm(upper) + np.linalg.norm(fore), rng.normal(size=4)
    path = path_of(rng)
    origin = rng.normal(size=3) * size
    base = {"origin": origin.tolist(), "rotation": (turn / np.linalg.norm(turn)).tolist()}
    arm = {"kind": "spatial", "upper_arm": upper, "forearm": fore, "base": base}
    if "rates" in path:
        arm |= {"joint_rates": path["rates"][0], "max_joint_acceleration": [1.0] * 4}
    low, high, rates, bends, fastest = needs_of(arm, path)
    arm |= {"joints": path["joints"][0], "thickness": 0.0, "max_hand_speed": 1.1 * fastest}
    arm["joint_range"] = np.transpose([low - 0.1, high + 0.1]).tolist()
    arm["max_joint_speed"] = (1.1 * rates).tolist()
    if "rates" in path:
        arm["max_joint_acceleration"] = (1.1 * bends).tolist()
    end = path["time"][-1]
    bodies = [body("obstacle", str(k), *solid(rng, origin, size)) for k in range(rng.integers(4))]
    goal = body("target", "goal", *solid(rng, origin, 0.7 * size))
    last = np.array(path["joints"][-1:])
    away = signed_distance(goal, end, hand_of(arm_of(BARE | arm), last)[0][0])
    arm["grasp"] = max(float(away), 0.0) + 0.1 * size
    made = {"format": "gcm-learn/situation@2", "name": "made", "horizon": end}
    return made | {"arm": arm, "bodies": [*bodies, goal]}, path, float(away)


def stress(rng, situation, path, away):
    """Set one limit a hair beside what the movement needs; return its name."""
    arm, hair, k = situation["arm"], HAIRS[rng.integers(len(HAIRS))], int(rng.integers(4))
    low, high, rates, bends, fastest = needs_of(arm, path)
    which = str(rng.choice(["low", "high", "rate", "bend", "hand", "room", "grasp", "horizon"]))
    if which in ("low", "high"):
        end = (high if which == "high" else low)[k]
        out = 1.0 if which == "high" else -1.0
        arm["joint_range"][k][which == "high"] = float(end + out * hair * abs(end))
    elif which == "rate":
        arm["max_joint_speed"][k] = float(rates[k] * (1.0 + hair))
    elif which == "bend" and "rates" in path:
        arm["max_joint_acceleration"][k] = float(bends[k] * (1.0 + hair))
    elif which == "hand":
        arm["max_hand_speed"] = fastest * (1.0 + hair)
    elif which == "room":
        room = room_of(situation, path)
        arm["thickness"] = room * (1.0 - hair) if 0.0 < room < 1e9 else 0.0
    elif which == "grasp":
        arm["grasp"] = max(away, 0.0) * (1.0 + hair)
    elif which == "horizon":
        situation["horizon"] *= 1.0 + min(hair, 0.0)
    return which


def tighter(situation):
    """The situation with every limit tighter by what verification keeps."""
    situation = copy.deepcopy(situation)
    arm = situation["arm"]
    unit = float(np.linalg.norm(arm["forearm"]))
    limits = np.array(arm["joint_range"])
    arm["joint_range"] = (limits - LIMIT * np.abs(limits) * (-1.0, 1.0)).tolist()
    for name in {"max_joint_speed", "max_joint_acceleration", "max_hand_speed"} & arm.keys():
        arm[name] = np.multiply(1.0 - LIMIT, arm[name]).tolist()
    arm["grasp"] -= CATCH_SAFETY * unit
    arm["thickness"] += 1.01 * SAFETY * unit
    return situation


def room_of(situation, path):
    """Least distance of the bones to obstacles over a movement."""
    bare = situation | {"arm": situation["arm"] | {"thickness": 0.0}}
    return max(lowest_gap(bare, path), 0.0)


def both(situation, path):
    """Whether verification is content, and what the referee complains of; None if unreadable."""
    try:
        record = situation_from_json(situation)
    except SituationError:
        return None  # the arm does not start within its limits
    scene = pack(record)
    columns = {name: np.array(column) for name, column in path.items()}
    moves = Movement(record.arm, columns["time"], columns["joints"], columns.get("rates"))
    verdict = verify(scene, rules_of(scene), moves, len(record.bodies) - 1)
    room = room_of(situation, path)
    clearance = verdict.clearance if verdict.good else room - record.arm.thickness
    plan = Plan("made", "none", "caught", "", 0.0, moves.duration, "goal", clearance, moves)
    return verdict, plan_to_json(plan, record)


def compare(seed, count):
    """Judge random movements twice; count answers by the limit that was set."""
    answers = Counter()
    for k in range(count):
        rng = seeding.rng(seed, k)
        situation, path, away = movement(rng)
        which = stress(rng, situation, path, away)
        found = both(situation, path)
        if found is None:
            continue
        verdict, solution = found
        if verdict.good:
            assert judge(situation, solution) == [], (seed, k, which)
        else:
            complaints = judge(tighter(situation), solution)
            broken = [c for c in complaints if c.field != "clearance"]
            assert broken or situation["horizon"] < path["time"][-1], (seed, k, which, verdict)
        answers[which, verdict.good] += 1
    return answers


def test_verification_and_referee_agree():
    answers = compare(31, 90)
    for which in ("low", "high", "rate", "bend", "hand", "grasp", "room", "horizon"):
        assert answers[which, True] > 0, which
        assert answers[which, False] > 0, which


@pytest.mark.slow
@pytest.mark.parametrize("part", range(10))
def test_verification_and_referee_agree_on_thousands(part):
    assert compare(32 + part, 2000).total() > 1500
