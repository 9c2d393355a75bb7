"""Bounds of proofs beside sampled truth: never above it, and near it where one term decides."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest

from gcm_learn.arms import Arm, SpatialArm
from gcm_learn.cover.reaching import ITSELF, NOWHERE, Work, first_touch, room_of
from gcm_learn.scene import pack
from gcm_learn.situation import (
    Body,
    Disc,
    PlanarQuadratic,
    Situation,
    SolidQuadratic,
    Sphere,
    situation_from_json,
    situation_to_json,
)
from tests.chains import MODELS
from tests.geometry import arm_of, links_of, segments_apart
from tests.planar_geometry import elbow_of

INSTANTS = np.linspace(0.0, 1.0, 801)
PLANAR = Arm((1.2, 0.3), 3.0, thickness=0.02, grasp=0.05)
SPATIAL = SpatialArm(
    upper_arm=(1.0, 0.0, 0.0),
    forearm=(0.8, 0.0, 0.0),
    joints=(0.0, 0.0, 0.0, 0.4),
    joint_range=((-3.0, 3.0),) * 4,
    max_joint_speed=(4.0,) * 4,
    grasp=0.1,
    thickness=0.05,
)
POSTURE = np.array((0.0, 0.0, 0.0, 0.4))


def planar(*obstacles, arm=PLANAR):
    """Return a situation with discs of radius 0.05 at places, with velocities."""
    discs = tuple(
        Body("obstacle", f"disc {k}", Disc(0.05), PlanarQuadratic(place, velocity, (0.0, 0.0)))
        for k, (place, velocity) in enumerate(obstacles)
    )
    target = Body("target", "part", Disc(0.05), PlanarQuadratic((9.0, 9.0), (0, 0), (0, 0)))
    return Situation("bounds", 1.5, arm, (target, *discs))


def spatial(*obstacles):
    """Return a situation with balls of radius 0.05 at places, with velocities."""
    balls = tuple(
        Body("obstacle", f"ball {k}", Sphere(0.05), SolidQuadratic(place, velocity, (0.0,) * 3))
        for k, (place, velocity) in enumerate(obstacles)
    )
    target = Body(
        "target", "part", Sphere(0.05), SolidQuadratic((9.0,) * 3, (0.0,) * 3, (0.0,) * 3)
    )
    return Situation("bounds", 1.5, SPATIAL, (target, *balls))


def chain(*pairs, balls=()):
    """Return a situation of a chain and balls; pairs of its links must not overlap."""
    given = {"kind": "chain", "model": MODELS["slide"] | {"self_collision": pairs}, "grasp": 0.03}
    given["posture"] = [0.0, 0.3, 0.0]
    bodies = [
        {
            "role": role,
            "name": f"ball {k}",
            "shape": {"kind": "sphere", "radius": 0.05},
            "motion": {
                "kind": "quadratic",
                "position": list(place),
                "velocity": list(velocity),
                "acceleration": [0.0] * 3,
            },
        }
        for k, (role, place, velocity) in enumerate(
            [("target", (9.0,) * 3, (0.0,) * 3), *(("obstacle", *ball) for ball in balls)]
        )
    ]
    about = {"format": "gcm-learn/situation@3", "name": "bounds", "horizon": 1.5}
    return situation_from_json(about | {"arm": given, "bodies": bodies})


def axes_of(situation, places):
    """Ends (links, 2, n, 2 or 3) of the links' axes at places (n, m), and radii (links,)."""
    if isinstance(situation.arm, Arm):
        elbow = elbow_of(situation.arm, places)
        return np.array([[0.0 * elbow, elbow], [elbow, places]]), np.zeros(2)
    ends, radii = links_of(arm_of(situation_to_json(situation)["arm"]), places)
    return ends, radii - getattr(situation.arm, "thickness", 0.0)


def apart(points, a, b):
    """Distances (n,) of points to segments."""
    along = b - a
    share = ((points - a) * along).sum(axis=1) / np.maximum((along**2).sum(axis=1), 1e-30)
    return np.linalg.norm(points - a - np.clip(share, 0.0, 1.0)[:, None] * along, axis=1)


def gaps(situation, places, t, pairs=()):
    """Least distances (n,) of axes and obstacles, and of pairs of links, at places (n, m) and t."""
    ends, radii = axes_of(situation, places)
    found = [segments_apart(*ends[i], *ends[j]) - radii[i] - radii[j] for i, j in pairs]
    for body in situation.obstacles:
        motion = body.motion
        centre = np.array(motion.position) + t[:, None] * np.array(motion.velocity)
        found += [apart(centre, *ends[i]) - radii[i] - 0.05 for i in range(len(radii))]
    return np.min(found, axis=0)


