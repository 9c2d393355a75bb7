"""Policies and Stable-Baselines3 models from outside of the package.

A file of such a model is a ZIP archive, read without running code that it brings along.  Weights in
it are tensors, which torch reads with ``weights_only=True``.  Spaces, the policy's class and its
arguments are pickles; here they may only name classes of Gymnasium, NumPy, torch and
Stable-Baselines3.
"""

from __future__ import annotations

import base64
import inspect
import io
import json
import pickle
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from gcm_learn.errors import MissingExtraError, PolicyError, UnknownNameError
from gcm_learn.execution import ARENAS, ArenaSettings, Settings
from gcm_learn.planners import in_words, name_of
from gcm_learn.policies.actor import Acting, ActorPlanner

NEEDED = ("policy_class", "observation_space", "action_space", "policy_kwargs")
SCALED = ("vecnormalize.pkl", "vec_normalize.pkl")  # statistics that are kept beside models
ARRAYS = (
    "_reconstruct", "scalar", "_frombuffer", "__generator_ctor", "__bit_generator_ctor",
    "__pyx_unpickle_SeedSequence",
)  # fmt: skip
"""Functions of NumPy that make arrays and generators."""
PLACES = (
    "gymnasium.spaces", "numpy", "stable_baselines3", "sb3_contrib", "torch.nn.modules",
    "torch.optim",
)  # fmt: skip


def read_model(path: Path) -> Any:
    """Return the policy in a model file of Stable-Baselines3, whatever the algorithm.

    Parameters
    ----------
    path : Path

    Raises
    ------
    UnknownNameError
        If there is no such file.
    MissingExtraError
        Without Stable-Baselines3.
    PolicyError
        If it is no model, if it needs code of its own, or if its observations were scaled.
    """
    if not path.is_file():
        raise UnknownNameError(f"{str(path)!r}: there is no such file")
    _refuse_scaled(path)
    try:
        from stable_baselines3.common.save_util import load_from_zip_file
    except ImportError:
        raise MissingExtraError(f"{path.name!r}", "stable_baselines3", "rl") from None
    try:
        data = _data(path)
        made, space, actions, more = (data[name] for name in NEEDED)
        noise = {"use_sde": True} if data["use_sde"] else {}
        policy = made(space, actions, lambda progress: 0.0, **more | noise)
        _, states, _ = load_from_zip_file(path, load_data=False, device="cpu")
        policy.load_state_dict(states["policy"])
    except PolicyError:
        raise
    except Exception as error:
        reason = f"is no model of Stable-Baselines3 ({in_words(error)})"
        raise PolicyError(f"{str(path)!r}: {reason}") from error
    policy.set_training_mode(False)
    return policy


def _refuse_scaled(path: Path) -> None:
    """Refuse a model beside which the statistics of `VecNormalize` are kept."""
    for name in SCALED:
        if path.with_name(name).exists():
            raise PolicyError(
                f"{str(path)!r}: its observations were scaled ({name}); "
                "load both yourself, and give the model with its environment as an object"
            )


def _data(path: Path) -> dict[str, Any]:
    """Return the entries of a model's data that its policy needs (`NEEDED` and `use_sde`)."""
    with zipfile.ZipFile(path) as archive:
        kept = json.loads(archive.read("data"))
    found: dict[str, Any] = {"use_sde": kept.get("use_sde", False)}
    for name in NEEDED:
        value = kept[name]
        if isinstance(value, dict) and ":serialized:" in value:
            pickled = base64.b64decode(value[":serialized:"])
            value = _Reader(io.BytesIO(pickled), f"{str(path)!r}: {name}").load()
        found[name] = value
    return found


class _Reader(pickle.Unpickler):
    """Reader of pickles that makes spaces, arrays and classes of policies only.

    Parameters
    ----------
    stream : binary stream
    about : str
        Name of the pickle in messages.
    """

    def __init__(self, stream: io.BytesIO, about: str) -> None:
        super().__init__(stream)
        self._about = about

    def find_class(self, module: str, name: str) -> Any:
        """Return a class by its name; refuse classes that pickles must not name."""
        if (module, name) == ("collections", "OrderedDict"):
            return super().find_class(module, name)
        if any(module == place or module.startswith(f"{place}.") for place in PLACES):
            found = super().find_class(module, name)
            array = module.startswith("numpy.") and name in ARRAYS
            if array or (isinstance(found, type) and issubclass(found, _allowed())):
                return found
        raise PolicyError(
            f"{self._about} needs {module}.{name}, which is not run from a file; "
            "load the model yourself and give it as an object"
        )


def _allowed() -> tuple[type, ...]:
    """Return the base classes of the classes that pickles may name."""
    import numpy as np
    from gymnasium.spaces import Space
    from stable_baselines3.common.policies import BasePolicy
    from stable_baselines3.common.torch_layers import BaseFeaturesExtractor
    from torch.nn import Module
    from torch.optim import Optimizer

    arrays = (np.ndarray, np.dtype, np.generic)
    draws = (np.random.Generator, np.random.BitGenerator, np.random.SeedSequence)
    return (Space, BasePolicy, BaseFeaturesExtractor, Module, Optimizer, *arrays, *draws)


