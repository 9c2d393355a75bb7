"""The batched environment: step by step the single one."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium")
from gcm_learn.envs.catch_arm import CatchArm  # noqa: E402
from gcm_learn.envs.vector import CatchArms  # noqa: E402


@pytest.mark.parametrize(
    "options",
    [{}, {"control": "joint"}, {"fan": True, "settings": {"weights": {"guide": 1.0}, "slots": 2}}],
    ids=["hand", "joint", "guide"],
)
def test_step_by_step_equal_to_single_ones(scenes, rng, options):
    n = len(scenes)
    arms = CatchArms(n, scenes, **options)
    env = CatchArm(arms.pool, **options)
    observations, _ = arms.reset(options={"index": np.arange(n)})
    batch = [(observations, None, None, None, None)]
    actions = rng.uniform(-1.2, 1.2, (90, n, 2))
    alive, lasts = np.ones((91, n), bool), {}
    for k, action in enumerate(actions):
        observations, rewards, ended, late, info = arms.step(action)
        batch.append((observations, rewards, ended, late, info["reward_terms"]))
        alive[k + 1] = alive[k] & ~(ended | late)
        for e in np.flatnonzero(alive[k] & (ended | late)):
            final = info["final_info"]
            lasts[e] = (k, info["final_obs"][e], final["outcome"][e], final["time"][e])
            assert info["_final_obs"][e] and final["index"][e] == e
    assert len(lasts) == n
    for e in range(n):
        first, _ = env.reset(options={"index": e})
        np.testing.assert_array_equal(batch[0][0][e], first)
        for k in range(lasts[e][0] + 1):
            one = env.step(actions[k, e])
            assert batch[k + 1][1][e] == one[1]
            named = {name: terms[e] for name, terms in batch[k + 1][4].items()}
            assert named == one[4]["reward_terms"]
            assert (batch[k + 1][2][e], batch[k + 1][3][e]) == (one[2], one[3])
            if alive[k + 1, e]:
                np.testing.assert_array_equal(batch[k + 1][0][e], one[0])
        np.testing.assert_array_equal(lasts[e][1], one[0])
        assert (one[4]["outcome"], one[4]["time"]) == lasts[e][2:]


def test_ended_episodes_begin_anew(scenes, rng):
    arms = CatchArms(8, scenes)
    arms.reset(seed=0)
    ends = 0
    for _ in range(200):
        observations, _, ended, late, info = arms.step(rng.uniform(-1, 1, (8, 2)))
        over = ended | late
        assert ("final_obs" in info) == over.any()
        for e in np.flatnonzero(over):
            place = arms.plant.state.place[e]
            fresh, _ = CatchArm(arms.pool).reset(options={"index": int(place)})
            np.testing.assert_array_equal(observations[e], fresh)
            ends += 1
        if ends > 12:
            break
    assert ends > 12


def test_make_vec_and_async_know_it(scenes):
    arms = gymnasium.make_vec(
        "gcm_learn:CatchArm-v0",
        num_envs=3,
        vectorization_mode="vector_entry_point",
        situations=scenes,
    )
    assert isinstance(arms.unwrapped, CatchArms)
    assert arms.reset(seed=1)[0].shape == (3, 107)
    makers = [lambda: CatchArm(scenes[:3]) for _ in range(2)]
    several = gymnasium.vector.AsyncVectorEnv(makers, context="spawn")
    try:
        first, _ = several.reset(seed=[4, 5])
        own = [CatchArm(scenes[:3]).reset(seed=s)[0] for s in (4, 5)]
        np.testing.assert_array_equal(first, np.array(own))
        several.step(np.zeros((2, 2), np.float32))
    finally:
        several.close()


def test_same_seed_same_episodes(scenes):
    seen = []
    for _ in range(2):
        arms = CatchArms(4, scenes)
        arms.reset(seed=9)
        path = [arms.step(np.full((4, 2), 0.4))[0] for _ in range(80)]
        seen.append(np.array(path))
    np.testing.assert_array_equal(*seen)


def test_threads_change_nothing(scenes, rng):
    """Whoever moves an arm, it moves the same; nor does it matter if the batch was pickled."""
    batches = [CatchArms(7, scenes, threads=n) for n in (1, 3)]
    batches.append(pickle.loads(pickle.dumps(batches[1])))
    for arms in batches:
        arms.reset(seed=3)
    for _ in range(60):
        action = rng.uniform(-1, 1, (7, 2))
        first, *others = [arms.step(action) for arms in batches]
        for other in others:
            for k in range(4):
                np.testing.assert_array_equal(first[k], other[k])
