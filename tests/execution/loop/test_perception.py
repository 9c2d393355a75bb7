"""Percepts: exact without noise, errors of the given size, the same for the same seed."""

import math
from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import families, situation as records
from gcm_learn.execution import Perception
from gcm_learn.execution.loop.kinds import LEADS
from gcm_learn.rendering import body_poses
from gcm_learn.scene import bodies_later
from tests.worlds import REST, among, panda

NAMES = (
    "falling-space", "pendulum-space", "crossing-swarm-space", "door-space", "spinning", "pendulum",
    "random-solid",
)  # fmt: skip


@pytest.fixture(scope="module")
def situations():
    """Return situations with bodies that fly, swing, spin and rest."""
    return [families.draw(name, 1400, 0) for name in NAMES]


def test_a_look_is_told_when_it_is_late(situations):
    """Look k is of k - delay periods; before that, and after the horizon, nothing is told."""
    for delay in (0, 1, 3):
        eyes = Perception(delay=delay)
        told = [eyes.told(situations[0], k, 0) for k in range(6)]
        assert [percept is None for percept in told] == [k < delay for k in range(6)]
        assert [p.time for p in told if p] == [0.02 * k for k in range(6 - delay)]
    last = int(situations[0].horizon / 0.02) + 2
    assert Perception(delay=0).told(situations[0], last, 0) is None


@pytest.mark.parametrize("latency", [0.02, 0.05, 0.007])
def test_late_percepts_tell_an_older_world(situations, latency):
    """Bodies are where they were at the time that is told."""
    eyes = Perception(latency=latency)
    told = [(k, eyes.told(situations[0], k, 0)) for k in range(12)]
    assert [p is None for _, p in told] == [0.02 * (k - 1) < latency - 1e-12 for k, _ in told]
    for k, percept in told:
        if percept is None:
            continue
        assert percept.time == pytest.approx(0.02 * (k - 1) - latency)
        there = bodies_later(situations[0].bodies, percept.time)
        for seen, body in zip(percept.bodies, there, strict=True):
            assert seen.motion.position == pytest.approx(body.motion.position)


def test_without_noise_all_but_accelerations_are_seen_as_they_are(situations):
    for situation in situations:
        percept = Perception().told(situation, 8, 0)
        for seen, body in zip(
            percept.bodies, bodies_later(situation.bodies, percept.time), strict=True
        ):
            if not isinstance(body.motion, records.Pendulum):
                still = (0.0,) * len(body.motion.acceleration)
                body = replace(body, motion=replace(body.motion, acceleration=still))
            assert seen == body


def test_errors_are_as_large_as_said(situations):
    """Errors count in forearms of any arm, along the arc for pendulums; rest is exact."""
    eyes = Perception(place=0.03, faster=4.0)
    for situation in situations:
        forearm = LEADS.of(situation).forearm(situation.arm)
        told = [eyes.told(situation, 5, 7, k) for k in range(400)]
        for b, body in enumerate(bodies_later(situation.bodies, told[0].time)):
            motions = [percept.bodies[b].motion for percept in told]
            if isinstance(body.motion, records.Pendulum):
                off = np.array([m.angle - body.motion.angle for m in motions])
                fast = np.array([m.rate - body.motion.rate for m in motions])
                off, fast = off * body.motion.hang_distance, fast * body.motion.hang_distance
            else:
                off = np.array([m.position for m in motions]) - body.motion.position
                fast = np.array([m.velocity for m in motions]) - body.motion.velocity
            assert abs(off.std() / (0.03 * forearm) - 1.0) < 0.2
            assert abs(off.mean()) < 4.5 * 0.03 * forearm / math.sqrt(off.size)
            if told[0].rests[b]:
                assert not fast.any()
            else:
                assert abs(fast.std() / (0.12 * forearm) - 1.0) < 0.2


def test_errors_belong_to_seed_index_and_look(situations):
    """Whatever was asked before; and larger noise has the same errors, only larger."""
    eyes, situation = Perception(place=0.02, dropouts=2.0), situations[0]
    some = [eyes.told(situation, k, 3, 1) for k in range(20)]
    assert [eyes.told(situation, k, 3, 1) for k in reversed(range(20))] == some[::-1]
    assert eyes.told(situation, 19, 3, 2) != some[19]
    one = Perception(place=0.02).told(situation, 9, 3).bodies[0].motion.position
    two = Perception(place=0.04).told(situation, 9, 3).bodies[0].motion.position
    none = Perception().told(situation, 9, 3).bodies[0].motion.position
    assert np.allclose(np.subtract(two, none), 2.0 * np.subtract(one, none), rtol=1e-9)


def test_dropouts_take_a_tenth_of_a_second(situations):
    """They come as often as said, and last five looks or more where one follows the other."""
    eyes = Perception(dropouts=2.0)
    dark = np.array([eyes.dark(k, 5) for k in range(5000)])
    edges = np.diff(dark.astype(int))
    begins, ends = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
    lengths = [ends[ends > b][0] - b for b in begins if (ends > b).any()]
    assert min(lengths) == 5
    # five looks in a row without a dropout that begins
    assert abs(dark.mean() - (1.0 - 0.96**5)) < 0.03
    assert not any(Perception().dark(k, 5) for k in range(50))


WAY = records.Sampled((0.0, 0.3, 1.0), (REST, (1.0, 0.0, 0.0), (1.0, 0.5, 0.0)),
              ((1.0, 0.0, 0.0, 0.0), (0.8, 0.6, 0.0, 0.0), (0.6, 0.8, 0.0, 0.0)))  # fmt: skip
BOUNCES = records.Piecewise((
    records.Piece(0.0, records.SolidQuadratic((0.0, 0.0, 0.5), (1.0, 0.0, 0.0), (0.0, 0.0, -4.0))),
    records.Piece(0.5, records.SolidQuadratic((0.5, 0.0, 0.0), (1.0, 0.0, 1.5), (0.0, 0.0, -4.0))),
))  # fmt: skip


def known(motion):
    """A chain and a ball whose law is known but for where it lies."""
    ball = records.Body("target", "ball", records.Sphere(0.1), motion)
    return among(panda(0.05, (0.0, 0.0, 0.0, -1.0, 0.0, 1.0, 0.0)), ball, horizon=2.0)


@pytest.mark.parametrize("motion", [WAY, BOUNCES], ids=["sampled", "piecewise"])
def test_known_laws_are_seen_shifted_as_a_whole(motion):
    """At all later times by the same vector, also beyond a bounce; turns and speeds are exact."""
    situation, eyes, offs = known(motion), Perception(0.01, delay=0), []
    for look in range(40):
        percept = eyes.told(situation, look, 0)
        seen = replace(situation, bodies=percept.bodies)
        times = np.linspace(0.0, 0.9, 10)
        places, turns = body_poses(seen, times)
        there, turned = body_poses(situation, times + percept.time)
        off = places[:, 0] - there[:, 0]
        np.testing.assert_allclose(off, np.tile(off[0], (10, 1)), atol=1e-12)
        np.testing.assert_allclose(turns, turned, atol=1e-9)
        offs.append(off[0])
    forearm = 0.5 * situation.arm.reach
    assert np.std(offs) == pytest.approx(0.01 * forearm, rel=0.2) and percept.rests == (False,)
