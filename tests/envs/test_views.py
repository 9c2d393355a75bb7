"""Observations with maps and embeddings."""

import numpy as np
import pytest

from gcm_learn.errors import ArenaError
from gcm_learn.maps import build_map
from gcm_learn.wave import MarchingParams

gymnasium = pytest.importorskip("gymnasium")
from gcm_learn.envs import CatchArm, CatchArms, WithMap  # noqa: E402
from gcm_learn.envs.views import map_image  # noqa: E402
from gcm_learn.execution.arena.settings import encoder  # noqa: E402


def test_the_picture_says_what_the_map_does(scenes):
    env = WithMap(CatchArm(scenes))
    for index in (0, 7, 12):
        seen, _ = env.reset(options={"index": index})
        picture, made = seen["map"][0], build_map(env.arm.situation, MarchingParams(n=80))
        assert picture.dtype == np.uint8 and picture.shape == (80, 80)
        np.testing.assert_array_equal(picture == 0, made.effective_obstacles)
        reached = picture >= 64
        np.testing.assert_array_equal(reached, ~np.ma.getmaskarray(made.arrival))
        order = np.argsort(made.arrival[reached].data)
        assert np.all(np.diff(picture[reached][order].astype(int)) <= 0)
        step = env.step(np.zeros(2, np.float32))[0]
        np.testing.assert_array_equal(step["map"][0], picture)
        np.testing.assert_array_equal(step["state"], env.arm.plant.observations[0])
    alone, _ = WithMap(CatchArm(scenes), only=True).reset(options={"index": 7})
    np.testing.assert_array_equal(alone, map_image(CatchArm(scenes).pool.situations[7]))


def test_the_embedding_is_the_situations(scenes):
    pytest.importorskip("safetensors")
    plain, env = CatchArm(scenes), CatchArm(scenes, embedding=True)
    many = CatchArms(2, scenes, embedding=True)
    width = plain.settings.width
    batch, _ = many.reset(options={"index": np.array([12, 0])})
    for index, row in ((0, 1), (12, 0)):
        state, _ = plain.reset(options={"index": index})
        seen, _ = env.reset(options={"index": index})
        np.testing.assert_array_equal(seen[:width], state)
        np.testing.assert_array_equal(seen, batch[row])
        known = encoder().embed_situation(scenes[index])  # in the frame in which it was drawn
        np.testing.assert_allclose(seen[width:], known, rtol=1e-3, atol=1e-3)
        assert np.any(seen[width:] != 0.0)
        later = env.step(np.zeros(2, np.float32))[0]
        np.testing.assert_array_equal(later[width:], seen[width:])
    other, _ = env.reset(options={"situation": scenes[5]})
    np.testing.assert_array_equal(other, env.reset(options={"index": 5})[0])


def test_checkers_accept_them(scenes):
    from gymnasium.utils.env_checker import check_env as accept

    check = pytest.importorskip("stable_baselines3.common.env_checker")
    pytest.importorskip("safetensors")
    for env in (WithMap(CatchArm(scenes[:4])), CatchArm(scenes[:4], embedding=True)):
        accept(env, skip_render_check=True)
        check.check_env(env)
    with pytest.raises(ArenaError, match="env: must be a CatchArm"):
        WithMap(gymnasium.make("Pendulum-v1"))
