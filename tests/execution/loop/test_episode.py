"""Episodes: one loop for whatever acts and whatever carries commands out."""

import numpy as np
import pytest

from gcm_learn import execution, planners
from gcm_learn.execution.arena.kernels.hands.scene import scene_of
from gcm_learn.execution.arena.kernels.world import rules_in
from gcm_learn.motion.rules import rules_of
from gcm_learn.planners import get_planner
from gcm_learn.scene.packing import pack
from gcm_learn.situation.canonical import canonical


class Wanderer:
    """Goes where a generator says, the same way with every arm."""

    def __init__(self, seed):
        self._rng = np.random.default_rng(seed)

    def act(self, moment):
        """One direction for all."""
        return np.tile(self._rng.uniform(-1.0, 1.0, 2), (len(moment.hand), 1))


class Counter:
    """A plant without arms: episode k ends at its k-th step."""

    def __init__(self, count):
        self.time, self.hand = np.zeros(count), np.zeros((count, 2))
        self.posture = self.hand
        self.observations, self.rewards = np.zeros((count, 1), "f4"), np.ones(count)
        self.held = []

    def put(self, arms, places):
        """Begin."""
        self.ends = places + 1

    def move(self, actions):
        """Count."""
        self.time += 1.0
        self.hand += actions
        self.observations += 1.0
        return np.where(self.time >= self.ends, execution.LATE, execution.RUNNING)

    def hold(self, arms):
        """Note who rests."""
        self.held.append(arms.tolist())


def test_any_plant_will_do_and_what_is_over_is_held():
    plant, seen = Counter(3), []
    episodes = execution.run_episode(Wanderer(0), plant, np.array([0, 2, 1]), seen.append)
    assert episodes.outcomes.tolist() == [execution.LATE] * 3
    assert episodes.steps.tolist() == [1, 3, 2] and episodes.times.tolist() == [1.0, 3.0, 2.0]
    assert plant.held == [[0], [0, 2], [0, 1, 2]]
    assert [step.arms.tolist() for step in seen] == [[0, 1, 2], [1, 2], [1]]
    assert [step.told[0, 0] for step in seen] == [0.0, 1.0, 2.0]  # before, not after
    assert [step.following[0, 0] for step in seen] == [1.0, 2.0, 3.0]


def test_one_arm_is_a_batch_of_one(scenes):
    pool, settings = execution.Pool.of(scenes), execution.Settings()
    places = np.arange(len(pool))
    together = execution.run_episode(
        Wanderer(1), execution.KinematicPlant(pool, len(pool), settings), places
    )
    assert (
        {execution.COLLIDED, execution.LATE}
        <= set(together.outcomes.tolist())
        <= {execution.CAUGHT, execution.COLLIDED, execution.LATE}
    )
    for e in places[::3]:
        alone = execution.run_episode(
            Wanderer(1), execution.KinematicPlant(pool, 1, settings), places[e : e + 1]
        )
        assert alone.outcomes[0] == together.outcomes[e]
        for one, other in zip(alone.path(0), together.path(e), strict=True):
            np.testing.assert_array_equal(one, other)


def test_who_follows_plans_catches_as_planned(scenes):
    found = [canonical(s)[0] for s in scenes]
    plans = [planners.solve(s, "straight") for s in found]
    kept = [(s, p) for s, p in zip(found, plans, strict=True) if p.caught]
    pool, settings, seen = execution.Pool.of([s for s, _ in kept]), execution.Settings(), []
    agent = execution.follower_of([p.trajectory for _, p in kept], pool, settings.dt)
    plant = execution.KinematicPlant(pool, len(pool), settings)
    episodes = execution.run_episode(agent, plant, np.arange(len(pool)), seen.append)
    assert len(pool) > 4 and np.all(episodes.outcomes == execution.CAUGHT)
    planned = [p.catch_time for _, p in kept]
    np.testing.assert_allclose(episodes.times, planned, atol=2e-3)
    ends = [step.rewards[step.outcomes == execution.CAUGHT] for step in seen]
    assert np.concatenate(ends) == pytest.approx(1.0, abs=0.01)  # the reward of a catch


def test_a_world_holds_the_scenes_that_it_was_made_of(scenes):
    world = execution.Pool.of(scenes).world
    for s, drawn in enumerate(scenes):
        scene, situation = scene_of(world, s), canonical(drawn)[0]
        packed = pack(situation)
        assert scene.limits == packed.limits and rules_in(world, s) == rules_of(packed)
        assert scene.limb._replace(near=0.0) == packed.limb._replace(near=0.0)
        assert packed.limb.near < scene.limb.near < packed.limb.near + 0.02
        names = len(packed.bodies.rows)
        assert len(scene.bodies.rows) == names == len(situation.bodies)
        assert scene.bodies.angle_step == packed.bodies.angle_step


@pytest.mark.slow
def test_catches_of_planners_are_caught_in_the_arena(arms):
    """When the plan does, or in the step after; with limits of acceleration too."""
    planner = get_planner("search")
    plans = [planner.plan(situation) for situation in arms]
    shown = [k for k, plan in enumerate(plans) if plan.caught and plan.trajectory.duration > 0.0]
    pool = execution.Pool.of([arms[k] for k in shown])
    ways = [plans[k].trajectory for k in shown]
    plant = execution.KinematicPlant(pool, len(pool), execution.SpatialSettings())
    episodes = execution.run_episode(
        execution.follower_of(ways, pool, 0.02), plant, np.arange(len(pool))
    )
    caught = episodes.outcomes == execution.CAUGHT
    late = episodes.times - [way.duration for way in ways]
    assert caught.mean() > 0.6  # corners that steps cut spoil some
    assert (late[caught] < 0.021).all()
    slow = np.array([arms[k].arm.max_joint_acceleration is not None for k in shown])
    assert caught[slow].any() or not slow.any()
