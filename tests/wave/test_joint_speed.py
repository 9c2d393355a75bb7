"""Fronts of a hand whose joints are limited: against the exact time between two poses."""

from __future__ import annotations

import numpy as np
import pytest

from gcm_learn import seeding
from gcm_learn.arms import Arm
from gcm_learn.arms.planar_limb import joint_angles
from gcm_learn.charts.lattice import hand_space
from gcm_learn.situation import Situation
from gcm_learn.wave import MarchingParams, WaveParams, fastest
from gcm_learn.wave.causal import march_in_plane as march, march_layers_in_plane as march_layers
from gcm_learn.wave.reference import propagate_reference
from gcm_learn.wave.solver import propagate_in_plane as propagate
from tests.wave.scenes import disc, earliest, scene, setting_of

LIMITS = (2.0, 3.0)
FAST = 50.0  # hand speed that is never the limit
HAND = (1.1, 0.3)


def free_task(n=60, rho=1.0, elbow="right", speed=FAST):
    situation = scene(hand=HAND, horizon=3.0)
    setting = setting_of(Situation("free", 3.0, Arm(HAND, speed, rho, elbow), situation.bodies), n)
    return setting.limited(shoulder=LIMITS[0], elbow=LIMITS[1])


def exact(setting):
    """Least time (n, n) from the hand to every cell: joints turn evenly, each at its own pace.

    The shoulder may turn either way round; nothing is in the way and the hand is fast enough.
    """
    n, rho, elbow = setting.lattice.n, setting.lattice.upper_arm, setting.lattice.elbow
    hands = hand_space(setting.lattice).limb[:, :2]
    start = joint_angles([setting.hand], rho, elbow)[0]
    poses = np.array([joint_angles([hand], rho, elbow)[0] for hand in hands])
    turn = poses - start
    turn[:, 0] = (turn[:, 0] + np.pi) % (2.0 * np.pi) - np.pi
    return (np.abs(turn) / LIMITS).max(axis=1).reshape(n, n)


def well_inside(setting, margin=0.15):
    """Cells away from the rims, where rates have no bound."""
    hands = hand_space(setting.lattice).limb[:, :2]
    radius, rho = np.hypot(*hands.T), setting.lattice.upper_arm
    inside = (radius < rho + 1.0 - margin) & (radius > abs(rho - 1.0) + 2.0 * margin)
    return inside.reshape(setting.lattice.n, -1)


@pytest.mark.parametrize(("rho", "elbow"), [(1.0, "right"), (0.8, "left")])
def test_marching_takes_the_time_that_joints_take(rho, elbow):
    setting = free_task(rho=rho, elbow=elbow)
    inside, least = well_inside(setting), exact(setting)
    params = MarchingParams(n=60, until="horizon")
    for arrival in (march(*setting, params).first, earliest(march_layers(*setting, params), 60)):
        ratio = arrival[inside & (least > 0.2)] / least[inside & (least > 0.2)]
        # Straight hand paths are slower than even turning, so the front is late but never early.
        assert np.percentile(ratio, 1) > 0.95
        assert np.median(ratio) < 1.25


def test_loose_joint_limits_change_nothing():
    situation = scene(disc("obstacle", "disc", (0.4, 0.8)), hand=HAND)
    loose = scene(disc("obstacle", "disc", (0.4, 0.8)), hand=HAND, max_joint_speed=(1e3, 1e3))
    params = MarchingParams(n=40, until="horizon")
    near_rim = ~well_inside(setting_of(situation, 40), 0.05)
    free, limited = (march(*setting_of(s, 40), params).first for s in (situation, loose))
    both = (free >= 0.0) & (limited >= 0.0) & ~near_rim
    assert both.sum() > 500
    h = setting_of(situation, 40).lattice.spacing / situation.arm.max_hand_speed
    # Times are summed along the rays then instead of measured.
    assert np.abs(free - limited)[both].max() < 1.0 * h


def test_wave_is_late_where_joints_are_slow_and_as_its_reference():
    params = WaveParams(n=24, until="horizon", margin=0.0)
    setting = free_task(24, speed=3.4)
    front, slow = propagate(*setting, params), propagate_reference(*setting, params)
    both = (front.first >= 0.0) & (slow.first >= 0.0)
    assert both.sum() > 100
    assert np.abs(front.first - slow.first)[both].max() < 0.02
    free = float("inf")
    unlimited = setting.limited(speed=fastest(setting.scene), shoulder=free, elbow=free)
    free = propagate(*unlimited, params).first
    later = front.first[both] - free[both]
    assert later.min() > -1e-3 and np.median(later) > 0.02


def test_joint_limits_are_planned_for():
    """The map's contact is when the plan catches, which retiming alone would make much later."""
    from gcm_learn.families.random_planar import random_planar
    from gcm_learn.planners import get_planner

    late = []
    for k in range(60):
        drawn = random_planar(seeding.rng(71, k), (1, 3))
        situation = scene(*drawn.bodies, hand=drawn.arm.hand, horizon=2.0, elbow=drawn.arm.elbow,
                          upper_arm=drawn.arm.upper_arm, max_joint_speed=LIMITS)  # fmt: skip
        plan = get_planner("marching").plan(situation)
        if plan.caught and plan.map.interception.time > 0.2:
            late.append(plan.catch_time / plan.map.interception.time)
    assert len(late) > 15
    assert 0.8 < np.median(late) < 1.1
