"""PPO, SAC and TQC of Stable-Baselines3 in the batched arena, and their actors."""

from __future__ import annotations

import ctypes
import json
import zipfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.base_class import BaseAlgorithm
from stable_baselines3.common.callbacks import BaseCallback
from stable_baselines3.common.off_policy_algorithm import OffPolicyAlgorithm
from stable_baselines3.common.policies import ActorCriticPolicy
from stable_baselines3.common.save_util import load_from_zip_file
from stable_baselines3.common.torch_layers import MlpExtractor
from stable_baselines3.common.vec_env import VecNormalize
from torch import nn

from gcm_learn.arms import PLANAR, ByKind
from gcm_learn.errors import PolicyError
from gcm_learn.execution import RUNNING, ArenaSettings, Pool, Steps, plant_of
from gcm_learn.policies.actor import CLIP, LEARNER, Actor
from gcm_learn.policies.cloning import layers_of
from gcm_learn.policies.directions import said
from gcm_learn.policies.plan import WHOLE, TrainingPlan, algorithm
from gcm_learn.policies.vec_env import ArenaVecEnv
from gcm_learn.storage import whole_file

STATISTICS, BUFFER = "normalisation.npz", "buffer.npz"
_PICKLES = ("normalisation.pkl", "buffer.pkl")  # of older versions
_SCALES = ("mean", "var", "count")
_STEPS = ("observations", "next_observations", "actions", "rewards", "dones", "timeouts")
_COUNTS = ("num_timesteps", "_n_updates", "_episode_num")
_DRAWN_ANEW = ("_last_obs", "_last_original_obs", "_last_episode_starts", "ep_info_buffer")
"""Attributes of learners that a run which goes on does not need."""
_SEEN = 1e12  # observations, after which new ones hardly move the statistics
_EPSILON = 1e-8  # of VecNormalize
_NETWORK = "256,256"
_LEAN = ByKind({PLANAR: 0.0}, default=2.0)
"""Logit by which a learner first prefers the choice that goes straight."""


def make(plan: TrainingPlan, pool: Pool, logs: Path) -> BaseAlgorithm:
    """Return a new learner, with the network of `plan.start` if there is one."""
    model = _untrained(plan, pool, logs)
    if plan.start:
        begin_as(model, Actor.load(Path(plan.start)))
    elif plan.actions == "choice":
        with torch.no_grad():
            model.policy.action_net.bias[0] += _LEAN.of(plan.kind)  # type: ignore[operator,union-attr]
    return model


def _untrained(plan: TrainingPlan, pool: Pool, logs: Path) -> BaseAlgorithm:
    """Return a new learner with the initial weights of its library."""
    env = normalised(plan, pool)
    wanted = dict(plan.hyperparameters)
    layers = _units(wanted.pop("net_arch", _NETWORK))
    policy: Any = str(wanted.pop("policy", "MlpPolicy"))
    made: dict[str, Any] = {"net_arch": layers, "activation_fn": nn.ReLU}
    if plan.algo == "ppo":
        value = wanted.pop("value_arch", None)
        made["net_arch"] = {"pi": layers, "vf": layers if value is None else _units(value)}
        made["optimizer_kwargs"] = {"eps": 1e-5, "fused": True}  # eps as the library has it
        policy = Bfloat16Policy if wanted.pop("bfloat16", False) else policy
    if "log_std_init" in wanted:
        made["log_std_init"] = float(wanted.pop("log_std_init"))
    wanted |= {name: int(wanted[name]) for name in WHOLE if name in wanted}
    try:
        made_model: BaseAlgorithm = algorithm(plan.algo)(
            policy, env, seed=plan.seed, tensorboard_log=str(logs), device="cpu",
            policy_kwargs=made, **wanted,
        )  # fmt: skip
    except TypeError as error:
        raise PolicyError(str(error).replace("\n", " ")) from None
    return made_model


def _units(text: Any) -> list[int]:
    """Return the numbers of units of layers, which are written as 256,256."""
    return [int(n) for n in str(text).split(",")]


