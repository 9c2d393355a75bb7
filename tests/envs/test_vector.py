"""Batches whose episodes begin anew, in threads and in other processes."""

from __future__ import annotations

import pickle

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium")
from gcm_learn.envs.catch_arm import CatchArm  # noqa: E402
from gcm_learn.envs.vector import CatchArms  # noqa: E402


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


def test_gymnasium_s_processes_hold_it(scenes):
    makers = [lambda: CatchArm(scenes[:3]) for _ in range(2)]
    several = gymnasium.vector.AsyncVectorEnv(makers, context="spawn")
    try:
        first, _ = several.reset(seed=[4, 5])
        own = [CatchArm(scenes[:3]).reset(seed=s)[0] for s in (4, 5)]
        np.testing.assert_array_equal(first, np.array(own))
        several.step(np.zeros((2, 2), np.float32))
    finally:
        several.close()


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
