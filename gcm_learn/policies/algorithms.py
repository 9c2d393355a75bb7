"""Learning algorithms by name, and the hyperparameters that each of them takes."""

from __future__ import annotations

import dataclasses
import inspect
from typing import TYPE_CHECKING

from gcm_learn.errors import MissingExtraError

if TYPE_CHECKING:
    from stable_baselines3.common.base_class import BaseAlgorithm

ALGORITHMS = ("clone", "ppo", "sac", "tqc")
WHOLE = ("n_steps", "batch_size", "n_epochs", "buffer_size", "learning_starts", "train_freq",
         "gradient_steps", "epochs", "batch")  # fmt: skip
"""Hyperparameters that are whole numbers."""
_OURS = ("policy", "env", "seed", "tensorboard_log", "device", "policy_kwargs", "_init_setup_model")
"""Arguments of Stable-Baselines3 that a training run gives itself."""
_ADDED = ("policy", "net_arch", "log_std_init")


def algorithm(name: str) -> type[BaseAlgorithm]:
    """Return the class behind a name; TQC is one of sb3-contrib."""
    if name == "tqc":
        try:
            from sb3_contrib import TQC
        except ImportError:
            raise MissingExtraError("tqc", "sb3-contrib", "rl") from None
        return TQC
    try:
        from stable_baselines3 import PPO, SAC
    except ImportError:
        raise MissingExtraError(name, "stable-baselines3", "rl") from None
    return {"ppo": PPO, "sac": SAC}[name]


def hyperparameters(name: str) -> set[str]:
    """Return the names of the hyperparameters that a file may give to an algorithm."""
    if name == "clone":
        from gcm_learn.policies.cloning import Cloning

        return {f.name for f in dataclasses.fields(Cloning)} - {"layers"} | {"net_arch"}
    return set(inspect.signature(algorithm(name)).parameters) - set(_OURS) | set(_ADDED)