def normalised(plan: TrainingPlan, pool: Pool) -> VecNormalize:
    """Return the batched arena, with scaled observations if the plan says so."""
    plant = plant_of(pool, plan.n_envs, plan.settings)
    env = ArenaVecEnv(plant, plan.seed, actions=plan.actions)
    gamma = float(plan.hyperparameters.get("gamma", 0.99))
    return VecNormalize(
        env,
        norm_obs=plan.normalize,
        norm_reward=False,
        clip_obs=CLIP,
        gamma=gamma,
        epsilon=_EPSILON,
    )


def begin_as(model: BaseAlgorithm, actor: Actor) -> None:
    """Let a learner begin with an actor's network and scaling, which then stays.

    The critic begins anew.
    """
    env = model.get_env()
    assert isinstance(env, VecNormalize)
    linear = [m for part in acting(model) for m in part.modules() if isinstance(m, nn.Linear)]
    shapes = [tuple(m.weight.shape) for m in linear]
    if shapes != [w.shape for w, _ in actor.layers]:
        raise PolicyError(f"start: its layers are {[w.shape for w, _ in actor.layers]}")
    with torch.no_grad():
        for module, (weights, bias) in zip(linear, actor.layers, strict=True):
            module.weight.copy_(torch.from_numpy(weights))
            module.bias.copy_(torch.from_numpy(bias))
        if not isinstance(model, PPO):  # whose spread depends on what is told
            model.policy.actor.log_std.weight.zero_()
            model.policy.actor.log_std.bias.copy_(torch.from_numpy(actor.spread))
    env.obs_rms.mean[:] = actor.mean
    env.obs_rms.var[:] = actor.deviation.astype(float) ** 2
    env.obs_rms.count = _SEEN  # statistics of the demonstrations: new ones hardly move them


def acting(model: BaseAlgorithm) -> tuple[nn.Module, ...]:
    """Return the parts of the network that lead from observations to actions."""
    if isinstance(model, PPO):
        return model.policy.mlp_extractor.policy_net, model.policy.action_net
    return model.policy.actor.latent_pi, model.policy.actor.mu


class Checks(BaseCallback):
    """Callback that calls `check` every `every` steps, and ends learning when `check` returns true.

    Parameters
    ----------
    every : int
        Steps of all arms together.
    check : callable
        Returns whether learning is over.
    """

    def __init__(self, every: int, check: Callable[[], bool]) -> None:
        super().__init__()
        self._every, self._check, self.over = every, check, False

    def _on_training_start(self) -> None:
        self._due = self.model.num_timesteps + self._every

    def _on_rollout_start(self) -> None:
        if self.model.num_timesteps >= self._due:
            self._due = self.model.num_timesteps + self._every
            self.over = self._check()

    def _on_step(self) -> bool:
        return not self.over


def show(model: BaseAlgorithm, moves: Steps, settings: ArenaSettings) -> None:
    """Add the steps of demonstrations to a learner's replay buffer."""
    env, buffer = model.get_env(), model.replay_buffer  # type: ignore[attr-defined]
    assert isinstance(env, VecNormalize)
    if env.obs_rms.count < _SEEN:
        env.obs_rms.update(moves.told)
    aimed = said(settings, moves.told, moves.actions).astype(np.float32)
    ended = moves.outcomes != RUNNING
    nothing = [dict[str, bool]() for _ in range(env.num_envs)]
    for first in range(0, len(moves.arms) - env.num_envs + 1, env.num_envs):
        rows = slice(first, first + env.num_envs)
        buffer.add(moves.told[rows], moves.following[rows], aimed[rows],
                   moves.rewards[rows], ended[rows], nothing)  # fmt: skip


def actor_of(model: BaseAlgorithm, plan: TrainingPlan) -> Actor:
    """Return the learner's present policy as plain arrays."""
    env = model.get_env()
    assert isinstance(env, VecNormalize)
    width = env.observation_space.shape[0]
    mean, deviation = np.zeros(width), np.ones(width)
    if plan.normalize:
        mean, deviation = env.obs_rms.mean.copy(), np.sqrt(env.obs_rms.var + _EPSILON)
    choice, spread = plan.actions == "choice", np.zeros(plan.settings.commands)
    if isinstance(model, PPO) and not choice:
        spread = model.policy.log_std.detach().numpy().astype(float)
    layers = [layers_of(part) for part in acting(model)]
    return Actor(
        layers=layers[0] + layers[1], mean=mean, deviation=deviation,
        head="choice" if choice else "velocity", activation="relu",
        squash=not choice and plan.algo != "ppo", spread=spread, settings=replace(plan.settings),
    )  # fmt: skip


