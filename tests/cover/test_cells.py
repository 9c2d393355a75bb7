"""The largest cells that are proven: what holds at their corners, and what breaks beyond them.

Each family has one thing that ends its cells: a limit, the grasp, or an obstacle.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import pytest

from gcm_learn.arms import Arm, forward, forward_in_space, joints_of
from gcm_learn.cover.catches import StoredCatch, doubt_of
from gcm_learn.cover.families import Parameter, ParametricFamily
from gcm_learn.cover.kinds import BENDING, stray
from gcm_learn.cover.limits import elbow_rates, hand_speeds, turn_bounds
from gcm_learn.motion import rules_of, verify
from gcm_learn.scene import pack
from gcm_learn.situation import Body, Disc, PlanarQuadratic, Situation, SolidQuadratic, Sphere
from tests.spatial import TURNED, TWO_BONES

END = 0.8  # of movements [s]
PLANAR = Arm((1.2, 0.3), 3.0, thickness=0.02, grasp=0.02)
GOAL = (0.9, 1.0)


def parameter(body, law, change, most):
    """Return a parameter that moves a body."""
    return Parameter(body, -most, most, "", ((body, law, change),))


def family(arm, *parameters, goal=GOAL, post=(5.0, 5.0), pace=(0.0, 0.0), samples=60, gain=1.0):
    """Return a family with a target and an obstacle, and a catch in its middle.

    The hand or the joints go straight to the target, whose places the parameters change.
    """
    zero = (0.0,) * len(goal if isinstance(arm, Arm) else TWO_BONES.upper_arm)
    if isinstance(arm, Arm):
        shape, law, first, last = Disc(0.02), PlanarQuadratic, np.array(arm.hand), np.array(goal)
        target = goal
    else:
        shape, law, first, last = Sphere(0.02), SolidQuadratic, np.array(arm.joints), goal
        target = tuple(forward_in_space(arm, goal)[1].tolist())
        post, pace = (*post, 0.0)[:3], (*pace, 0.0)[:3]
    bodies = (
        Body("target", "part", shape, law(target, zero, zero)),
        Body("obstacle", "post", shape, law(post, pace, zero)),
    )
    made = ParametricFamily("cells", "", Situation("cells", 1.0, arm, bodies), parameters)
    time, share = np.linspace(0.0, END, samples), np.linspace(0.0, 1.0, samples)
    way = first + share[:, None] * (last - first)
    scene = pack(made.middle)
    drift = np.zeros((len(parameters), 3))
    drift[:, : len(target)] = made.drifts(time[-1:])[0, :, 0]
    rule = gain * BENDING.of(scene).inverse(scene, way[-1]) @ drift.T
    return made, StoredCatch(made.centre, time, way, share, rule, 0)


def doubt(made, catch, share):
    """Return the doubt about a cell that has a share of the box's sides."""
    half = 0.5 * share * (made.high - made.low)
    return doubt_of(made, catch, made.centre, half, pack(made.middle))


def holds(made, catch, share):
    """Return whether the catch is verified in all corners of such a cell."""
    half = 0.5 * share * (made.high - made.low)
    for signs in product((-1.0, 1.0), repeat=len(half)):
        theta = made.centre + half * np.array(signs)
        scene = pack(made.situation(theta))
        if not verify(scene, rules_of(scene), catch.movement(made, theta), catch.body).good:
            return False
    return True


def largest(made, catch, reason):
    """Return the largest share that is proven; beyond it there is a certain doubt."""
    low, high = 0.0, 1.0
    while high - low > 1e-6 * high:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if doubt(made, catch, middle) is None else (low, middle)
    assert doubt(made, catch, high).reason == reason
    return low


