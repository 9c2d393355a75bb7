"""Builders of what tests ask about: bodies and situations as records, and bodies as JSON."""

import copy
from dataclasses import replace

import numpy as np

from gcm_learn import situation
from gcm_learn.arms import Arm, Chain

REST = (0.0, 0.0, 0.0)
READY = (0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785)
"""A posture of a Panda with its hand before it, downwards."""


def panda(grasp=0.03, posture=READY, **limits):
    """A Panda."""
    return Chain(situation.shipped_arm("panda"), posture, grasp, **limits)


def flight(place, velocity=REST, acceleration=REST, **turns):
    """The motion of a solid that flies; without velocity and acceleration it rests."""
    return situation.SolidQuadratic(tuple(place), tuple(velocity), tuple(acceleration), **turns)


def solid_ball(name, place, velocity=REST, role="obstacle", radius=0.02, **more):
    """A ball in space that flies straight on or rests."""
    return situation.Body(role, name, situation.Sphere(radius), flight(place, velocity), **more)


def disc(name, place, velocity=(0.0, 0.0), role="obstacle", radius=0.2, acceleration=(0.0, 0.0)):
    """A disc in the plane that flies or rests."""
    return situation.Body(
        role, name, situation.Disc(radius), situation.PlanarQuadratic(place, velocity, acceleration)
    )


def among(arm, *bodies, horizon=1.0, name="among", **more):
    """An arm among bodies; its target is far away unless one is given."""
    if not any(body.role == "target" for body in bodies):
        planar = isinstance(arm, Arm)
        far = disc("far", (9.0, 0.0)) if planar else solid_ball("far", (9.0, 9.0, 9.0), radius=0.1)
        bodies = (*bodies, replace(far, role="target"))
    return situation.Situation(name, horizon, arm, bodies, **more)


def pick():
    """A ball on a belt, which a Panda holds and carries to a place."""
    hold, place = situation.Hold(0.2, 0.05), situation.Place((0.3, 0.4, 0.4), 0.02)
    ball = solid_ball("b", (0.5, -0.4, 0.2), (0.0, 0.3, 0.0), "target")
    ball = replace(ball, hold=hold, place=place)
    arm = panda(max_joint_acceleration=(15, 7.5, 10, 12.5, 15, 20, 20))
    return among(arm, ball, horizon=2.0, end="rest")


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
