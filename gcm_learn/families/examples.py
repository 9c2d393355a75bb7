"""Situations beyond the paper's, each made to show one thing."""

from __future__ import annotations

import math

from gcm_learn.arms import Arm, SpatialArm
from gcm_learn.families.paper import HAND_SPEED
from gcm_learn.situation import (
    Body,
    Capsule,
    Disc,
    PlanarQuadratic,
    Polygon,
    Situation,
    SolidQuadratic,
    Sphere,
)

GATE = (1.6, 0.05)  # half length and half width [forearms]
GATE_SPEED = 3.3  # [forearms/s] about the hand's
GATE_LEAN = 0.15  # [rad] from the direction in which it slides
SOON = 1.1  # [s] too soon for a way round the gate


def gate_scene() -> Situation:
    """A gate that opens: a long bar slides off from between the hand and a ball.

    Until about 0.7 s no way leads through, and a front that comes to the bar before freezes there
    for good. The rest of the front goes round the bar's upper end, which takes longer than the
    situation lasts. A hand that waits beside the bar until its end has passed catches the ball.
    All numbers are chosen.
    """
    length, width = GATE
    bar = Polygon(((-length, -width), (length, -width), (length, width), (-length, width)))
    slide = PlanarQuadratic(
        (1.0, 0.8), (0.0, -GATE_SPEED), (0.0, 0.0), 0.5 * math.pi + GATE_LEAN
    )  # fmt: skip
    flight = PlanarQuadratic((1.7, -0.6), (-0.1, 0.5), (0.0, 0.0))
    return Situation(
        "gate",
        SOON,
        Arm((0.1, -1.3), HAND_SPEED),
        (Body("target", "ball", Disc(0.08), flight), Body("obstacle", "gate", bar, slide)),
    )


def thrown_scene() -> Situation[SpatialArm]:
    """A ball is thrown to an arm in space, and a post comes between.

    The arm is like a human's, its shoulder at the origin and z upwards. On the straight
    line in the joints the forearm would run into the post. All numbers are chosen.
    """
    arm = SpatialArm(
        upper_arm=(1.0, 0.0, 0.0),
        forearm=(1.0, 0.0, 0.0),
        joints=(1.0, -0.3, 0.2, -0.5),
        joint_range=((-2.8, 2.0), (-0.6, 2.2), (-2.4, 2.4), (-2.6, 0.0)),
        max_joint_speed=(5.0, 5.0, 7.0, 7.0),
        max_hand_speed=5.0,
        thickness=0.09,
        grasp=0.1,
    )
    still = (0.0, 0.0, 0.0)
    flight = SolidQuadratic((1.6, 2.1, 0.3), (-0.7, -0.7, 1.7), (0.0, 0.0, -3.0))
    post = SolidQuadratic((1.1, -0.1, -0.4), (-0.8, 0.8, 0.0), still)
    return Situation(
        "thrown-ball",
        1.0,
        arm,
        (
            Body("target", "ball", Sphere(0.12), flight),
            Body("obstacle", "post", Capsule(0.13, 0.75), post),
        ),
    )
