"""Situations of chains, drawn from numbers alone: item k of a set is always the same."""

import math

import numpy as np

from gcm_learn.situation import arm_to_json, shipped_arm
from tests.geometry import arm_of, hand_of, least_at, links_of, poses

HALF = math.sqrt(0.5)
SLIDE = {
    "format": "gcm-learn/arm@1",
    "name": "slide",
    "joints": [
        {"origin": [0, 0, 0.3], "axis": [0, 0, 1], "range": [-2, 2], "max_speed": 3},
        {
            "type": "prismatic", "origin": [0.1, 0, 0], "rotation": [HALF, 0, HALF, 0],
            "axis": [0, 0, 1], "range": [0, 0.6], "max_speed": 1.5,
        },
        {
            "origin": [0, 0, 0.2], "rotation": [HALF, HALF, 0, 0],
            "axis": [0, 0, 1], "range": [-2, 2], "max_speed": 4,
        },
    ],
    "links": [
        {"joint": 0, "from": [0, 0, 0], "to": [0, 0, 0.2], "radius": 0.05},
        {"joint": 2, "from": [0, 0, 0], "to": [0, 0, 0.2], "radius": 0.04},
        {"joint": 3, "from": [0.05, 0, 0], "to": [0.3, 0, 0], "radius": 0.03},
    ],
    "hand": {"joint": 3, "point": [0.3, 0, 0], "axis": [1, 0, 0]},
    "self_collision": [[0, 2]],
}  # fmt: skip

LEVERS = SLIDE | {
    "format": "gcm-learn/arm@2",
    "name": "levers",
    "joints": [
        *SLIDE["joints"][:2],
        {
            "origin": [0, 0.1, 0.1], "axis": [1, 0, 0], "range": [-2, 2], "max_speed": 9,
            "parent": 1, "follows": {"joint": 2, "factor": -1.5, "offset": 0.2},
        },
        SLIDE["joints"][2] | {"parent": 2},
        {
            "type": "prismatic", "origin": [0.3, 0, 0], "axis": [1, 0, 0], "range": [-2, 2],
            "max_speed": 9, "follows": {"joint": 2, "factor": 0.5},
        },
    ],
    "links": [
        *SLIDE["links"][:2],
        {"joint": 3, "from": [0, 0, 0], "to": [0, 0, 0.3], "radius": 0.02},
        {"joint": 4, "from": [0.05, 0, 0], "to": [0.3, 0, 0], "radius": 0.03},
        {"joint": 5, "from": [0, 0, 0], "to": [0.1, 0, 0], "radius": 0.02},
    ],
    "hand": {"joint": 5, "point": [0.1, 0, 0], "axis": [1, 0, 0]},
}  # fmt: skip
"""A lever beside a telescope whose second stage follows the first."""

MODELS = {
    "panda": arm_to_json(shipped_arm("panda")),
    "planar-2": arm_to_json(shipped_arm("planar-2")),
    "slide": SLIDE,
}
SETS = tuple(MODELS)
COUNT = 15
BLOCKED = 7  # the item of a set that is blocked at the start
LAWS = ("quadratic", "piecewise", "sampled", "pendulum")
TRIES = 200


def drawn(name, k):
    """Situation k of a set, in the format ``gcm-learn/situation@3``."""
    rng = np.random.default_rng([SETS.index(name), k])
    model = MODELS[name]
    given = {"kind": "chain", "model": model, "grasp": 0.03, "base": _base(rng, k)}
    given["posture"] = [0.0] * len(model["joints"])
    arm = arm_of(given)
    size, horizon = arm.size, float(rng.uniform(0.8, 1.6))
    start = _free_posture(rng, arm, [])
    given["posture"] = start.tolist()
    if k % 5 == 3:
        given["max_hand_speed"] = 0.8 * size
    bodies = [_target(rng, arm, start, horizon, LAWS[k % 4], k % 3 == 1)]
    ends, _ = links_of(arm, start[None])
    if k == BLOCKED:
        bodies.append(_body(rng, "wall", 0.05 * size, _law(rng, "quadratic", ends[-1, 1, 0], 0.0)))
    if k % 4 == 2:  # a table in the first link, which stands on it
        first = int(np.argmin([link["joint"] for link in model["links"]]))
        given["ignore"] = [[first, "table"]]
        bodies.append(
            _body(rng, "table", 0.04 * size, _law(rng, "quadratic", ends[first, 0, 0], 0.0))
        )
        bodies[-1]["shape"] = {"kind": "box", "half_extents": [0.04 * size] * 3}
    for i in range(int(rng.integers(2, 7))):
        bodies.append(_obstacle(rng, arm, start, bodies, f"body {i}", given.get("ignore", [])))
    situation = {"format": "gcm-learn/situation@3", "name": f"{name}-{k}", "horizon": horizon}
    return situation | {"arm": given, "bodies": bodies}


