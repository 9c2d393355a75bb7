"""Sides on which a way passes bodies: signs, symmetry, and what a deformation cannot change."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn.arms import Arm
from gcm_learn.motion.movement import Movement
from gcm_learn.recall.waypoints import NEAR, passing, passing_of
from gcm_learn.situation import Body, Disc, PlanarQuadratic, Situation
from gcm_learn.situation.canonical import canonical
from tests.transforms import mirrored, turned

STILL = (0.0, 0.0)


def among(*obstacles):
    """An arm that reaches from right to left, with discs at (place, velocity) around."""
    bodies = [Body("target", "ball", Disc(0.05), PlanarQuadratic((-1.2, 0.9), STILL, STILL))]
    for k, (place, velocity) in enumerate(obstacles):
        motion = PlanarQuadratic(place, velocity, STILL)
        bodies.append(Body("obstacle", f"disc {k}", Disc(0.05), motion))
    return Situation("among", 1.0, Arm((1.2, 0.9), 4.0), tuple(bodies))


def straight(bend=0.0, duration=0.8, n=60):
    """From (1.2, 0.9) to (-1.2, 0.9), aside by `bend` in the middle."""
    s = np.linspace(0.0, 1.0, n)
    hand = np.stack([1.2 - 2.4 * s, 0.9 + bend * np.sin(np.pi * s)], axis=1)
    return Movement.of_hand(Arm((1.2, 0.9), 4.0), s * duration, hand)


def test_a_hand_that_goes_left_has_what_is_above_on_its_right():
    above = passing(among(((0.0, 1.1), STILL)), straight())
    assert above.sides == "r"
    both = passing(among(((-0.3, 1.1), STILL), ((0.3, 0.75), STILL)), straight())
    assert both.sides == "lr" and both.when[1] < both.when[0]


def test_far_bodies_and_bodies_beyond_the_ends_are_not_passed():
    far = passing(among(((0.0, 0.9 + NEAR + 0.8), STILL)), straight())
    assert far.sides == "" and far.clearance[0] > NEAR
    beyond = passing(among(((-1.35, 1.0), STILL)), straight())
    assert beyond.sides == "" and abs(beyond.turn[0]) < 0.5 * np.pi


def test_a_deformation_that_touches_nothing_changes_no_turn():
    situation = among(((0.0, 1.2), STILL))
    turns = [passing(situation, straight(bend)).turn[0] for bend in (-0.4, 0.0, 0.2)]
    np.testing.assert_allclose(turns, turns[0], atol=1e-9)
    across = passing(situation, straight(0.7)).turn[0]
    assert across - turns[0] == pytest.approx(2.0 * np.pi)


def test_before_and_behind_a_moving_body_are_two_sides():
    situation = among(((0.0, 0.2), (0.0, 1.4)))  # it crosses the way at 0.5 s
    first, later = straight(duration=0.7), straight(duration=1.3)
    before, behind = passing(situation, first).turn[0], passing(situation, later).turn[0]
    assert before > 0.5 * np.pi and behind < -0.5 * np.pi


def test_sides_turn_and_mirror_with_the_situation(catches, traces):
    seen = 0
    for (situation, plan), trace in list(zip(catches, traces, strict=True))[:80]:
        there = passing(situation, plan.trajectory)
        flip = np.diag([1.0, -1.0])
        flipped = mirrored(situation)
        way = plan.trajectory
        other = Movement.of_hand(flipped.arm, way.time, way.hand @ flip)
        here = passing(flipped, replace(other, joints=way.joints))
        np.testing.assert_allclose(here.turn, there.turn, atol=1e-9)
        c, s = np.cos(1.1), np.sin(1.1)
        about = Movement.of_hand(situation.arm, way.time, way.hand @ np.array([[c, s], [-s, c]]))
        np.testing.assert_allclose(
            passing(turned(situation, 1.1), about).turn, there.turn, atol=1e-9
        )
        kept = passing_of(canonical(situation)[0], trace)
        assert kept.sides == there.sides
        seen += there.sides != ""
    assert seen > 10
