"""A true answer of version 4, exact in binary: a gantry takes a box from a belt and lifts it.

Axes x and z slide, the wrist turns about z with half the box's turn, and a finger follows it.
"""

import copy
import math

import numpy as np

from tests.geometry import arm_of
from tests.worlds import ball, body, still

STEP = 0.125
"""Duration of a piece: run-up to 0.25 s, hold to 0.5 s, stop to 0.75 s, lift to 1.25 s."""
RIDE, LIFT = [32, -32, 0, 0, -32, 32, 0, 0, 0, 0], [0, 0, 0, 0, 0, 0, 128, -128, -128, 128]
SPEED, ANGLE, AHEAD = 0.5, 0.25, -0.0625
"""Of box and wrist in the hold; where both end; where the box is at t = 0."""


def slide(axis, speed, acceleration, jerk, **more):
    limits = {"max_speed": speed, "max_acceleration": acceleration, "max_jerk": jerk}
    return {"axis": axis, "type": "prismatic", "range": [-2, 2], **limits, **more}


FOLLOWS = {"joint": 3, "factor": 0.5, "offset": 0.01}
MODEL = {
    "format": "gcm-learn/arm@2", "name": "gantry",
    "joints": [
        slide([1, 0, 0], 0.6, 5, 33), slide([0, 0, 1], 2.5, 20, 130),
        slide([0, 0, 1], 0.6, 5, 33, type="revolute"),
        slide([0, 1, 0], 0.3, 2.5, 17, origin=[0.15, 0.1, 0.1], follows=FOLLOWS),
    ],
    "links": [
        {"joint": 2, "from": [0, 0, 0.12], "to": [0, 0, 0.3], "radius": 0.03, "name": "mast"},
        {"joint": 3, "from": [0, 0, 0.1], "to": [0.2, 0, 0.1], "radius": 0.02},
        {"joint": 4, "from": [0, 0, 0], "to": [0.05, 0, 0], "radius": 0.01, "name": "finger"},
    ],
    "hand": {"joint": 3, "point": [0.2, 0, 0], "axis": [1, 0, 0]},
}  # fmt: skip


def about_z(angle):
    return [math.cos(angle / 2), 0.0, 0.0, math.sin(angle / 2)]


def flight(start, position, angle, velocity=SPEED, spin=SPEED):
    """A piece of the box's motion, which goes along x and turns about z."""
    motion = {"position": [position, 0.0, 0.0], "velocity": [velocity, 0.0, 0.0]}
    motion |= {"acceleration": [0.0] * 3, "orientation": about_z(angle), "spin": [0.0, 0.0, spin]}
    return motion if start is None else motion | {"start": start}


def pieces(*parts):
    """A motion that begins as that of the box; parts are start, velocity and spin."""
    made, at, angle, before = [], AHEAD, AHEAD, (0.0, SPEED, SPEED)
    for part in [before, *parts]:
        span = part[0] - before[0]
        at, angle = at + span * before[1], angle + span * before[2]
        made.append(flight(part[0], at, angle, part[1], part[2]))
        before = part
    return {"kind": "piecewise", "pieces": made}


def zigzag(off, last=0.5):
    """A motion in samples that turns not, off to the right and left of the straight way."""
    times = np.arange(0.0, last + 0.01, 0.0625)
    side = off * np.where(np.arange(len(times)) % 2, 1.0, -1.0)
    places = np.stack([AHEAD + SPEED * times + side, 0.0 * times, 0.0 * times], axis=1)
    turns = [about_z(AHEAD + SPEED * t) for t in times]
    motion = {"kind": "sampled", "times": times.tolist(), "positions": places.tolist()}
    return motion | {"orientations": turns}


def ridden(jerks):
    """Places and rates at the ends of pieces of constant jerk, from rest."""
    q = v = a = 0.0
    rows = [(q, v)]
    for j in jerks:
        q += v * STEP + a * STEP**2 / 2 + j * STEP**3 / 6
        v, a = v + a * STEP + j * STEP**2 / 2, a + j * STEP
        rows.append((q, v))
    return np.array(rows).T


def belt():
    """Situation and solution."""
    approach = [
        {"axis": [1, 0, 0], "within": 0.1},
        {"axis": [0, 0, 1], "within": 0.05, "hand": [0, 0, 1]},
    ]
    box = body(
        "target", "box", {"kind": "box", "half_extents": [0.15, 0.05, 0.04]},
        {"kind": "quadratic", **flight(None, AHEAD, AHEAD)}, approach=approach,
        hold={"seconds": 0.25, "relative_speed": 0.1}, ignore=["shelf"], ignore_for=0.36,
        place={"position": [0.25, 0.0, 0.5], "within": 0.03},
    )  # fmt: skip
    shelf = body(
        "obstacle", "shelf", {"kind": "box", "half_extents": [1, 1, 0.02]}, still([0, 0, -0.07])
    )
    wall = body(
        "obstacle", "wall", {"kind": "box", "half_extents": [0.1, 2, 2]}, still([0.8, 0, 0])
    )
    bullet = body("obstacle", "bullet", ball(0.01), still([0.12, 20.3, 0.4], velocity=[0, -20, 0]))
    situation = {"format": "gcm-learn/situation@4", "name": "belt", "horizon": 1.3, "end": "rest"}
    arm = {"kind": "chain", "model": copy.deepcopy(MODEL), "posture": [0.0] * 3, "grasp": 0.06}
    situation |= {"arm": arm, "bodies": [box, shelf, wall, bullet]}
    (x, fast), (z, lifts) = ridden(RIDE), ridden(LIFT)
    path = {"time": np.arange(11) * STEP, "joints": np.stack([x, z, x], 1)}
    path |= {"rates": np.stack([fast, lifts, fast], 1), "hand": np.zeros((11, 3))}
    solution = {"format": "gcm-learn/solution@4", "name": "belt", "planner": "made"}
    solution |= {"status": "caught", "catch_time": 0.25, "catch_body": "box", "clearance": 0.01}
    entry = {"body": "box", "time": 0.25, "held_until": 0.5, "placed": 1.25}
    solution |= {"catches": [entry], "planning_ms": 1.0, "message": ""}
    solution["trajectory"] = {name: column.tolist() for name, column in path.items()}
    return {"situation": situation, "solution": solution}


def edited(pair, edits):
    """A copy with values replaced; None drops fields that are there. Hands follow joints."""
    pair = copy.deepcopy(pair)
    for path, to in edits.items():
        place = pair
        for key in path[:-1]:
            place = place[key]
        if to is None and path[-1] in place:
            del place[path[-1]]
        elif callable(to):
            to(place[path[-1]])
        else:
            place[path[-1]] = copy.deepcopy(to)
    path = pair["solution"].get("trajectory")
    if path:
        arm = arm_of(pair["situation"]["arm"])
        path["hand"] = arm.geometry.point(np.array(path["joints"]), *arm.points["hand"]).tolist()
    return pair
