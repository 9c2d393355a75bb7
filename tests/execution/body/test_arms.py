"""Arms with mass side by side: each is a plant of its own, told and paid as kinematic ones are."""

import numpy as np
import pytest

from gcm_learn import execution
from gcm_learn.execution.arena.kernels.joints.observation import observe_all
from gcm_learn.execution.body.motors import motor_accelerations
from tests.execution.conftest import Straight

COUNT = 12


@pytest.fixture(scope="module")
def pool():
    """Situations of arms that have a body."""
    return execution.pool_for(
        execution.PhysicalSettings(),
        execution.situations_of("crossing-swarm-space", COUNT, 0, execution.PhysicalSettings()),
    )


@pytest.fixture(scope="module", params=["joint", "torque"])
def played(request, pool):
    """Episodes in all situations, the commands and the arms."""
    settings = execution.PhysicalSettings(control=request.param)
    arms = execution.PhysicalArms(pool, COUNT, settings)
    steps = []
    episodes = execution.run_episode(Straight(settings), arms, np.arange(COUNT), steps.append)
    return settings, arms, episodes, steps


def test_families_give_arms_that_have_a_body_under_the_limits_of_their_motors(pool):
    assert {body.name for body in pool.bodies} == {"human", "nao"}
    for situation, body in zip(pool.situations, pool.bodies, strict=True):
        assert not body.misfit(situation.arm)
        most = motor_accelerations(situation.arm, body)
        assert situation.arm.max_joint_acceleration == pytest.approx(most)


def test_every_arm_is_a_plant(played, pool):
    """What comes of commands is what the plant makes of them, up to the step of the end."""
    settings, _, episodes, steps = played
    for e in range(COUNT):
        plant = execution.PhysicalPlant(pool.situations[e], pool.bodies[e])
        for k, step in enumerate(steps[: episodes.steps[e]]):
            action = step.actions[list(step.arms).index(e)].astype(float)
            if settings.control == "torque":
                torque = [motor.torque for motor in plant.body.joints]
                plant.push(action * torque, 0.02 * (k + 1))
            else:
                plant.turn(action * np.array(plant.situation.arm.max_joint_speed), 0.02 * (k + 1))
        assert plant.outcome == episodes.outcomes[e]
        time = {execution.CAUGHT: plant.catch_time, execution.LATE: plant.situation.horizon}.get(
            plant.outcome
        )
        if plant.outcome == execution.COLLIDED:
            time = plant.contact.time
        assert episodes.times[e] == pytest.approx(time)
        assert episodes.posture[episodes.steps[e], e, :4] == pytest.approx(
            plant.joints_log[plant.ended], abs=1e-5
        )
    assert {execution.CAUGHT, execution.COLLIDED} <= set(episodes.outcomes)


def test_rewards_pay_for_what_happened(played):
    _, _, episodes, steps = played
    total = np.zeros(COUNT)
    for step in steps:
        np.add.at(total, step.arms, step.rewards)
    horizon = np.array([s.horizon for s in played[1].pool.situations])
    wanted = (episodes.outcomes == execution.CAUGHT) * 1.0 - (
        episodes.outcomes == execution.COLLIDED
    )
    np.testing.assert_allclose(total, wanted - 0.1 * episodes.times / horizon, atol=1e-5)


def test_what_is_told_is_what_kinematic_arms_are_told(pool):
    """Number by number: the same function of situation, time, joints and rates."""
    settings, everyone = execution.PhysicalSettings(control="torque"), np.arange(COUNT)
    arms = execution.PhysicalArms(pool, COUNT, settings)
    kinematic = execution.KinematicPlant(
        execution.Pool.of(pool.situations), COUNT, execution.SpatialSettings()
    )
    for plant in (arms, kinematic):
        plant.put(everyone, everyone)
    np.testing.assert_array_equal(arms.observations[:, :-8], kinematic.observations)
    before = kinematic.observations.copy()
    arms.move(np.full((COUNT, 4), 0.5))
    kinematic.state.posture[:], kinematic.state.time[:] = arms.posture, arms.time
    world, state = tuple(kinematic.pool.world), tuple(kinematic.state)
    options = execution.SpatialSettings().options
    observe_all(world, state, everyone, options, kinematic.observations)
    np.testing.assert_array_equal(arms.observations[:, :-8], kinematic.observations)
    assert (np.abs(kinematic.observations - before).max(axis=1) > 0.01).all()


def test_a_plant_that_begins_anew_is_as_good_as_new(pool, monkeypatch):
    """Plants wait for their situations to come again, not more of them than may be kept."""
    monkeypatch.setattr("gcm_learn.execution.body.arms.KEPT", 2)
    arms, commands = (
        execution.PhysicalArms(pool, 1, execution.PhysicalSettings()),
        np.full((12, 1, 4), 0.7),
    )
    one, seen, plants = np.zeros(1, int), [], []
    for place in (0, 1, 0, 2, 3, 4, 0):
        arms.put(one, one + place)
        plants.append(arms.plants[0])
        first = arms.observations.copy()
        for command in commands:
            arms.move(command)
        if place == 0:
            seen.append((first, arms.observations.copy(), arms.posture.copy(), arms.time.copy()))
    assert plants[2] is plants[0] and plants[6] is not plants[0]
    for again in seen[1:]:
        for mine, its in zip(seen[0], again, strict=True):
            np.testing.assert_array_equal(mine, its)


def test_torques_that_are_told_hold_the_arm(pool):
    """An arm that gives what holds it hardly moves; one that gives nothing falls."""
    settings = execution.PhysicalSettings(control="torque")
    arms = execution.PhysicalArms(pool, COUNT, settings)

    def moved(command):
        arms.put(np.arange(COUNT), np.arange(COUNT))
        start = arms.posture[:, :4].copy()
        for _ in range(5):
            arms.move(command(arms.observations))
        return np.abs(arms.posture[:, :4] - start).max(axis=1)

    held = moved(lambda told: told[:, -8:-4])
    fallen = moved(lambda told: np.zeros((COUNT, 4)))
    assert np.median(held) < 0.02 < 0.1 < np.median(fallen)
