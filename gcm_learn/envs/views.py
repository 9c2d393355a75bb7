"""Observations with the picture of a situation's cognitive map.

The map follows from the situation at t = 0, so it stays the same during an episode.

>>> import gymnasium
>>> from gcm_learn.envs import WithMap
>>> env = WithMap(gymnasium.make("gcm_learn:CatchArm-v0"))
"""

from __future__ import annotations

from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces

from gcm_learn.envs.catch_arm import CatchArm
from gcm_learn.errors import ArenaError
from gcm_learn.maps import build_map
from gcm_learn.situation import Situation
from gcm_learn.wave import MarchingParams

CELLS = 80  # along a side of a map
OBSTACLE, UNREACHED, LAST, FIRST = 0, 32, 64, 255  # brightness of cells


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


class WithMap(gymnasium.Wrapper[Any, np.ndarray, np.ndarray, np.ndarray]):
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
        if not isinstance(env.unwrapped, CatchArm):
            raise ArenaError(f"env: must be a CatchArm (got {env.unwrapped!r})")
        self.arm, self._only = env.unwrapped, only
        image = spaces.Box(0, 255, (1, CELLS, CELLS), np.uint8)
        both = spaces.Dict({"state": self.arm.observation_space, "map": image})
        self.observation_space = image if only else both
        self._picture = np.zeros((1, CELLS, CELLS), np.uint8)

    def _joined(self, state: np.ndarray) -> Any:
        """State and map, or the map."""
        picture = self._picture.copy()
        return picture if self._only else {"state": state, "map": picture}

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Any, dict[str, Any]]:
        """Begin an episode, and build the map of its situation."""
        state, info = self.env.reset(seed=seed, options=options)
        self._picture = map_image(self.arm.situation)
        return self._joined(state), info

    def step(self, action: np.ndarray) -> tuple[Any, Any, bool, bool, dict[str, Any]]:
        """Move."""
        state, reward, ended, late, info = self.env.step(action)
        return self._joined(state), reward, ended, late, info
