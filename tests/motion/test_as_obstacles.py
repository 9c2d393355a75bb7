"""Movements as obstacles: bodies that hold every link at every instant."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import families, solve
from gcm_learn.arms import Chain, links_along
from gcm_learn.errors import ArmKindError
from gcm_learn.motion import Movement, as_obstacles, with_stop
from gcm_learn.scene import pack
from gcm_learn.scene.bodies import poses_at
from gcm_learn.situation import (
    Body,
    Situation,
    SolidQuadratic,
    Sphere,
    arm_from_json,
    shipped_arm,
)
from tests.chains import LEVERS

STILL = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))


def panda(origin=(0.0, 0.0, 0.0), **how):
    home = (0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785)
    arm = Chain(shipped_arm("panda"), joints=home, grasp=0.05, **how)
    return replace(arm, base=replace(arm.base, origin=origin))


def chain_moves(curved):
    arm = panda(max_joint_acceleration=(20.0,) * 7 if curved else None)
    rng = np.random.default_rng(3)
    low, high = np.array(arm.joint_range).T
    joints = np.vstack([arm.joints, rng.uniform(low, high, (4, 7))])
    time = np.array([0.0, 0.3, 0.7, 0.75, 1.4])
    rates = rng.normal(size=(5, 7)) * 2.0 if curved else None
    return Movement(arm, time, joints, rates)


def spatial_moves():
    situation = families.draw("falling-space", 0, 2)
    arm = replace(situation.arm, max_joint_acceleration=None, joint_rates=None)
    return solve(replace(situation, arm=arm), "search").trajectory


def tree_moves():
    """A telescope whose second stage and lever follow the first."""
    arm = Chain(arm_from_json(LEVERS), (0.1, 0.1, 0.2), 0.02)
    joints = np.array([arm.joints, (1.0, 0.5, -1.0), (0.5, 0.2, 0.3)])
    return Movement(arm, np.array([0.0, 0.6, 1.0]), joints)


MOVES = {
    "tree": tree_moves,
    "lines": lambda: chain_moves(False),
    "curves": lambda: chain_moves(True),
    "spatial": spatial_moves,
}


@pytest.mark.parametrize("error", [1e-2, 1e-3])
@pytest.mark.parametrize("name", MOVES)
def test_links_stay_within_their_bodies(name, error):
    moves = MOVES[name]()
    bodies = as_obstacles(moves, "other", error)
    target = Body("target", "ball", Sphere(0.1), SolidQuadratic((9.0, 9.0, 9.0), *STILL))
    packed = pack(Situation("cell", moves.duration + 1.0, panda(), (target, *bodies))).bodies
    times = np.linspace(0.0, moves.duration + 0.5, 200)
    ends, radii = links_along(moves.arm, moves.joints_at(times))
    assert len(bodies) == len(radii) and bodies[0].name == "other link 0"
    halves = [getattr(body.shape, "half_length", 0.0) for body in bodies]
    assert [body.shape.radius for body in bodies] == pytest.approx((radii + error).tolist())
    strays = []
    for t, pairs in zip(times, ends, strict=True):
        poses = np.zeros((len(bodies) + 1, 12))
        poses[:, [3, 7, 11]] = 1.0
        poses_at(packed, t, poses)
        for pose, half, pair in zip(poses[1:], halves, pairs, strict=True):
            along = half * pose[[5, 8, 11]]
            away = pair - [pose[:3] - along, pose[:3] + along]
            strays.append(np.linalg.norm(away, axis=1).max())
    assert max(strays) <= error + 1e-9
    assert name == "spatial" or max(strays) > 0.01 * error  # samples are not wastefully many


def test_one_arm_is_planned_around_another():
    """Two arms reach past each other; dense samples show that they never touch."""
    ball = Body("target", "ball", Sphere(0.04), SolidQuadratic((0.45, 0.0, 0.6), *STILL))
    first = panda()
    one = Situation("first", 1.5, first, (ball,))
    moves = with_stop(one, solve(one).trajectory)
    second = panda((1.0, 0.0, 0.0))
    second = replace(second, base=replace(second.base, rotation=(0.0, 0.0, 0.0, 1.0)))
    other = replace(ball, motion=SolidQuadratic((0.55, 0.25, 0.5), *STILL))
    cell = Situation("second", 1.5, second, (other, *as_obstacles(moves, "first")))
    plan = solve(cell)
    assert plan.caught
    times = np.linspace(0.0, plan.catch_time, 300)
    links = [
        links_along(arm, path.joints_at(times))
        for arm, path in ((first, moves), (second, plan.trajectory))
    ]
    assert least_gap(*links) >= 0.0


def least_gap(one, other):
    """Return the least distance of capsules of two arms, by points along their axes."""
    share = np.linspace(0.0, 1.0, 15)[:, None]
    least = np.inf
    for k, radius in enumerate(one[1]):
        for m, wide in enumerate(other[1]):
            a = one[0][:, k, None, 0] + share * (one[0][:, k, None, 1] - one[0][:, k, None, 0])
            b = other[0][:, m, None, 0] + share * (
                other[0][:, m, None, 1] - other[0][:, m, None, 0]
            )
            apart = np.linalg.norm(a[:, :, None] - b[:, None], axis=3).min()
            least = min(least, apart - radius - wide)
    return least


def test_what_cannot_be_an_obstacle_is_refused():
    plan = solve(families.draw("gate", 0, 1), "search")
    with pytest.raises(ArmKindError):
        as_obstacles(plan.trajectory, "planar")
    for error in (0.0, -1.0, float("nan")):
        with pytest.raises(ValueError, match="error: must be above 0"):
            as_obstacles(chain_moves(False), "other", error)
    with pytest.raises(ValueError, match="takes over 100000 samples"):
        as_obstacles(chain_moves(False), "other", 1e-15)
