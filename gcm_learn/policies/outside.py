"""Policies and Stable-Baselines3 models from outside of the package."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from gcm_learn.errors import PolicyError
from gcm_learn.execution import ARENAS, ArenaSettings, Settings
from gcm_learn.planners import name_of
from gcm_learn.policies.actor import Acting
from gcm_learn.policies.model_file import read_model
from gcm_learn.policies.planner import ActorPlanner


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
    """Return the action of what `predict` returns: a pair with a state, or the action itself."""
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
    """Return the settings of the environment that a model holds, if it does."""
    try:
        return policy.get_env().get_attr("settings")[0]
    except Exception:  # no environment, or one that is not ours
        return None


def _candidates(space: tuple[int, ...] | None) -> list[ArenaSettings]:
    """Return settings of all arenas: the default ones, with a fan, with other numbers of slots."""
    plain = [arena.settings() for arena in _arenas()]
    fans = [arena.settings(fan=True) for arena in _arenas() if arena.settings.has_fan]
    kinds = [(arena, fan) for arena in _arenas() for fan in (False, True)]
    slots = [arena.settings(fan=fan, slots=n) for arena, fan in kinds
             if arena.settings.has_fan or not fan for n in range(65)]  # fmt: skip
    return [*plain, *fans, *slots]


def _arenas() -> list[Any]:
    """Return the arenas whose policies are compared by default."""
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