X, Y = (1.0, 0.0), (0.0, 1.0)
TURN: dict[str, Any] = {"goal": TURNED}
POST = {"post": (1.52, 0.0, -0.9)}
RANGE = TWO_BONES.joint_range
AT_END = (0.9, 1.1)
CASES = {
    "hand speed": (1.5, replace(PLANAR, max_hand_speed=1.0), parameter("part", "position", Y, 0.5)),
    "hand deviates": (1.5, PLANAR, parameter("part", "position", Y, 0.5), {"post": AT_END}),
    "both deviate": (
        2.0, PLANAR, parameter("part", "position", Y, 0.5), parameter("part", "position", X, 0.5),
        {"post": (0.98, 1.06)},
    ),
    "post is moved": (1.5, PLANAR, parameter("post", "position", Y, 0.5), {"post": AT_END}),
    "post moves": (1.5, PLANAR, parameter("post", "velocity", Y, 0.5), {"post": AT_END}),
    "post and part move": (
        1.5, PLANAR, parameter("post", "velocity", Y, 0.5), parameter("part", "position", Y, 0.5),
        {"post": AT_END},
    ),
    "bullet is moved": (
        1.5, PLANAR, parameter("post", "position", X, 1.0), {"post": (1.6, -0.8), "pace": (0, 8)},
    ),
    "joint speed of the shoulder": (
        3.0, replace(PLANAR, max_joint_speed=(1.05, 9.0)), parameter("part", "position", Y, 0.5),
    ),
    "joint speed of the elbow": (
        1.5, replace(PLANAR, max_joint_speed=(9.0, 1.0)), parameter("part", "position", X, 0.5),
        {"goal": (1.6, 0.4)},
    ),
    "reach": (0.0, PLANAR, parameter("part", "position", Y, 0.5), {"samples": 27}),
    "grasp": (1.5, PLANAR, parameter("part", "position", Y, 0.5), {"gain": 0.0}),
    "grasp of two": (
        1.5, PLANAR, parameter("part", "position", Y, 0.5), parameter("part", "position", X, 0.5),
        {"gain": 0.0},
    ),
}  # fmt: skip
Y_BACK = (0.0, -1.0)
CASES |= {  # what two parameters do adds up, even if they do the opposite
    "grasp of opposites": (
        1.5, PLANAR, parameter("part", "position", Y, 0.5),
        parameter("part", "position", Y_BACK, 0.5), {"gain": 0.0},
    ),
    "hand deviates by opposites": (
        1.5, PLANAR, parameter("part", "position", Y, 0.5),
        parameter("part", "position", Y_BACK, 0.5), {"post": AT_END},
    ),
    "post is moved by opposites": (
        1.5, PLANAR, parameter("post", "position", Y, 0.5),
        parameter("post", "position", Y_BACK, 0.5), {"post": AT_END},
    ),
}  # fmt: skip
SLOW = replace(TWO_BONES, max_joint_speed=(0.55, 9.0, 9.0, 9.0))
ALONG = (0.0, 0.0, 1.0)
CASES |= {
    "joint speed of a turn": (1.5, SLOW, parameter("part", "position", ALONG, 0.5), TURN),
    "joint range of high ends": (
        1.5, replace(TWO_BONES, joint_range=((-3.0, 0.45), *RANGE[1:])),
        parameter("part", "position", ALONG, 0.5), TURN,
    ),
    "joint range of low ends": (
        1.5, replace(TWO_BONES, joint_range=((-0.45, 3.0), *RANGE[1:])),
        parameter("part", "position", ALONG, 0.5), {"goal": TURNED * (-1.0, 1.0, 1.0, 1.0)},
    ),
    "hand speed in space": (
        0.0, replace(TWO_BONES, max_hand_speed=1.5),
        parameter("part", "position", ALONG, 0.5), TURN,
    ),
    "grasp of bent rules": (4.0, TWO_BONES, parameter("part", "position", ALONG, 0.5), TURN),
    "grasp of stiff rules": (
        1.5, TWO_BONES, parameter("part", "position", ALONG, 0.5), TURN | {"gain": 0.0},
    ),
    "grasp of opposites in space": (
        1.5, TWO_BONES, parameter("part", "position", ALONG, 0.5),
        parameter("part", "position", (0.0, 0.0, -1.0), 0.5), TURN | {"gain": 0.0},
    ),
    "post in space": (3.0, TWO_BONES, parameter("part", "position", ALONG, 0.5), TURN | POST),
    "post is moved in space": (
        1.5, TWO_BONES, parameter("post", "position", ALONG, 0.5), TURN | POST,
    ),
}  # fmt: skip
KNOWN = "hand speed", "joint speed", "joint range", "reach", "grasp"


@pytest.mark.parametrize("name", CASES)
def test_corners_of_the_largest_cell_hold_and_those_of_larger_ones_do_not(name):
    factor, arm, *parameters = CASES[name]
    more = parameters.pop() if isinstance(parameters[-1], dict) else {}
    made, catch = family(arm, *parameters, **more)
    reason = next((reason for reason in KNOWN if name.startswith(reason)), "clearance")
    share = largest(made, catch, reason)
    assert share > 1e-3 and factor * share < 1.0
    assert holds(made, catch, share) and not (factor and holds(made, catch, factor * share))