class OwnPolicy(Acting):
    """A policy from outside, in the arena for which it was made.

    Parameters
    ----------
    policy : object
        With `act`, from observations (n, width) to actions (n, commands) from -1 to 1; or with
        `predict`, from an observation (width,) to an action and a state, as models of
        Stable-Baselines3 have it.
    name : str, optional
    settings : ArenaSettings, optional
        Of its arena.  By default those in the attribute `settings` of the policy, those of the
        environment that it holds, or else the first arena whose spaces fit.

    Raises
    ------
    PolicyError
        If its spaces fit no arena.
    """

    def __init__(self, policy: Any, name: str = "", settings: ArenaSettings | None = None) -> None:
        self.policy, self.name = policy, name or name_of(policy)
        self.settings = settings or _settings_of(policy, self.name)
        _check_spaces(policy, self.settings, self.name)
        self._act: Callable[[np.ndarray], Any] = getattr(policy, "act", None) or _predicting(
            policy, self.name
        )

    def act(self, observations: np.ndarray, rng: np.random.Generator | None = None) -> np.ndarray:
        """Return actions (n, commands); numbers beyond -1 and 1 are cut, as environments do.

        Raises
        ------
        PolicyError
            If they are no numbers, or too few or many.
        """
        actions = np.array(self._act(observations.copy()), dtype=np.float64)
        wanted = (len(observations), self.settings.commands)
        if actions.shape != wanted:
            raise PolicyError(f"{self.name}: actions need shape {wanted}, got {actions.shape}")
        if not np.isfinite(actions).all():
            raise PolicyError(f"{self.name}: actions have numbers that are not finite")
        return np.clip(actions, -1.0, 1.0)


def own_policy(given: Any, name: str = "") -> OwnPolicy:
    """Return a policy from outside: from an object, or from the file of a model."""
    return OwnPolicy(read_model(given) if isinstance(given, Path) else given, name)


def planner_of(given: Any, name: str) -> ActorPlanner:
    """Return the planner that tries a policy from outside out, once."""
    return ActorPlanner(own_policy(given, name), name, tries=1)


def _predicting(model: Any, name: str) -> Callable[[np.ndarray], np.ndarray]:
    """Return the most likely actions of a model, asked row by row.

    Observations are scaled first if the model holds an environment that scales them.
    """
    named = inspect.signature(model.predict).parameters
    how = {"deterministic": True} if "deterministic" in named else {}
    scaling = getattr(model, "get_vec_normalize_env", lambda: None)()
    scaled = (lambda seen: seen) if scaling is None else scaling.normalize_obs

    def act(observations: np.ndarray) -> np.ndarray:
        return np.stack([_action(model.predict(row, **how), name) for row in scaled(observations)])

    return act


def _action(predicted: Any, name: str) -> np.ndarray:
    """Return the action in a result of `predict`: the action itself, or a pair (action, state)."""
    if not isinstance(predicted, tuple):
        return np.asarray(predicted)
    action, state = predicted
    if state is not None:
        raise PolicyError(f"policy {name!r}: is recurrent; here a policy sees one observation")
    return np.asarray(action)


def _settings_of(policy: Any, name: str) -> ArenaSettings:
    """Return the settings for which a policy was made."""
    told = getattr(policy, "settings", None) or _of_environment(policy)
    if isinstance(told, ArenaSettings):
        return told
    observed, actions = _shape(policy, "observation_space"), _shape(policy, "action_space")
    if observed is None and actions is None:
        return Settings()
    for settings in _candidates(observed):
        if observed == (settings.width,) and actions == (settings.commands,):
            return settings
    arenas = ", ".join(
        f"{a.name} {(a.settings().width,)} and {(a.settings().commands,)}" for a in _arenas()
    )
    raise PolicyError(
        f"policy {name!r}: observations {observed} and actions {actions} fit no arena ({arenas})"
    )


def _of_environment(policy: Any) -> Any:
    """Return the settings of a model's environment, or None."""
    try:
        return policy.get_env().get_attr("settings")[0]
    except Exception:  # no environment, or one that is not ours
        return None


def _candidates(space: tuple[int, ...] | None) -> list[ArenaSettings]:
    """Return settings of the arenas: by default, then with a fan, then with 0 to 64 slots."""
    plain = [arena.settings() for arena in _arenas()]
    fans = [arena.settings(fan=True) for arena in _arenas() if arena.settings.has_fan]
    kinds = [(arena, fan) for arena in _arenas() for fan in (False, True)]
    slots = [arena.settings(fan=fan, slots=n) for arena, fan in kinds
             if arena.settings.has_fan or not fan for n in range(65)]  # fmt: skip
    return [*plain, *fans, *slots]


def _arenas() -> list[Any]:
    """Return the arenas that a policy's spaces are compared with by default."""
    return [arena for arena in ARENAS.values() if arena.followed]


def _check_spaces(policy: Any, settings: ArenaSettings, name: str) -> None:
    """Refuse a policy if its spaces and the spaces of its arena differ."""
    for which, size in (("observation_space", settings.width), ("action_space", settings.commands)):
        shape = _shape(policy, which)
        wide = which == "observation_space" and getattr(settings, "embedding", False)
        if shape not in (None, (size,)) and not wide:
            raise PolicyError(f"policy {name!r}: {which} {shape} is not {(size,)}, as the arena's")
    space: Any = getattr(policy, "action_space", None)
    low, high = getattr(space, "low", -1.0), getattr(space, "high", 1.0)
    if np.any(np.asarray(low) != -1.0) or np.any(np.asarray(high) != 1.0):
        raise PolicyError(f"policy {name!r}: action_space is not from -1 to 1, as the arena's")


def _shape(policy: Any, which: str) -> tuple[int, ...] | None:
    """Return the shape of a space if a policy has that space, else None."""
    found = getattr(policy, which, None)
    return None if found is None else tuple(getattr(found, "shape", None) or ())
