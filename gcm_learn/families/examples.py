"""Situations beyond the paper's, each made to show one thing."""

from __future__ import annotations

import math

from gcm_learn.families.paper import HAND_SPEED
from gcm_learn.situation import Arm, Body, Disc, PlanarQuadratic, Polygon, Situation

GATE = (1.6, 0.05)  # half length and half width [forearms]
GATE_SPEED = 3.3  # [forearms/s] about the hand's
GATE_LEAN = 0.15  # [rad] from the direction in which it slides
SOON = 1.1  # [s] too soon for a way round the gate


def gate_scene() -> Situation:
    """A gate that opens: a long bar slides off from between the hand and a ball.

    Until about 0.7 s no way leads through, and a front that comes to the bar before freezes there
    for good. What is left of it goes round the bar's upper end, which takes longer than the
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