def _base(rng, k):
    if k % 2:
        return {}
    turn = rng.normal(size=4)
    return {
        "origin": rng.uniform(-1.0, 1.0, 3).tolist(),
        "rotation": (turn / np.linalg.norm(turn)).tolist(),
    }


def _free_posture(rng, arm, bodies):
    """A posture in which no pair of links overlaps, nor a link any of the bodies."""
    for _ in range(TRIES):
        posture = rng.uniform(arm.limits.low, arm.limits.high)
        if min(least_at({"bodies": bodies}, arm, np.zeros(1), posture[None])) > 0.01:
            return posture
    raise ValueError("no free posture")


def _target(rng, arm, start, horizon, law, approached):
    """A small body whose way leads past the hand of a posture that the arm can reach in time."""
    when = float(rng.uniform(0.4, 0.8)) * horizon
    way = rng.uniform(-0.6, 0.6, len(start)) * when * arm.limits.speed
    goal = np.clip(start + way, arm.limits.low, arm.limits.high)
    hand, axis = hand_of(arm, goal[None])
    made = _body(rng, "target", 0.02 * arm.size, _law(rng, law, hand[0], when))
    made["role"] = "target"
    if approached:
        _, turn = poses(made, np.array([when]))
        made["approach"] = {"axis": (turn[0].T @ axis[0]).tolist(), "within": 0.5}
    return made


def _obstacle(rng, arm, start, bodies, name, ignored):
    """A body that is free of the arm at t = 0."""
    size = arm.size
    for _ in range(TRIES):
        centre = arm.geometry.base[0] + rng.uniform(-1.0, 1.0, 3) * size
        law = _law(rng, LAWS[int(rng.integers(4))], centre, float(rng.uniform(0.0, 1.0)))
        made = _body(rng, name, float(rng.uniform(0.03, 0.12)) * size, law)
        if least_at({"bodies": [made]}, arm, np.zeros(1), start[None])[0] > 0.01:
            return made
    raise ValueError("no room for an obstacle")


def _body(rng, name, size, motion):
    kind = ("sphere", "box", "capsule", "cylinder")[int(rng.integers(4))]
    if kind == "sphere":
        shape = {"radius": size}
    elif kind == "box":
        shape = {"half_extents": (size * rng.uniform(0.3, 1.0, 3)).tolist()}
    else:
        shape = {"radius": 0.5 * size, "half_length": float(rng.uniform(0.3, 1.0)) * size}
    return {"role": "obstacle", "name": name, "shape": {"kind": kind} | shape, "motion": motion}


def _unit(rng, count):
    given = rng.normal(size=count)
    return (given / np.linalg.norm(given)).tolist()


def _law(rng, law, place, when):
    """A motion that is at a place at a time."""
    velocity = rng.uniform(-0.7, 0.7, 3)
    turning = {"orientation": _unit(rng, 4), "spin": rng.uniform(-3.0, 3.0, 3).tolist()}
    if law == "quadratic":
        fall = np.array([0.0, 0.0, -1.0])
        first = place - when * velocity + 0.5 * when**2 * fall
        begin = (velocity - when * fall).tolist()
        made = {"position": first.tolist(), "velocity": begin, "acceleration": fall.tolist()}
        return {"kind": law} | made | turning
    if law == "piecewise":
        calm = {"acceleration": [0.0] * 3, "orientation": turning["orientation"]}
        half = max(0.5 * when, 0.05)
        after = rng.uniform(-0.7, 0.7, 3)
        middle = place - (when - half) * after
        before = {"start": 0.0, "position": (middle - half * velocity).tolist()}
        pieces = [before | {"velocity": velocity.tolist()} | calm]
        pieces.append(
            {"start": half, "position": middle.tolist(), "velocity": after.tolist()} | calm
        )
        return {"kind": law, "pieces": pieces}
    if law == "sampled":
        times = sorted({0.0, 0.3, when, when + 0.4})
        places = [(place + rng.uniform(-0.3, 0.3, 3) * (t != when)).tolist() for t in times]
        return {
            "kind": law, "times": times, "positions": places, "orientations": _turning(rng, times),
        }  # fmt: skip
    axis = np.array(_unit(rng, 3))
    down = np.cross(axis, _unit(rng, 3))
    swing = {"kind": law, "pivot": [0.0] * 3, "axis": axis.tolist(), "length": 0.8, "gravity": 9.8}
    swing |= {"down": (down / np.linalg.norm(down)).tolist(), "angle": 0.5, "rate": 1.0}
    centre, _ = poses({"motion": swing}, np.array([when]))
    return swing | {"pivot": (place - centre[0]).tolist()}


def _turning(rng, times):
    """Orientations that turn on by little."""
    q, made = np.array(_unit(rng, 4)), []
    for _ in times:
        q = q + 0.3 * rng.normal(size=4)
        q /= np.linalg.norm(q)
        made.append(q.tolist())
    return made
