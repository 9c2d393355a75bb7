"""The batched arena as a vector environment of Stable-Baselines3."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any, Literal

import numpy as np
from gymnasium import spaces
from stable_baselines3.common.vec_env import VecEnv

from gcm_learn.envs import box, commands, finite
from gcm_learn.execution import CAUGHT, OUTCOMES, RUNNING, Batch
from gcm_learn.policies.directions import choices_in, chosen, moved
from gcm_learn.seeding import rng


class ArenaVecEnv(VecEnv):
    """Vector environment of an arena; a step that ends an episode also begins the next one.

    The horizon ends an episode for good (no ``TimeLimit.truncated``): the time left is observed,
    and no reward comes afterwards.

    Parameters
    ----------
    arms : gymnasium.vector.VectorEnv or Batch
        An environment from ``gymnasium.make_vec``, or its plant.
    seed : int
        Of the order in which situations come.
    actions : str
        Actions of the arena; or velocities as seen from the straight way, or choices of a
        direction, see `directions`.
    """

    render_mode = None

    def __init__(
        self, arms: Any, seed: int = 0, *, actions: Literal["arena", "velocity", "choice"] = "arena"
    ) -> None:
        self.plant: Any = arms if isinstance(arms, Batch) else arms.unwrapped.plant
        count, settings = self.plant.count, self.plant.settings
        turned = {"velocity": moved, "choice": chosen}.get(actions)
        self._commands = partial(turned, settings) if turned else _as_they_are
        space = commands(self.plant)
        choices = choices_in(settings) if actions == "choice" else 0
        super().__init__(count, box(self.plant), spaces.Discrete(choices) if choices else space)
        self._source = rng(seed)
        self._actions = np.zeros((count, self.plant.commands))
        self._sums, self._lengths = np.zeros(count), np.zeros(count, np.int64)

    @property
    def settings(self) -> Any:
        """Settings of the arms."""
        return self.plant.settings

    def reset(self) -> np.ndarray:
        """Begin all episodes."""
        self.plant.put(np.arange(self.num_envs), self._drawn(self.num_envs))
        self._sums[:], self._lengths[:] = 0.0, 0
        return self.plant.observations.copy()

    def _drawn(self, count: int) -> np.ndarray:
        return self._source.integers(len(self.plant.pool), size=count)

    def step_async(self, actions: np.ndarray) -> None:
        """Note actions; NaN and infinities are an error."""
        wanted = self._commands(self.plant.observations, actions)
        self._actions = finite(wanted, (self.num_envs, self.plant.commands), "ArenaVecEnv.step")

    def step_wait(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[dict[str, Any]]]:
        """Carry out the noted actions; return observations, rewards, dones and infos."""
        plant = self.plant
        outcomes = plant.move(self._actions)
        rewards = plant.rewards.astype(np.float32)
        self._sums += rewards
        self._lengths += 1
        over = outcomes != RUNNING
        infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        arms = np.flatnonzero(over)
        for e in arms:
            infos[e] = {
                "terminal_observation": plant.observations[e].copy(),
                "is_success": bool(outcomes[e] == CAUGHT),
                "outcome": OUTCOMES[outcomes[e]],
                "episode": {"r": float(self._sums[e]), "l": int(self._lengths[e]), "t": 0.0},
            }
        if len(arms):
            self._sums[arms], self._lengths[arms] = 0.0, 0
            plant.put(arms, self._drawn(len(arms)))
        return plant.observations.copy(), rewards, over, infos

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """Begin the order of situations anew."""
        if seed is not None:
            self._source = rng(seed)
        return [seed] * self.num_envs

    def close(self) -> None:
        """Nothing has to be closed."""

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """An attribute of the whole, once for each arm."""
        return [getattr(self, attr_name)] * len(list(self._get_indices(indices)))

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Arms have no attributes of their own."""
        raise NotImplementedError("arms of a batch cannot be changed one by one")

    def env_method(
        self, method_name: str, *method_args: Any, indices: Any = None, **method_kwargs: Any
    ) -> list[Any]:
        """Arms have no methods of their own."""
        raise NotImplementedError("arms of a batch have no methods of their own")

    def env_is_wrapped(self, wrapper_class: type, indices: Any = None) -> list[bool]:
        """No arm is wrapped."""
        return [False] * len(list(self._get_indices(indices)))


def _as_they_are(observations: np.ndarray, actions: np.ndarray) -> np.ndarray:
    return actions