def truth(situation, moves, off, pairs=()):
    """Least sampled distance over all deviations, and the same without any."""
    time, way, away = moves
    least, plain, columns = np.inf, np.inf, range(way.shape[1])
    for k in range(time.size - 1):
        s, t = INSTANTS[:, None], time[k] + INSTANTS * (time[k + 1] - time[k])
        middle = way[k] + s * (way[k + 1] - way[k])
        wide = away[k] + s * (away[k + 1] - away[k])
        nearer = off[k] + INSTANTS * (off[k + 1] - off[k])
        plain = min(plain, gaps(situation, middle, t, pairs).min())
        for signs in product(*((-1.0, 0.0, 1.0) if wide[:, j].any() else (0.0,) for j in columns)):
            found = gaps(situation, middle + wide * np.array(signs), t, pairs) - nearer
            least = min(least, found.min())
    return least, plain


def proven(situation, moves, off):
    """Return the largest distance that is proven to be kept, and the body that is met beyond it."""
    scene, low, high, met = pack(situation), -1.0, 3.0, NOWHERE
    offs = np.zeros((moves[0].size, len(situation.bodies)))
    offs[:, 1:] = np.array(off)[:, None]
    while high - low > 4e-6:
        middle = 0.5 * (low + high)
        body, _ = first_touch(scene, moves, offs, middle)
        low, high = (middle, high) if body == NOWHERE else (low, middle)
        met = met if body == NOWHERE else body
    return low, met


REST, STILL, HAND = (0.0, 0.0), (0.0, 0.0, 0.0), PLANAR.hand
SHORT, LONG = Arm((1.2, 0.3), 3.0, upper_arm=0.5), Arm((2.3, 0.0), 3.0, upper_arm=1.6)
STRETCHED = Arm((1.95, 0.0), 3.0)


def rests(hand, times=2):
    """Return a way that stays."""
    return [hand] * times


# obstacles, way, deviations, what bodies may be off, and the arm
PLANE = {
    "nothing moves, upper arm": ([((0.2, 0.3), REST)], rests(HAND), 0.0, 0.0),
    "nothing moves, forearm": ([((1.4, 0.0), REST)], rests(HAND), 0.0, 0.0),
    "the nearest is the last": ([((2.9, 0.0), REST), ((1.4, 0.4), REST)], rests(HAND), 0.0, 0.0),
    "body passes at the begin": ([((1.4, -0.1), (0.0, 20.0))], rests(HAND), 0.0, 0.0),
    "body passes at the end": ([((1.4, -19.1), (0.0, 20.0))], rests(HAND), 0.0, 0.0),
    "body passes in the last piece": ([((1.4, -17.1), (0.0, 20.0))], rests(HAND, 4), 0.0, 0.0),
    "hand passes early": ([((1.235, 0.518), REST)], [HAND, (0.6, 1.2)], 0.0, 0.0),
    "hand passes late": ([((0.78, 1.2), REST)], [HAND, (0.6, 1.2)], 0.0, 0.0),
    "hand deviates along x": ([((1.55, 0.3), REST)], rests(HAND), ((0, 0), (0.2, 0)), 0.0),
    "hand deviates along y": ([((1.25, 0.7), REST)], rests(HAND), ((0, 0), (0, 0.2)), 0.0),
    "hand deviates on its way back": (
        [((1.42, 0.3), REST)], [HAND, (0.6, 0.3)], ((0.1, 0), (0.1, 0)), 0.0,
    ),
    "hand of a short upper arm deviates": (
        [((1.55, 0.3), REST)], rests(SHORT.hand), ((0, 0), (0.2, 0)), 0.0, SHORT,
    ),
    "elbow deviates, upper arm": (
        [((0.5, -0.35), REST)], rests(STRETCHED.hand), ((0, 0), (0.01, 0)), 0.0, STRETCHED,
    ),
    "elbow deviates, forearm": (
        [((1.2, -0.4), REST)], rests(STRETCHED.hand), ((0, 0), (0.01, 0)), 0.0, STRETCHED,
    ),
    "elbow of a long upper arm": (
        [((1.4, -0.82), REST)], rests(LONG.hand), ((0, 0), (0.05, 0)), 0.0, LONG,
    ),
    "body is off at the end": ([((1.45, 0.3), REST)], rests(HAND), 0.0, (0.0, 0.1)),
    "body is off at the begin": ([((1.45, 0.3), REST)], rests(HAND), 0.0, (0.1, 0.0)),
}  # fmt: skip


def moves_of(way, away):
    """Return times, way and deviations in arrays."""
    way = np.array(way, dtype=float)
    return np.linspace(0.0, 1.0, len(way)), way, np.zeros_like(way) + np.array(away, dtype=float)


