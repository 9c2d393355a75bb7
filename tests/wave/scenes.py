"""Tasks for a front, and what its answers are compared by."""

from __future__ import annotations

import numpy as np

from gcm_learn.handspace.lattice import Lattice
from gcm_learn.scene.packing import pack_bodies
from gcm_learn.situation import Arm, Body, Disc, PlanarQuadratic, Situation
from gcm_learn.wave import Task, kappa_of

SPEED = 3.4  # kappa is about 1/400 s on 80 cells
STILL = (0.0, 0.0)


def disc(role, name, position, velocity=STILL, radius=0.1):
    return Body(role, name, Disc(radius), PlanarQuadratic(position, velocity, STILL))


def task_of(situation, n=80):
    """Make a front's task of a situation."""
    arm = situation.arm
    return Task(
        pack_bodies(situation),
        Lattice(n, arm.upper_arm, arm.elbow),
        arm.hand,
        arm.max_hand_speed,
        situation.horizon,
        arm.thickness,
        arm.grasp,
        joint_speed=arm.max_joint_speed,
    )


def scene(*bodies, hand=(1.2, 0.3), horizon=1.0, **arm):
    """Make a situation of some bodies; a target far away makes it valid."""
    far = disc("target", "far away", (9.0, 0.0))
    return Situation("scene", horizon, Arm(hand, SPEED, **arm), (*bodies, far))


def three_discs(rng, moving=True, **arm):
    """Draw three obstacles away from the hand and a target that may be met."""
    places = []
    while len(places) < 4:
        place = rng.uniform(-1.6, 1.6, size=2)
        if np.hypot(place[0] - 1.2, place[1] - 0.3) > 0.6 and np.hypot(*place) > 0.5:
            places.append(tuple(float(v) for v in place))
    velocities = rng.uniform(-1.5, 1.5, size=(4, 2)) * moving
    roles = ("target", "obstacle", "obstacle", "obstacle")
    bodies = (
        disc(role, f"{role} {k}", places[k], tuple(float(v) for v in velocities[k]))
        for k, role in enumerate(roles)
    )
    return scene(*bodies, **arm)


def arrival_tau(task, front, params):
    """Arrival times [tau], nan where the front never came."""
    return np.where(front.arrival >= 0.0, front.arrival / kappa_of(task, params), np.nan)


def away(task):
    """Distance (n, n) of every cell's centre from the hand [cells]."""
    x, y = np.meshgrid(task.lattice.centres, task.lattice.centres)
    return np.hypot(x - task.hand[0], y - task.hand[1]) / task.lattice.spacing