@pytest.mark.parametrize("rho", [0.7, 1.0, 1.6])
def test_hands_stray_by_their_bound_and_no_more(rho):
    """Two joints that turn evenly the same way take a stretched arm farthest from the chord."""
    most = 0.0
    for first, second, elbow in product((-0.01, 0.0, 0.02), (-0.03, 0.0, 0.02), (0.0, 0.7, 2.0)):
        joints = np.array(
            [(0.0, elbow), (0.5 * first, elbow + 0.5 * second), (first, elbow + second)]
        )
        hand = forward(joints, rho)
        away = np.linalg.norm(hand[1] - 0.5 * (hand[0] + hand[2]))
        bound = stray(np.abs([[first, second]]), rho)[0]
        assert away <= bound * (1.0 + 1e-3)
        most = max(most, away / max(bound, 1e-30))
    assert most > 0.999


def steps_about(places):
    """Return both ends (n, 2, 2) of small steps in all directions at places (m, 2)."""
    angle = np.linspace(0.0, np.pi, 25)
    step = 1e-6 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    ends = places[:, None, None] + np.array((-1.0, 1.0))[:, None] * step[:, None]
    return ends.reshape(-1, 2, 2)


def turns_at(places, rho):
    """Return the largest turns (2,) of shoulder and elbow for a unit of the hand's way."""
    joints = joints_of(steps_about(places).reshape(-1, 2), rho, 1.0).reshape(-1, 2, 2)
    turns = (np.diff(joints, axis=1)[:, 0] + np.pi) % (2.0 * np.pi) - np.pi
    return np.abs(turns).max(axis=0) / 2e-6


@pytest.mark.parametrize("rho", [0.6, 1.0, 1.7])
def test_turns_are_bounded_on_whole_pieces(rho):
    """The pieces are long, or the hand is far off a short one; it may be so in any direction."""
    angle = np.linspace(-np.pi, np.pi, 32, endpoint=False)
    about = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    middle = np.array((0.0, 0.5 * (abs(rho - 1.0) + rho + 1.0)))
    for piece in ((0.3, 0.0), (0.0, 0.3), (0.0, 0.0)):
        hand = middle + np.outer((-1.0, 1.0), piece)
        far = np.array((0.0, 0.0 if any(piece) else 0.3))
        share = np.linspace(0.0, 1.0, 5)[:, None, None]
        places = hand[0] + share * (hand[1] - hand[0]) + far[1] * about
        bound, seen = turn_bounds(hand, far, rho)[0], turns_at(places.reshape(-1, 2), rho)
        assert (seen <= bound * (1.0 + 1e-4)).all() and (seen > 0.5 * bound).all()


@pytest.mark.parametrize("rho", [0.6, 1.0, 1.7])
@pytest.mark.parametrize("share", [0.05, 0.3, 0.6, 0.95])
def test_turns_at_either_end_of_the_radii_are_bounded_tightly(rho, share):
    """Where all radii are nearly the same, the bound is the largest turn."""
    near, far = abs(rho - 1.0) + 0.01, rho + 0.99
    for width in (1e-3, 0.2, 0.6):
        low = near + share * (far - near - width)
        places = np.linspace(low, low + width, 25)[:, None] * (1.0, 0.0)
        bound, seen = np.array(elbow_rates(low, low + width, rho)), turns_at(places, rho)
        assert (seen <= bound * (1.0 + 1e-4)).all()
        assert width > 1e-3 or (seen > 0.85 * bound).all()
    assert elbow_rates(near - 0.02, 1.0, rho)[0] == elbow_rates(1.0, far + 0.02, rho)[0] == 1e300


def test_hands_are_as_fast_as_bounds_say_and_no_faster():
    limb, rng = pack(family(TWO_BONES, goal=TURNED)[0].middle).limb, np.random.default_rng(2)
    for joint in range(5):
        rates = np.ones(4) if joint == 4 else np.eye(4)[joint]
        bound, most = hand_speeds(limb, rates[None])[0], 0.0
        for q in rng.uniform(-np.pi, np.pi, (400, 4)):
            moved = q + 1e-6 * rates * rng.choice((-1.0, 1.0), 4)
            ends = [forward_in_space(TWO_BONES, one)[1] for one in (q, moved)]
            most = max(most, float(np.linalg.norm(ends[1] - ends[0]) / 1e-6))
        assert 0.75 * bound < most <= bound * (1.0 + 1e-4)
