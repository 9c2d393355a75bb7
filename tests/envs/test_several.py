"""Episodes that ask for several catches: they go on until all are made, or the horizon."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn.arms import SpatialArm, hands_along
from gcm_learn.envs import CatchArm3D, CatchChain, CatchChainPhysics, CatchChains
from gcm_learn.motion import rules_of, verify
from gcm_learn.scene import pack
from tests.worlds import among, panda, solid_ball

PANDA = panda(0.05)
SPATIAL = SpatialArm(
    upper_arm=(0.3, 0.0, 0.0), forearm=(0.3, 0.0, 0.0), joints=(0.2, 0.3, 0.1, -1.0),
    joint_range=((-3.0, 3.0),) * 4, max_joint_speed=(3.0,) * 4, grasp=0.05, thickness=0.02,
)  # fmt: skip
ENVS = {"chain": (CatchChain, PANDA), "physics": (CatchChainPhysics, PANDA),
        "spatial": (CatchArm3D, SPATIAL)}  # fmt: skip


def places(arm, *turns):
    """Places of the hand with the first joint turned."""
    joints = np.tile(arm.joints, (len(turns), 1))
    joints[:, 0] += turns
    return hands_along(arm, joints)[0].tolist()


def target(name, place):
    return solid_ball(name, place, role="target")


FAR = target("far", (0.0, 3.0, 0.0))


def asking(arm, catch, *bodies):
    return among(arm, *bodies, horizon=3.0, catch=catch, format="gcm-learn/situation@3")


def two_balls(arm, catch="all"):
    first, second = places(arm, 0.6, -0.5)
    return asking(arm, catch, target("first", first), target("second", second))


def played(env, steps=200):
    """Go straight to what can be met first; yield what each step says."""
    observation, _ = env.reset(seed=0)
    straight, n = env.settings.straight, env.settings.commands
    for _ in range(steps):
        observation, reward, ended, late, info = env.step(observation[straight : straight + n])
        yield observation, reward, ended, late, info
        if ended or late:
            return


@pytest.mark.parametrize("name", ENVS)
def test_an_episode_goes_on_until_all_targets_are_caught(name):
    make, arm = ENVS[name]
    rows = list(played(make(situations=two_balls(arm))))
    infos = [row[4] for row in rows]
    counts = [len(info["caught"]) for info in infos]
    assert counts[-1] == 2 and 1 in counts and sorted(counts) == counts
    assert sorted(infos[-1]["caught"]) == ["first", "second"]
    assert infos[-1]["outcome"] == "caught" and infos[-1]["is_success"]
    assert not any(row[2] for row in rows[:-1]) and rows[-1][2]
    paid = [info["reward_terms"]["catch"] for info in infos]
    alone = make(situations=asking(arm, "any", two_balls(arm).bodies[0]))
    whole = sum(row[4]["reward_terms"]["catch"] for row in played(alone))
    assert sum(paid) == pytest.approx(whole) and whole > 0.0
    assert [p > 0.0 for p in paid] == (np.diff([0, *counts]) > 0).tolist()


@pytest.mark.parametrize("name", ENVS)
def test_an_episode_that_asks_for_any_is_over_with_the_first_catch(name):
    make, arm = ENVS[name]
    *_, last = played(make(situations=two_balls(arm, "any")))
    info = last[4]
    assert last[2] and info["outcome"] == "caught" and info["is_success"]
    assert len(info["caught"]) == 1


@pytest.mark.parametrize("name", ENVS)
def test_a_caught_target_is_observed_no_more(name):
    """The observation is that of the situation without it, at the same posture and time."""
    make, arm = ENVS[name]
    env = make(situations=two_balls(arm))
    observation, info = next((row[0], row[4]) for row in played(env) if row[4]["caught"])
    left = [body for body in env.situation.bodies if body.name not in info["caught"]]
    alone = make(situations=asking(arm, "any", *left))
    alone.reset(seed=0)
    alone.plant.state.posture[:] = env.plant.state.posture
    alone.plant.state.time[:] = env.plant.state.time
    out = alone.plant.observations
    kernels, everyone = alone.plant._kernels, np.zeros(1, np.int64)
    kernels.observe(alone.plant._world, alone.plant._arms, everyone, alone.plant._options, out)
    np.testing.assert_array_equal(out[0], observation)


@pytest.mark.parametrize(("catch", "outcome"), [("all", "late"), ("most", "caught")])
@pytest.mark.parametrize("name", ENVS)
def test_a_missed_target_is_a_failure_of_all_and_not_of_most(name, catch, outcome):
    make, arm = ENVS[name]
    (first,) = places(arm, 0.6)
    env = make(situations=asking(arm, catch, target("first", first), FAR))
    *_, (_, _, ended, late, info) = played(env)
    assert info["time"] == pytest.approx(3.0) and info["caught"] == ("first",)
    assert (info["outcome"], info["is_success"]) == (outcome, outcome == "caught")
    assert ended == (outcome == "caught") and late == (outcome == "late")


@pytest.mark.parametrize("name", ENVS)
def test_a_touch_ends_an_episode_after_a_catch(name):
    make, arm = ENVS[name]
    (first,) = places(arm, 0.6)
    hammer = solid_ball("hammer", np.add(first, (0.0, 0.0, 3.0)), (0.0, 0.0, -1.2))
    env = make(situations=asking(arm, "all", target("first", first), FAR, hammer))
    observation, _ = env.reset(seed=0)
    straight, n, over = env.settings.straight, env.settings.commands, False
    caught: tuple = ()
    while not over:
        aim = observation[straight : straight + n] if not caught else np.zeros(n)
        observation, _, ended, late, info = env.step(aim)
        caught, over = info["caught"], ended or late
    assert (info["outcome"], info["caught"]) == ("touched", ("first",))
    assert not info["is_success"] and info["reward_terms"]["touch"] < 0.0


def test_the_way_of_an_episode_is_a_plan():
    """It catches the last target by the functions that verify plans."""
    env = CatchChain(situations=two_balls(PANDA))
    *_, (*_, info) = played(env)
    scene = pack(env.situation)
    last = [body.name for body in env.situation.bodies].index(info["caught"][-1])
    assert verify(scene, rules_of(scene), env.trajectory, last).good


def test_many_arms_say_what_was_caught():
    """Step by step equal to a single one."""
    situation, one = two_balls(PANDA), CatchChain(situations=two_balls(PANDA))
    info: dict = {}
    many = CatchChains(2, situations=situation)
    straight, n = one.settings.straight, one.settings.commands
    seen, _ = many.reset(seed=0)
    for observation, reward, ended, _, said in played(one):
        info = said
        seen, rewards, over, _, told = many.step(seen[:, straight : straight + n])
        np.testing.assert_array_equal(rewards, [reward] * 2)
        if not ended:
            np.testing.assert_array_equal(seen, np.stack([observation] * 2))
    assert over.all() and list(told["final_info"]["caught"]) == [info["caught"]] * 2


def test_one_pool_holds_situations_with_one_and_with_several_targets():
    one, two = asking(PANDA, "any", two_balls(PANDA).bodies[1]), two_balls(PANDA)
    env = CatchChain(situations=[one, two, replace(two, catch="most")])
    for index, count in ((1, 2), (0, 1), (2, 2)):
        observation, info = env.reset(options={"index": index})
        assert info["caught"] == ()
        over, straight = False, env.settings.straight
        while not over:
            observation, _, over, late, info = env.step(observation[straight : straight + 7])
            assert not late
        assert len(info["caught"]) == count
