"""The environments of arms with mass: Gymnasium's rules, rewards, batches equal to single ones."""

from __future__ import annotations

import pickle
import sys

import numpy as np
import pytest

from gcm_learn import families
from gcm_learn.arms import forward_in_space
from gcm_learn.errors import ArenaError, ArmKindError, MissingExtraError, PhysicsError

gymnasium = pytest.importorskip("gymnasium")
from gcm_learn.envs import CatchArm3D, CatchArmPhysics, CatchArmsPhysics  # noqa: E402
from gcm_learn.execution import PhysicalPool, physical_pool_of  # noqa: E402

ID = "gcm_learn:CatchArmPhysics-v0"


@pytest.fixture(scope="module")
def pool():
    """Situations of arms that have a body."""
    return physical_pool_of("crossing-swarm-space", 8, 0)


def played(env, index, at):
    """Play an episode straight to the target; the rewards, their terms, and the last info."""
    observation, info = env.reset(options={"index": index})
    rewards, terms = [], []
    for _ in range(1000):
        observation, reward, ended, late, info = env.step(observation[at : at + 4])
        assert env.observation_space.contains(observation)
        rewards.append(reward)
        terms.append(info["reward_terms"])
        if ended or late:
            return rewards, terms, info
    raise AssertionError("the horizon did not end the episode")


@pytest.mark.parametrize("control", ["joint", "torque"])
def test_an_episode_ends_with_what_it_is_rewarded_for(pool, control):
    env = CatchArmPhysics(pool, settings={"control": control})
    outcomes = set()
    for index in range(len(pool)):
        rewards, terms, info = played(env, index, env.settings.straight)
        situation, way = env.situation, env.trajectory
        outcomes.add(info["outcome"])
        assert info["is_success"] == (info["outcome"] == "caught")
        assert sum(t["catch"] for t in terms) == float(info["is_success"])
        assert sum(t["touch"] for t in terms) == -float(info["outcome"] == "touched")
        haste = sum(t["haste"] for t in terms)
        assert haste == pytest.approx(-0.1 * info["time"] / situation.horizon, abs=1e-9)
        assert sum(rewards) == pytest.approx(sum(sum(t.values()) for t in terms))
        hand = forward_in_space(situation.arm, way.joints[-1])[1]
        assert info["hand"] == pytest.approx(hand, abs=1e-9)
        if info["outcome"] != "late":
            assert way.duration == pytest.approx(info["time"])
    assert {"caught", "touched"} <= outcomes


def test_the_guide_adds_up_to_the_first_potential(pool):
    """Potential-based: whatever the arm does, the discounted sum is the potential of the start."""
    env = CatchArmPhysics(pool, settings={"weights": {"guide": 2.0}, "discount": 0.97})
    rng, totals = np.random.default_rng(0), []
    for index in (0, 1, 0, 1):
        env.reset(options={"index": index})
        total, factor, over = 0.0, 1.0, False
        while not over:
            _, _, ended, late, info = env.step(rng.uniform(-1, 1, 4))
            total += factor * info["reward_terms"]["guide"]
            factor, over = 0.97 * factor, ended or late
        totals.append(total)
    np.testing.assert_allclose(totals[:2], totals[2:], atol=1e-9)
    assert 0.01 < min(totals) <= max(totals) <= 2.0


@pytest.mark.parametrize("control", ["joint", "torque"])
def test_gymnasium_and_stable_baselines_accept_it(pool, control):
    from gymnasium.utils.env_checker import check_env

    settings = {"control": control}
    check_env(CatchArmPhysics(pool, render_mode="rgb_array", settings=settings))
    check = pytest.importorskip("stable_baselines3.common.env_checker")
    check.check_env(CatchArmPhysics(pool, settings=settings))


def test_make_knows_it(pool):
    env = gymnasium.make(ID, situations="static-clutter-space", pool=3)
    assert env.reset(seed=0)[0].shape == (145,)
    assert gymnasium.make(ID, situations=pool, settings={"control": "torque"}).reset(seed=0)[
        0
    ].shape == (153,)
    many = gymnasium.make_vec(
        ID, num_envs=3, vectorization_mode="vector_entry_point", situations=pool
    )
    assert isinstance(many.unwrapped, CatchArmsPhysics)
    assert many.reset(seed=1)[0].shape == (3, 145)


@pytest.mark.parametrize("mode", ["sync", "async"])
def test_gymnasium_s_own_vectors_hold_it(pool, mode):
    many = gymnasium.make_vec(ID, num_envs=2, vectorization_mode=mode, situations=pool)
    first = many.reset(seed=5)[0]
    seen, *_ = many.step(np.full((2, 4), 0.2, np.float32))
    many.close()
    for e in range(2):
        one = CatchArmPhysics(pool)
        np.testing.assert_array_equal(one.reset(seed=5 + e)[0], first[e])
        np.testing.assert_array_equal(one.step(np.full(4, 0.2, np.float32))[0], seen[e])


