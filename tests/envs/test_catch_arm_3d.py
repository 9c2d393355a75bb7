"""The environments in space: promises, Gymnasium's rules, batches equal to single ones."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

from gcm_learn import families
from gcm_learn.arms import forward_in_space
from gcm_learn.errors import ArenaError, ArmKindError
from gcm_learn.motion.rules import rules_of
from gcm_learn.motion.verification import verify
from gcm_learn.scene.packing import pack
from tests.execution.space.conftest import arms  # noqa: F401

gymnasium = pytest.importorskip("gymnasium")
from gcm_learn.envs.catch_arm import CatchArm  # noqa: E402
from gcm_learn.envs.catch_arm_3d import CatchArm3D  # noqa: E402
from gcm_learn.envs.vector import CatchArms3D  # noqa: E402
from gcm_learn.execution import AIM  # noqa: E402


@pytest.fixture(scope="module")
def env(arms):  # noqa: F811
    """Return an environment over the shared situations."""
    return CatchArm3D(arms)


def played(env, index):
    """Play an episode straight to the target; the rewards and the last info."""
    observation, info = env.reset(options={"index": index})
    rewards, terms = [], []
    for _ in range(1000):
        observation, reward, ended, late, info = env.step(observation[AIM : AIM + 4])
        assert env.observation_space.contains(observation)
        rewards.append(reward)
        terms.append(info["reward_terms"])
        if ended or late:
            return rewards, terms, info
    raise AssertionError("the horizon did not end the episode")


def test_an_episode_ends_with_what_it_is_rewarded_for(env):
    outcomes = []
    for index in range(len(env.pool)):
        rewards, terms, info = played(env, index)
        situation, way = env.situation, env.trajectory
        outcomes.append(info["outcome"])
        assert info["is_success"] == (info["outcome"] == "caught")
        assert sum(t["catch"] for t in terms) == float(info["is_success"])
        assert sum(t["touch"] for t in terms) == -float(info["outcome"] == "touched")
        haste = sum(t["haste"] for t in terms)
        assert haste == pytest.approx(-0.1 * way.duration / situation.horizon, abs=1e-9)
        assert sum(rewards) == pytest.approx(sum(sum(t.values()) for t in terms))
        hand = forward_in_space(situation.arm, way.joints[-1])[1]
        np.testing.assert_allclose(info["hand"], hand, atol=1e-9)
        if info["is_success"]:
            scene = pack(situation)
            targets = [k for k, b in enumerate(situation.bodies) if b.role == "target"]
            assert any(verify(scene, rules_of(scene), way, k).good for k in targets)
    assert {"caught", "touched"} <= set(outcomes)


def test_the_guide_adds_up_to_the_first_potential(arms):  # noqa: F811
    """Potential-based: whatever the arm does, the discounted sum is the potential of the start."""
    env = CatchArm3D(arms[:6], settings={"weights": {"guide": 2.0}, "discount": 0.97})
    rng, totals = np.random.default_rng(0), []
    for _ in range(2):
        for index in range(6):
            env.reset(options={"index": index})
            total, factor, over = 0.0, 1.0, False
            while not over:
                _, _, ended, late, info = env.step(rng.uniform(-1, 1, 4))
                total += factor * info["reward_terms"]["guide"]
                factor, over = 0.97 * factor, ended or late
            totals.append(total)
    np.testing.assert_allclose(totals[:6], totals[6:], atol=1e-9)
    assert min(totals) > 0.01 and max(totals) <= 2.0


def test_gymnasium_and_stable_baselines_accept_it(arms):  # noqa: F811
    from gymnasium.utils.env_checker import check_env

    check_env(CatchArm3D(arms, render_mode="rgb_array"))
    check = pytest.importorskip("stable_baselines3.common.env_checker")
    check.check_env(CatchArm3D(arms))


def test_make_knows_it(arms):  # noqa: F811
    env = gymnasium.make("gcm_learn:CatchArm3D-v0", situations=arms)
    assert env.reset(seed=0)[0].shape == (145,)
    many = gymnasium.make_vec(
        "gcm_learn:CatchArm3D-v0",
        num_envs=3,
        vectorization_mode="vector_entry_point",
        situations=arms,
    )
    assert isinstance(many.unwrapped, CatchArms3D)
    assert many.reset(seed=1)[0].shape == (3, 145)


def test_batches_are_single_ones(arms):  # noqa: F811
    n, settings = len(arms), {"weights": {"guide": 1.0}, "slots": 2}
    many = CatchArms3D(n, arms, settings=settings, threads=2)
    one = CatchArm3D(many.pool, settings=settings)
    first, _ = many.reset(options={"index": np.arange(n)})
    rng = np.random.default_rng(3)
    actions, steps = rng.uniform(-1, 1, (12, n, 4)), []
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


def test_seeds_and_pickles_give_the_same_episode(env):
    copy = pickle.loads(pickle.dumps(env))
    np.testing.assert_array_equal(env.reset(seed=3)[0], copy.reset(seed=3)[0])
    action = np.array([0.3, -0.4, 0.2, 0.1])
    np.testing.assert_array_equal(env.step(action)[0], copy.step(action)[0])


def test_pictures_show_the_moment(arms):  # noqa: F811
    env = CatchArm3D(arms, render_mode="rgb_array")
    env.reset(seed=0)
    first = env.render()
    for _ in range(3):
        env.step(np.array([1.0, 0.5, -0.5, 1.0]))
    second = env.render()
    assert first.shape == (480, 480, 3) and first.dtype == np.uint8
    assert 100 < (first != second).any(axis=2).sum() < 150_000
    env.close()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"situations": "nowhere"}, "situations: 'nowhere' is no file, folder or family"),
        ({"settings": {"dt": 0.0}}, "dt: must be from 0.0001 to 1 s (got 0.0)"),
        ({"settings": {"control": "hand"}}, "settings: 'control' is not a known field"),
        ({"settings": {"weights": {"joy": 1}}}, "settings.weights: 'joy'"),
        ({"settings": 3}, "settings: must be SpatialSettings (got int)"),
        ({"render_mode": "ascii"}, "render_mode: 'ascii'"),
    ],
)
def test_bad_arguments_are_refused_in_one_line(arguments, message):
    with pytest.raises(ArenaError) as caught:
        CatchArm3D(**{"pool": 2, **arguments})
    assert message in str(caught.value) and "\n" not in str(caught.value)


def test_arms_of_the_other_kind_are_refused_in_one_line(env, arms):  # noqa: F811
    flat = families.draw("random-planar", 3, 0)
    for refused in (
        lambda: CatchArm3D("random-planar", pool=2),
        lambda: CatchArms3D(2, [flat]),
        lambda: env.reset(options={"situation": flat}),
        lambda: CatchArm("static-clutter-space", pool=2),
        lambda: CatchArm([flat]).reset(options={"situation": arms[0]}),
    ):
        with pytest.raises(
            ArmKindError, match=r"takes spatial arms only|does not take spatial arms"
        ) as caught:
            refused()
        assert "\n" not in str(caught.value)
