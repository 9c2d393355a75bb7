"""Bodies of situations as JSON: what tests of distances and motions share."""

from __future__ import annotations

import copy

import numpy as np

ZERO = [0.0, 0.0, 0.0]


def ball(radius):
    return {"kind": "sphere", "radius": radius}


SHAPES = [
    ball(0.3),
    {"kind": "box", "half_extents": [0.5, 0.1, 0.3]},
    {"kind": "capsule", "radius": 0.1, "half_length": 0.4},
    {"kind": "cylinder", "radius": 0.3, "half_length": 0.2},
]
SWING = {
    "kind": "pendulum", "pivot": [0.5, 0.2, 2.0], "axis": [0.0, 1.0, 0.0], "down": [0.0, 0.0, -1.0],
    "length": 1.1, "gravity": 9.81, "angle": 1.2, "rate": -2.0, "damping": 0.3, "hang": 0.9,
}  # fmt: skip


def still(position, **more):
    """A quadratic motion that rests but for what is given."""
    motion = {"kind": "quadratic", "position": [float(x) for x in position]}
    return motion | {"velocity": ZERO, "acceleration": ZERO} | more


def body(role, name, shape, motion, **more):
    return {"role": role, "name": name, "shape": shape, "motion": motion} | more


def law(rng, kind):
    """A random law of motion about the arm."""
    if kind == "pendulum":
        axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        return SWING | {
            "pivot": rng.normal(size=3).tolist(), "axis": axes[0].tolist(),
            "down": axes[1].tolist(), "angle": rng.uniform(-2, 2), "rate": rng.normal(0, 3),
            "hang": rng.uniform(0.0, 2.0),
        }  # fmt: skip
    turn = rng.normal(size=4)
    motion = still(rng.normal(size=3) * 1.5, orientation=(turn / np.linalg.norm(turn)).tolist())
    for name, most in (("velocity", 2.0), ("acceleration", 3.0), ("spin", 4.0)):
        motion[name] = rng.normal(0.0, most, 3).tolist()
    return motion


def changed(given, path, to):
    """A copy of an object with one value replaced or added."""
    given = copy.deepcopy(given)
    place = given
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = to
    return given
