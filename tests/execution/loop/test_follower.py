"""Plans in space that are followed step by step."""

from __future__ import annotations

import numpy as np

from gcm_learn.execution import (
    CAUGHT,
    KinematicPlant,
    Pool,
    SpatialSettings,
    follower_of,
    run_episode,
)
from gcm_learn.planners import get_planner


def test_catches_of_planners_are_caught_in_the_arena(arms):
    """When the plan does, or in the step after; with limits of acceleration too."""
    planner = get_planner("layered")
    plans = [planner.plan(situation) for situation in arms]
    shown = [k for k, plan in enumerate(plans) if plan.caught and plan.trajectory.duration > 0.0]
    pool = Pool.of([arms[k] for k in shown])
    ways = [plans[k].trajectory for k in shown]
    plant = KinematicPlant(pool, len(pool), SpatialSettings())
    episodes = run_episode(follower_of(ways, pool, 0.02), plant, np.arange(len(pool)))
    caught = episodes.outcomes == CAUGHT
    late = episodes.times - [way.duration for way in ways]
    assert caught.mean() > 0.6  # corners that steps cut spoil some
    assert (late[caught] < 0.021).all()
    slow = np.array([arms[k].arm.max_joint_acceleration is not None for k in shown])
    assert caught[slow].any() or not slow.any()
