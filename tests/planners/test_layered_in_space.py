"""The planner of first choice for spatial arms: what it claims holds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import seeding, solve
from gcm_learn.handspace import joint_lattice
from gcm_learn.handspace.joints import neighbour, posture_of
from gcm_learn.scene import forward_in_space, pack
from gcm_learn.situation import Body, Box, Situation, SolidQuadratic, Sphere, situation_from_json
from tests.situation.test_spatial_arm import NAO

SPATIAL = situation_from_json(NAO)
STILL = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


def scene_of(rng, walls=2):
    """A ball that flies to where the hand of a random posture is, among boxes that stand still."""
    arm, horizon = SPATIAL.arm, 0.8
    low, high = np.array(arm.joint_range).T
    start, goal = rng.uniform(low, high, (2, 4))
    hand = forward_in_space(arm, goal)[1]
    velocity = rng.uniform(-0.3, 0.3, 3)
    flight = SolidQuadratic(tuple(hand - 0.5 * horizon * velocity), tuple(velocity), (0.0,) * 3)
    bodies = [Body("target", "ball", Sphere(0.03), flight)]
    for k in range(walls):
        place = forward_in_space(arm, rng.uniform(low, high))[1] + rng.uniform(-0.05, 0.05, 3)
        size = tuple(rng.uniform(0.01, 0.05, 3))
        bodies.append(Body("obstacle", f"o{k}", Box(size), SolidQuadratic(tuple(place), *STILL)))
    arm = replace(arm, joints=tuple(start))
    return Situation("drawn", horizon, arm, tuple(bodies))


def test_catches_are_kept_and_frequent():
    plans = [solve(scene_of(seeding.rng(7, k)), "layered") for k in range(30)]
    caught = [plan for plan in plans if plan.caught]
    assert len(caught) >= 15
    for plan in caught:
        assert plan.catch_time == plan.trajectory.time[-1]


@pytest.mark.parametrize("nodes", [16**4, 500, 1])
def test_a_lattice_holds_the_start_and_the_ends(nodes):
    scene = pack(SPATIAL)
    lattice = joint_lattice(scene, nodes)
    q = np.zeros(4)
    posture_of(lattice, lattice.start, q)
    np.testing.assert_array_equal(q, scene.limb.start)
    for j in range(4):
        values = lattice.values[j, : lattice.counts[j]]
        assert (np.diff(values) > 0.0).all()
        assert scene.limb.low[j] <= values[0] and values[-1] <= scene.limb.high[j]
        node = lattice.start
        while neighbour(lattice, node, j, 1) >= 0:
            node = neighbour(lattice, node, j, 1)
        posture_of(lattice, node, q)
        assert q[j] == values[-1]