def keep(model: BaseAlgorithm, folder: Path) -> None:
    """Write the files that `go_on` needs; a file is replaced once the new one is complete."""
    env = model.get_env()
    assert isinstance(env, VecNormalize)
    with whole_file(folder / LEARNER) as place:
        model.save(place, exclude=_DRAWN_ANEW)
    with whole_file(folder / STATISTICS) as place:
        np.savez(place, **{name: getattr(env.obs_rms, name) for name in _SCALES})
    if isinstance(model, OffPolicyAlgorithm):
        buffer: Any = model.replay_buffer
        steps = {name: getattr(buffer, name)[: buffer.size()] for name in _STEPS}
        with whole_file(folder / BUFFER) as place:
            np.savez(place, next_place=buffer.pos, **steps)


def go_on(plan: TrainingPlan, pool: Pool, folder: Path) -> BaseAlgorithm:
    """Return the learner that `keep` wrote into a folder; no pickles are read.

    Raises
    ------
    PolicyError
        If an older version wrote the folder, in pickles.
    """
    for name in _PICKLES:
        if (folder / name).exists():
            raise PolicyError(f"{folder / name}: pickles are not read; train in another folder")
    model = _untrained(plan, pool, folder / "tensorboard")
    env = model.get_env()
    assert isinstance(env, VecNormalize)
    _, states, variables = load_from_zip_file(folder / LEARNER, load_data=False, device="cpu")
    model.set_parameters(states, device="cpu")
    for name, values in (variables or {}).items():
        getattr(model, name).data = values.data
    for name, count in _counts(folder / LEARNER).items():
        setattr(model, name, count)
    with np.load(folder / STATISTICS, allow_pickle=False) as scales:
        for name in _SCALES:
            setattr(env.obs_rms, name, scales[name])
    if isinstance(model, OffPolicyAlgorithm):
        _fill(model.replay_buffer, folder / BUFFER)
    env.venv.seed(plan.seed + 1 + model.num_timesteps)  # other situations than at the beginning
    return model


def _counts(path: Path) -> dict[str, int]:
    """Return the counts of steps in a model's file, from its JSON alone."""
    with zipfile.ZipFile(path) as archive:
        data = json.loads(archive.read("data"))
    return {name: data[name] for name in _COUNTS if name in data}


def _fill(buffer: Any, path: Path) -> None:
    """Fill a replay buffer with the steps in a file."""
    with np.load(path, allow_pickle=False) as kept:
        for name in _STEPS:
            getattr(buffer, name)[: len(kept[name])] = kept[name]
        buffer.pos = int(kept["next_place"])
        buffer.full = len(kept["rewards"]) == buffer.buffer_size


class Bfloat16Policy(ActorCriticPolicy):
    """Policy and value of PPO; weights, heads, losses and optimiser stay float32."""

    def _build_mlp_extractor(self) -> None:
        self.mlp_extractor = _Layers(
            self.features_dim, self.net_arch, self.activation_fn, self.device
        )


class _Layers(MlpExtractor):
    """Layers before the heads, from features (n, width) to latent numbers (n, units) float32."""

    def forward_actor(self, features: torch.Tensor) -> torch.Tensor:
        """Compute the latent numbers of the policy."""
        with torch.autocast("cpu", torch.bfloat16):
            return super().forward_actor(features).float()

    def forward_critic(self, features: torch.Tensor) -> torch.Tensor:
        """Compute the latent numbers of the value."""
        with torch.autocast("cpu", torch.bfloat16):
            return super().forward_critic(features).float()


_KEPT = {-1: 1 << 30, -3: 32 << 20}
"""Bytes for glibc's mallopt: freed ones that stay (M_TRIM_THRESHOLD), and up to which blocks are
taken from them (M_MMAP_THRESHOLD)."""


def keep_memory() -> None:
    """Let this process keep freed memory; taking pages anew costs a quarter of a gradient step.

    Nothing happens where there is no mallopt.
    """
    mallopt = getattr(ctypes.CDLL(None), "mallopt", lambda which, size: 0)
    for which, size in _KEPT.items():
        mallopt(which, size)