def test_batches_are_single_ones(pool):
    n, settings = len(pool), {"weights": {"guide": 1.0}, "slots": 2}
    many = CatchArmsPhysics(n, pool, settings=settings)
    one = CatchArmPhysics(pool, settings=settings)
    first, _ = many.reset(options={"index": np.arange(n)})
    actions, steps = np.random.default_rng(3).uniform(-1, 1, (8, n, 4)), []
    for action in actions:
        steps.append(many.step(action))
    for e in range(n):
        np.testing.assert_array_equal(one.reset(options={"index": e})[0], first[e])
        for k, (seen, rewards, ended, late, info) in enumerate(steps):
            alone = one.step(actions[k, e])
            assert (rewards[e], ended[e], late[e]) == alone[1:4]
            over = ended[e] or late[e]
            told = info["final_obs"][e] if over else seen[e]
            np.testing.assert_array_equal(told, alone[0])
            if over:
                assert info["final_info"]["outcome"][e] == alone[4]["outcome"]
                break


def test_seeds_and_pickles_give_the_same_episode(pool):
    env = CatchArmPhysics(pool)
    env.reset(seed=1)
    env.step(np.zeros(4))
    copy = pickle.loads(pickle.dumps(env))
    action = np.array([0.3, -0.4, 0.2, 0.1])
    np.testing.assert_array_equal(env.step(action)[0], copy.step(action)[0])
    np.testing.assert_array_equal(env.reset(seed=3)[0], copy.reset(seed=3)[0])
    np.testing.assert_array_equal(env.step(action)[0], copy.step(action)[0])


def test_a_situation_of_one_s_own_may_be_given(pool):
    env = CatchArmPhysics(pool)
    observation, _ = env.reset(options={"situation": pool.situations[3]})
    np.testing.assert_array_equal(observation, env.reset(options={"index": 3})[0])


def test_pictures_show_the_moment(pool):
    env = CatchArmPhysics(pool, render_mode="rgb_array")
    env.reset(options={"index": 0})
    first = env.render()
    env.step(np.array([1.0, 0.5, -0.5, 1.0]))
    env.step(np.array([1.0, 0.5, -0.5, 1.0]))
    second = env.render()
    assert first.shape == (480, 480, 3) and first.dtype == np.uint8
    assert 100 < (first != second).any(axis=2).sum() < 150_000
    env.close()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"situations": "nowhere"}, "situations: 'nowhere' is no file, folder or family"),
        ({"settings": {"dt": 0.005}}, "dt: must be whole steps of physics, of 0.002 s"),
        ({"settings": {"control": "hand"}}, "control: 'hand' is not one of joint, torque"),
        ({"settings": 3}, "settings: must be PhysicalSettings (got int)"),
        ({"render_mode": "ascii"}, "render_mode: 'ascii'"),
    ],
)
def test_bad_arguments_are_refused_in_one_line(arguments, message):
    with pytest.raises(ArenaError) as caught:
        CatchArmPhysics(**{"pool": 2, **arguments})
    assert message in str(caught.value) and "\n" not in str(caught.value)


def test_arms_without_a_body_are_refused_in_one_line(pool):
    drawn = [families.draw("static-clutter-space", 1, k) for k in range(40)]
    mixed = next(s for s in drawn if s.arm.upper_arm[0] not in (1.0, 0.105))
    for refused in (
        lambda: CatchArmPhysics([mixed]),
        lambda: CatchArmPhysics(pool).reset(options={"situation": mixed}),
    ):
        with pytest.raises(PhysicsError, match="none that is shipped fits the arm") as caught:
            refused()
        assert "\n" not in str(caught.value) and mixed.name in str(caught.value)
    with pytest.raises(ArmKindError, match="takes spatial arms only"):
        CatchArmPhysics("random-planar", pool=2)


def test_the_body_may_be_chosen(pool):
    humans = [s for s, b in zip(pool.situations, pool.bodies, strict=True) if b.name == "human"]
    env = CatchArmPhysics(humans, body="human")
    assert {body.name for body in env.pool.bodies} == {"human"}
    with pytest.raises(PhysicsError, match="body nao: does not fit"):
        CatchArmPhysics(humans, body="nao")


def test_without_mujoco_the_extra_is_named(monkeypatch, pool):
    monkeypatch.setitem(sys.modules, "mujoco", None)
    with pytest.raises(MissingExtraError, match="sim") as caught:
        CatchArmPhysics(PhysicalPool(pool.situations, pool.world, pool.bodies)).reset(seed=0)
    assert "\n" not in str(caught.value)


def test_it_is_the_kinematic_arena_but_for_mass(pool):
    """The same first observation, and nearly the same way for a slow command."""
    physical, kinematic = CatchArmPhysics(pool), CatchArm3D(pool.situations)
    for index in range(4):
        told = [env.reset(options={"index": index})[0] for env in (physical, kinematic)]
        np.testing.assert_array_equal(told[0], told[1])
        for _ in range(3):
            for env in (physical, kinematic):
                env.step(np.full(4, 0.05))
        apart = physical.plant.posture[0, :4] - kinematic.plant.posture[0, :4]
        assert 0.0 < np.abs(apart).max() < 0.02
