"""The paper's scenes in space: its falling ball and its pendulum, without the plane of the arm.

The bodies move as in the planar scenes (`families.paper`), and the numbers that the paper does not
give are the same, too.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from gcm_learn.arms import SpatialArm
from gcm_learn.families import paper
from gcm_learn.families.space.arms import HUMAN, NAO, arm_of
from gcm_learn.situation import Body, Box, Capsule, Situation, SolidQuadratic, Sphere

RAISED = (-0.32, 0.59, -1.01, -1.8)  # [rad] chosen: the hand is where it is in the plane
HANGING = (1.5, 0.1, -1.2, -0.05)  # [rad] chosen: the arm hangs down behind the box


def fig5_space() -> Situation[SpatialArm]:
    """A ball falls past a fixed bar (Fig. 5), before the human-like arm.

    Bar, ball, gravity and the limit of the hand's speed are as in the plane. The bar ends to
    either side, so that there is a way round its ends as well.
    """
    arm = replace(arm_of(HUMAN, np.array(RAISED)), max_hand_speed=paper.HAND_SPEED)
    planar = paper.fig5()
    return Situation("fig5-space", planar.horizon, arm, planar.bodies)


def fig8_space() -> Situation[SpatialArm]:
    """The pendulum experiment (Figs. 7 and 8) with NAO's left arm, in metres about its shoulder.

    The arm hangs down behind the box; the ball swings past over it. The hand has to be led up along
    the box, and round its edge.
    """
    swing = paper.pendulum_of(1.0, NAO.height)
    depth, width, height = paper.BOX_SIZE
    middle = (paper.BOX_DISTANCE + depth / 2, 0.0, height / 2 - NAO.height)
    radius, pivot = paper.BALL_DIAMETER / 2, swing(0.0)
    cord = pivot.length - radius
    box = SolidQuadratic(middle, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    bodies = (
        Body("target", "ball", Sphere(radius), swing(pivot.length)),
        Body("obstacle", "cord", Capsule(paper.CORD_RADIUS, cord / 2), swing(cord / 2)),
        Body("obstacle", "box", Box((depth / 2, width / 2, height / 2)), box),
    )
    return Situation("fig8-space", 1.2, arm_of(NAO, np.array(HANGING)), bodies)


SPATIAL_SCENES: dict[str, Callable[[], Situation[SpatialArm]]] = {
    "fig5-space": fig5_space,
    "fig8-space": fig8_space,
}
