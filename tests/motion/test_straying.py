"""Both readings of a trajectory of the plane are one movement: the hand's and the joints'."""

from __future__ import annotations

import numpy as np

from gcm_learn.arms import Arm
from gcm_learn.motion import Failure, Movement, refine, rules_of, verify
from gcm_learn.scene import pack
from gcm_learn.situation import Body, Disc, PlanarQuadratic, Situation

START, END = (0.12, 0.3), (0.12, 0.1)
ARM = Arm(START, 3.0)
STILL = PlanarQuadratic(END, (0.0, 0.0), (0.0, 0.0))
SCENE = pack(Situation("near", 1.0, ARM, (Body("target", "ball", Disc(0.05), STILL),)))


def judged(time, hand):
    """The verdict on a hand's path to the ball."""
    moves = Movement.of_hand(ARM, time, hand)
    return moves, verify(SCENE, rules_of(SCENE), moves, 0)


def test_joints_that_lead_the_hand_astray_are_no_plan():
    """Near the shoulder joints turn far while the hand goes a little."""
    time, hand = np.linspace(0.0, 0.5, 4), np.linspace(START, END, 4)
    moves, verdict = judged(time, hand)
    assert np.abs(np.diff(moves.joints, axis=0)).max() < 0.5
    assert not verdict.good
    assert verdict.reason.failure is Failure.ASTRAY
    assert judged(*refine(ARM, time, hand))[1].good
