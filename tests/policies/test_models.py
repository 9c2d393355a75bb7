"""Models of Stable-Baselines3 from outside: files without code, scaled and recurrent ones."""

import base64
import json
import pickle
import zipfile

import numpy as np
import pytest

from gcm_learn.errors import PolicyError
from gcm_learn.policies.outside import own_policy, read_model

pytest.importorskip("stable_baselines3")
pytest.importorskip("sb3_contrib")
import gymnasium
import torch
from sb3_contrib import TQC, RecurrentPPO
from stable_baselines3 import A2C, PPO, SAC
from stable_baselines3.common.callbacks import EvalCallback
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.save_util import load_from_pkl
from stable_baselines3.common.vec_env import DummyVecEnv, VecNormalize

from gcm_learn.policies import ArenaVecEnv


def arena():
    """Return an environment with few situations."""
    return gymnasium.make("gcm_learn:CatchArm-v0", situations="moving-point", pool=2)


@pytest.fixture(scope="module")
def seen():
    """Return some observations."""
    env = arena()
    return np.array([env.reset(seed=k)[0] for k in range(3)])


MODELS = {
    "ppo": lambda **how: PPO("MlpPolicy", arena(), n_steps=8, batch_size=8, **how),
    "sde": lambda **how: A2C("MlpPolicy", arena(), use_sde=True, **how),
    "sac": lambda **how: SAC("MlpPolicy", arena(), buffer_size=10, **how),
    "tqc": lambda **how: TQC("MlpPolicy", arena(), buffer_size=10, **how),
}


@pytest.mark.parametrize("name", MODELS)
def test_files_of_models_act_as_the_models(name, tmp_path, monkeypatch, seen):
    model = MODELS[name](policy_kwargs={"net_arch": [8], "activation_fn": torch.nn.ELU})
    model.action_space.sample()  # so that the file holds a random generator
    model.save(tmp_path / "model.zip")
    monkeypatch.setattr("cloudpickle.loads", None)
    monkeypatch.setattr(pickle, "loads", None)
    actions = own_policy(tmp_path / "model.zip").act(seen)
    np.testing.assert_array_equal(actions, own_policy(model, name).act(seen))


class Boom:
    """Code that would run if it were unpickled."""

    def __init__(self, call, *arguments):
        self.call, self.arguments = call, arguments

    def __reduce__(self):
        return self.call, self.arguments


@pytest.mark.parametrize(
    ("call", "about"),
    [
        (print, r"builtins\.print"),
        (exec, r"builtins\.exec"),
        (load_from_pkl, r".*save_util\.load_from_pkl"),
        (torch.load, r"torch\.\S*load"),
    ],
)
def test_code_in_a_file_is_not_run(call, about, tmp_path, capfd):
    path = tmp_path / "model.zip"
    MODELS["ppo"]().save(path)
    with zipfile.ZipFile(path) as archive:
        parts = {name: archive.read(name) for name in archive.namelist()}
    data = json.loads(parts["data"])
    boom = base64.b64encode(pickle.dumps({"net_arch": Boom(call, "boom")})).decode()
    data["policy_kwargs"] = {":type:": "dict", ":serialized:": boom}
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in parts.items():
            archive.writestr(name, json.dumps(data) if name == "data" else content)
    with pytest.raises(PolicyError, match=rf"policy_kwargs needs {about}, which is not run"):
        read_model(path)
    assert "boom" not in capfd.readouterr().out


def test_observations_are_scaled_for_an_object_and_refused_for_a_file(tmp_path, seen):
    env = VecNormalize(DummyVecEnv([arena]))
    model = PPO("MlpPolicy", env, n_steps=16, batch_size=16)
    judge = VecNormalize(DummyVecEnv([lambda: Monitor(arena())]), training=False)
    told = EvalCallback(judge, n_eval_episodes=1, eval_freq=8, verbose=0)
    model.learn(16, callback=told)
    assert told.n_calls == 16 and np.isfinite(told.last_mean_reward)
    actions = own_policy(model, "scaled").act(seen)
    wanted = model.predict(env.normalize_obs(seen), deterministic=True)[0]
    np.testing.assert_allclose(actions, np.clip(wanted, -1.0, 1.0), atol=1e-6)
    model.save(tmp_path / "model.zip")
    env.save(str(tmp_path / "vecnormalize.pkl"))
    with pytest.raises(PolicyError, match=r"were scaled \(vecnormalize.pkl\); load both yourself"):
        own_policy(tmp_path / "model.zip")


def test_recurrent_policies_are_refused(tmp_path, seen):
    model = RecurrentPPO("MlpLstmPolicy", arena(), n_steps=8, batch_size=8)
    model.save(tmp_path / "model.zip")
    for given in (model, tmp_path / "model.zip"):
        with pytest.raises(PolicyError, match="is recurrent; here a policy sees one observation"):
            own_policy(given, "memory").act(seen)


def test_the_batched_arena_is_one_for_learners_step_by_step_that_of_gymnasium():
    """Same situations and actions: same observations and rewards, until the first episode ends."""
    made = [
        gymnasium.make_vec("gcm_learn:CatchArm-v0", num_envs=4, situations="moving-point", pool=2,
                           vectorization_mode="vector_entry_point") for _ in range(2)
    ]  # fmt: skip
    env = ArenaVecEnv(made[0], seed=3)
    seen = env.reset()
    there, _ = made[1].reset(options={"index": env.plant.state.place})
    actions, over = env.action_space.sample() * np.ones((4, 1), np.float32), np.zeros(4, bool)
    while not over.any():
        np.testing.assert_array_equal(seen, there)
        there, rewards, ended, late, _ = made[1].step(actions)
        seen, mine, over, infos = env.step(actions)
        np.testing.assert_array_equal(mine, rewards.astype(np.float32))
        np.testing.assert_array_equal(over, ended | late)
    first = int(np.flatnonzero(over)[0])
    assert infos[first]["episode"]["l"] > 1 and len(infos[first]["terminal_observation"]) == 107


def test_stable_baselines_learns_in_the_batched_arena():
    arms = gymnasium.make_vec("gcm_learn:CatchArm-v0", num_envs=4, situations="moving-point",
                              pool=2, vectorization_mode="vector_entry_point")  # fmt: skip
    model = PPO("MlpPolicy", ArenaVecEnv(arms), n_steps=8, batch_size=8).learn(32)
    assert model.num_timesteps == 32
    assert own_policy(model).settings is arms.settings
