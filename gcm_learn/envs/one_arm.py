"""One arm as a Gymnasium environment, one situation an episode: in the plane and in space."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any, ClassVar

import gymnasium
import numpy as np
from gymnasium import spaces

from gcm_learn.arms import rotation_of
from gcm_learn.errors import ArenaError
from gcm_learn.execution import CAUGHT, COLLIDED, LATE, OUTCOMES, RUNNING, Batch
from gcm_learn.motion import SpatialTrajectory
from gcm_learn.situation import Situation

POOL = 256  # situations that an environment draws from a family, by default
IN_SPACE = "static-clutter-space"  # where they are drawn in space, by default


def box(plant: Batch) -> spaces.Box:
    """The space of observations."""
    return spaces.Box(-plant.bounds, plant.bounds, dtype=np.float32)


def commands(plant: Batch) -> spaces.Box:
    """The space of actions of one arm."""
    return spaces.Box(-1.0, 1.0, (plant.commands,), np.float32)


class OneArm(gymnasium.Env[np.ndarray, np.ndarray]):
    """What all arenas of one arm have in common.

    Parameters
    ----------
    plant : Batch
        Of one arm.
    render_mode : {"rgb_array", "human"}, optional
    """

    metadata: ClassVar[dict[str, Any]] = {"render_modes": ["rgb_array", "human"], "render_fps": 50}

    def __init__(self, plant: Any, render_mode: str | None) -> None:
        self.plant, self.pool, self.settings = plant, plant.pool, plant.settings
        self.render_mode = render_mode
        self.observation_space, self.action_space = box(plant), commands(plant)
        self._path: list[tuple[float, ...]] = []
        self._viewer: Any = None
        self._actions = np.zeros((1, plant.commands))
        self._everyone = np.zeros(1, dtype=np.int64)
        self._places = np.zeros(1, dtype=np.int64)

    @property
    def situation(self) -> Any:
        """The present one, in the coordinates of the arm; see the subclasses."""
        return self.plant.pool.situations[int(self.plant.state.place[0])]

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Begin an episode; see the class for the options."""
        super().reset(seed=seed)
        wanted = dict(options or {})
        situation, index = wanted.pop("situation", None), wanted.pop("index", None)
        if wanted:
            raise ArenaError(f"options: {sorted(wanted)[0]!r} is not one of situation, index")
        self.plant.pool = self.pool
        if situation is not None:
            if not isinstance(situation, Situation):
                raise ArenaError(f"options.situation: must be a situation (got {situation!r})")
            self.plant.pool, index = self._pool_of(situation).prepared(self.settings), 0
        elif index is None:
            index = int(self.np_random.integers(len(self.pool)))
        elif not 0 <= index < len(self.pool):
            raise ArenaError(f"options.index: must be from 0 to {len(self.pool) - 1} (got {index})")
        self._places[0] = index
        self.plant.put(self._everyone, self._places)
        self._path = [self._where()]
        self._begin(int(index))
        if self.render_mode == "human":
            self.render()
        return self.plant.observations[0].copy(), self._info(RUNNING)

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Move for `dt` seconds."""
        if not self._path:
            raise ArenaError("step: reset comes first")
        self._actions[0] = action
        outcome = self.plant.move(self._actions).item()
        observation = self.plant.observations[0].copy()
        self._path.append(self._where())
        info, terms = self._info(outcome), self.plant.terms[0].tolist()
        catch, touch, haste, guide = terms  # a literal costs a fourth of what a zip does
        info["reward_terms"] = {"catch": catch, "touch": touch, "haste": haste, "guide": guide}
        if outcome != RUNNING:
            info["is_success"] = outcome == CAUGHT
        if self.render_mode == "human":
            self.render()
        ended = outcome in (CAUGHT, COLLIDED)
        return observation, sum(terms), ended, outcome == LATE, info

    @abstractmethod
    def _pool_of(self, situation: Any) -> Any:
        """A pool of one situation."""

    @abstractmethod
    def _where(self) -> tuple[float, ...]:
        """Time, and what the path is made of."""

    @abstractmethod
    def _in_world(self) -> np.ndarray:
        """The hand in the situation's own coordinates."""

    @abstractmethod
    def _new_viewer(self, window: bool) -> Any:
        """What draws."""

    @abstractmethod
    def _drawn(self, viewer: Any) -> np.ndarray | None:
        """A picture of the moment."""

    def _begin(self, index: int) -> None:
        """A new episode has begun."""

    def _info(self, outcome: int) -> dict[str, Any]:
        return {
            "time": self._path[-1][0],
            "hand": self._in_world(),
            "outcome": OUTCOMES[outcome],
        }

    def render(self) -> np.ndarray | None:  # type: ignore[override]
        """A picture (480, 480, 3) uint8 of the moment, or a window that shows it."""
        if self.render_mode is None:
            return None
        if self._viewer is None:
            self._viewer = self._new_viewer(self.render_mode == "human")
        return self._drawn(self._viewer)

    def close(self) -> None:
        """Close the window."""
        if self._viewer is not None:
            self._viewer.close()
            self._viewer = None

    def __getstate__(self) -> dict[str, Any]:
        """All but the window."""
        return {**self.__dict__, "_viewer": None}


class OneArmInSpace(OneArm):
    """What `CatchArm3D` and `CatchArmPhysics` have in common."""

    def __init__(self, plant: Any, render_mode: str | None) -> None:
        super().__init__(plant, render_mode)
        self._turn, self._origin = np.eye(3), np.zeros(3)

    @property
    @abstractmethod
    def trajectory(self) -> SpatialTrajectory:
        """The arm's way so far."""

    def _begin(self, index: int) -> None:
        base = self.situation.arm.base
        self._turn, self._origin = rotation_of(base.rotation), np.asarray(base.origin)

    def _where(self) -> tuple[float, ...]:
        state = self.plant.state
        return (state.time.item(0), *state.posture[0].tolist())

    def _in_world(self) -> np.ndarray:
        hand: np.ndarray = self._turn @ self.plant.hand[0] + self._origin
        return hand

    def _new_viewer(self, window: bool) -> Any:
        from gcm_learn.envs.viewer_in_space import ViewerInSpace

        return ViewerInSpace(window)

    def _drawn(self, viewer: Any) -> np.ndarray | None:
        picture: np.ndarray | None = viewer.show(self.situation, self.trajectory)
        return picture


def known_mode(render_mode: str | None) -> None:
    """Refuse a way of rendering that there is not."""
    if render_mode is not None and render_mode not in OneArm.metadata["render_modes"]:
        raise ArenaError(f"render_mode: {render_mode!r} is not rgb_array or human")