def agrees(situation, moves, off, pairs=()):
    """Check that what is proven is below the truth, and loses at most thrice what deviations do."""
    off = np.zeros(moves[0].size) + np.array(off)
    least, plain = truth(situation, moves, off, pairs)
    bound, met = proven(situation, moves, off)
    assert bound <= least + 1e-5
    assert plain - bound <= 3.0 * (plain - least) + 2e-3
    assert met == (ITSELF if pairs else len(situation.bodies) - 1)


@pytest.mark.parametrize("name", PLANE)
def test_what_is_proven_of_a_planar_arm_is_true(name):
    obstacles, way, away, off, *arm = PLANE[name]
    agrees(planar(*obstacles, arm=(arm or [PLANAR])[0]), moves_of(way, away), off)


def beyond(places, gap):
    """Return a place beyond where the hand of the spatial arm gets on a way."""
    hands = axes_of(spatial(), np.array(places))[0][1, 1]
    ahead = hands[-1] - hands[0]
    return tuple(hands[-1] + gap * ahead / np.linalg.norm(ahead))


@pytest.mark.parametrize("begin", [0.02, 0.97])
def test_what_is_proven_of_a_passing_ball_is_true(begin):
    x, y, z = axes_of(spatial(), POSTURE[None])[0][1, 1, 0]
    ball = ((x + 0.15, y, z - 20.0 * begin), (0.0, 0.0, 20.0))
    agrees(spatial(ball), moves_of(rests(POSTURE), 0.0), 0.0)


@pytest.mark.parametrize("joint", range(4))
def test_what_is_proven_of_deviating_joints_is_true(joint):
    there = 0.2 * np.eye(4)[joint]
    turned = POSTURE + (0.0, 0.0, 0.0, 0.5)  # so that no axis goes through the hand
    ball = spatial((beyond([turned, turned + there], 0.15), STILL))
    agrees(ball, moves_of(rests(turned), (0.0 * there, there)), 0.0)
    for sign in (-1.0, 1.0):  # on a way that leads away, the deviation counts from the begin on
        away = moves_of([turned, turned + 4.0 * sign * there], (there, there))
        agrees(spatial((beyond([turned, turned - sign * there], 0.15), STILL)), away, 0.0)


def test_what_is_proven_of_turning_joints_is_true():
    there = POSTURE + (0.0, 0.9, 0.0, 0.0)
    for share in (0.1, 0.9):
        way = [POSTURE, POSTURE + share * (there - POSTURE)]
        side = axes_of(spatial(), np.array(way))[0][1, 1, -1] * 1.1
        agrees(spatial((tuple(side), STILL)), moves_of([POSTURE, there], 0.0), 0.0)


@pytest.mark.parametrize("off", [(0.0, 0.1), (0.1, 0.0)])
def test_what_is_proven_of_balls_that_are_off_is_true(off):
    x, y, z = axes_of(spatial(), POSTURE[None])[0][1, 1, 0]
    agrees(spatial(((x + 0.25, y, z), STILL)), moves_of(rests(POSTURE), 0.0), off)


@pytest.mark.parametrize("joint", [1, 2])
def test_what_is_proven_of_links_is_true(joint):
    """Links come nearer as the chain moves in, or turns its last link to the first."""
    rest = np.array((0.0, 0.3, 0.0))
    there = (-0.1 if joint == 1 else 0.4) * np.eye(3)[joint]
    agrees(chain([0, 2]), moves_of(rests(rest), (0.0 * there, abs(there))), 0.0, [(0, 2)])
    agrees(chain([0, 2]), moves_of([rest, rest + there], 0.0), 0.0, [(0, 2)])


@pytest.mark.parametrize(("rho", "radius"), [(1.0, 1.9), (1.0, 0.2), (1.6, 0.72), (1.6, 2.5)])
def test_the_elbow_is_bounded_near_the_rims(rho, radius):
    """Near the rims of the ring the elbow turns the faster, the nearer the hand is to them."""
    far = 0.1
    arm = Arm((radius, 0.0), 3.0, upper_arm=rho)
    steps = far * np.stack(np.meshgrid(*[np.linspace(-1.0, 1.0, 21)] * 2)).reshape(2, -1).T
    for away in ((far, 0.0), (0.0, far), (far, far)):
        hands = np.array(arm.hand) + steps[(abs(steps) <= np.array(away) + 1e-12).all(axis=1)]
        middle = elbow_of(arm, np.array([arm.hand]))[0]
        for angle in np.linspace(0.0, 2.0 * np.pi, 32, endpoint=False):
            disc = tuple(middle + 0.8 * np.array((np.cos(angle), np.sin(angle))))
            situation = planar((disc, REST), arm=arm)
            work = Work(np.zeros((2, 12)), np.zeros((2, 4)), np.array(arm.hand), np.array(away))
            bound = room_of(pack(situation).limb, pack(situation), 1, 0.0, 0.0, 1e300, work)
            assert bound <= gaps(situation, hands, np.zeros(len(hands))).min() + 1e-9
