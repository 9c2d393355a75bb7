"""Observations with a cognitive map: its picture, or an encoder's embedding of the situation.

Both follow from the situation at t = 0, so they stay the same during an episode.

>>> import gymnasium
>>> from gcm_learn.envs import WithEmbedding, WithMap
>>> env = WithMap(gymnasium.make("gcm_learn:CatchArm-v0"))
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import gymnasium
import numpy as np
from gymnasium import spaces

from gcm_learn.envs.catch_arm import CatchArm
from gcm_learn.errors import ArenaError
from gcm_learn.maps import build_map
from gcm_learn.situation import Situation
from gcm_learn.wave import MarchingParams

if TYPE_CHECKING:
    from gcm_learn.encoder.towers import Encoder

CELLS = 80  # along a side of a map
OBSTACLE, UNREACHED, LAST, FIRST = 0, 32, 64, 255  # brightness of cells
LARGEST = 100.0  # bound of embeddings' numbers


def map_image(situation: Situation) -> np.ndarray:
    """The cognitive map of a canonical situation as a picture (1, 80, 80) uint8.

    Indexed [0, iy, ix]. Cells are the brighter the earlier the front comes, from 255 at once to 64
    at the horizon; those where it never does are 32, effective obstacles 0.
    """
    made = build_map(situation, MarchingParams(n=CELLS))
    share = np.clip(made.arrival.filled(0.0) / situation.horizon, 0.0, 1.0)
    bright = np.round(FIRST - (FIRST - LAST) * share)
    bright[np.ma.getmaskarray(made.arrival)] = UNREACHED
    bright[made.effective_obstacles] = OBSTACLE
    picture: np.ndarray = bright.astype(np.uint8)[None]
    return picture


class _View(gymnasium.Wrapper[Any, np.ndarray, np.ndarray, np.ndarray]):
    """Adds what does not change during an episode."""

    def __init__(self, env: gymnasium.Env) -> None:
        super().__init__(env)
        if not isinstance(env.unwrapped, CatchArm):
            raise ArenaError(f"env: must be a CatchArm (got {env.unwrapped!r})")
        self.arm = env.unwrapped
        self._added = np.zeros(0)

    def seen(self, situation: Situation) -> np.ndarray:
        """What is added for a situation."""
        raise NotImplementedError

    def joined(self, state: np.ndarray) -> Any:
        """The observation."""
        raise NotImplementedError

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begin an episode, and look at its situation."""
        state, info = self.env.reset(seed=seed, options=options)
        self._added = self.seen(self.arm.situation)
        return self.joined(state), info

    def step(self, action: np.ndarray) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Move."""
        state, reward, ended, late, info = self.env.step(action)
        return self.joined(state), reward, ended, late, info


class WithMap(_View):
    """``{"state": ..., "map": ...}``: the map is `map_image` of the situation.

    Parameters
    ----------
    env : gymnasium.Env
        A `CatchArm`, wrapped or not.
    only : bool
        Tell the picture alone, a Box (1, 80, 80).
    """

    def __init__(self, env: gymnasium.Env, *, only: bool = False) -> None:
        super().__init__(env)
        self._only = only
        image = spaces.Box(0, 255, (1, CELLS, CELLS), np.uint8)
        both = spaces.Dict({"state": self.arm.observation_space, "map": image})
        self.observation_space = image if only else both

    def seen(self, situation: Situation) -> np.ndarray:
        """The map's picture."""
        return map_image(situation)

    def joined(self, state: np.ndarray) -> Any:
        """State and map, or the map."""
        return self._added.copy() if self._only else {"state": state, "map": self._added.copy()}


class WithEmbedding(_View):
    """The state, and behind it an encoder's embedding of the situation, in one Box.

    Parameters
    ----------
    env : gymnasium.Env
        A `CatchArm`, wrapped or not.
    encoder : Encoder or Path, optional
        Or its folder; by default the one in the folder of models.
    """

    def __init__(self, env: gymnasium.Env, encoder: Encoder | Path | None = None) -> None:
        super().__init__(env)
        if encoder is None or isinstance(encoder, Path):
            from gcm_learn.encoder.files import load_encoder
            from gcm_learn.memory.shipped import models_folder

            encoder = load_encoder(encoder or models_folder() / "encoder")
        self.encoder = encoder
        state = self.arm.observation_space
        assert isinstance(state, spaces.Box)
        low = np.append(state.low, np.full(encoder.dim, -LARGEST, np.float32))
        high = np.append(state.high, np.full(encoder.dim, LARGEST, np.float32))
        self.observation_space = spaces.Box(low, high, dtype=np.float32)

    def seen(self, situation: Situation) -> np.ndarray:
        """The situation's embedding."""
        return np.clip(self.encoder.embed_situation(situation), -LARGEST, LARGEST)

    def joined(self, state: np.ndarray) -> np.ndarray:
        """State and embedding."""
        return np.append(state, self._added).astype(np.float32)
