"""One arm as a Gymnasium environment, one situation an episode: the same class for all arenas."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import gymnasium
import numpy as np
from gymnasium import spaces

from gcm_learn import execution
from gcm_learn.arms import PLANAR, ByKind, rotation_of
from gcm_learn.envs.viewer import Viewer
from gcm_learn.errors import ArenaError
from gcm_learn.situation import AnySituation, Situation

Placing = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class _Turned:
    """Map of a canonical hand to the coordinates as drawn; plain floats, since steps are short."""

    rows: list[list[float]]

    def __call__(self, hand: np.ndarray) -> np.ndarray:
        (a, b), (c, d) = self.rows
        x, y = hand.item(0), hand.item(1)
        return np.array((a * x + b * y, c * x + d * y))


@dataclass(frozen=True)
class _Based:
    """Map of a hand from the frame of its arm's base to the world."""

    turn: np.ndarray
    origin: np.ndarray

    def __call__(self, hand: np.ndarray) -> np.ndarray:
        placed: np.ndarray = self.turn @ hand + self.origin
        return placed


def _turned(situation: AnySituation, frame: Any) -> Placing:
    return _Turned(frame.original(np.eye(2)).T.tolist())


def _based(situation: Any, frame: Any) -> Placing:
    base = situation.arm.base
    return _Based(rotation_of(base.rotation), np.asarray(base.origin))


_PLACINGS: ByKind[Callable[[Any, Any], Placing]] = ByKind({PLANAR: _turned}, default=_based)


def placing_of(situation: AnySituation, frame: Any) -> Placing:
    """Return the function from a hand in the arena's coordinates to the world's.

    Parameters
    ----------
    situation : Situation
        As the arena has it.
    frame : Frame
        Frame in which it was drawn.
    """
    return _PLACINGS.of(situation)(situation, frame)


POOL = 256  # situations of a family in which an environment's episodes begin, by default


def box(plant: execution.Batch) -> spaces.Box:
    """Return the space of observations."""
    return spaces.Box(-plant.bounds, plant.bounds, dtype=np.float32)


def commands(plant: execution.Batch) -> spaces.Box:
    """Return the action space of one arm."""
    return spaces.Box(-1.0, 1.0, (plant.commands,), np.float32)


def finite(action: Any, shape: tuple[int, ...], step: str) -> np.ndarray:
    """Return an action as an array of floats; refuse another shape, NaN and infinities.

    Parameters
    ----------
    action : array_like
        As given.
    shape : tuple of int
        As it must be.
    step : str
        Step that takes it, e.g. ``"CatchArm.step"``.
    """
    try:
        given = np.asarray(action, float)
    except (TypeError, ValueError):
        raise ArenaError(f"{step}: the action must be numbers {shape} (got {action!r})") from None
    if given.shape != shape:
        raise ArenaError(f"{step}: the action must have shape {shape} (got {given.shape})")
    if not np.isfinite(np.vdot(given, given)) and not np.isfinite(given).all():
        worst = (
            given[np.flatnonzero(~np.isfinite(given).all(axis=-1))[0]] if len(shape) > 1 else given
        )
        raise ArenaError(f"{step}: the action must be finite (got {worst.tolist()})")
    return given


class OneArm(gymnasium.Env[np.ndarray, np.ndarray]):
    """One arm of an arena as an environment; subclasses name the arena and describe it.

    Parameters
    ----------
    situations : str, Path, Family, Situation, sequence of Situation or Pool, optional
        By default those of the arena's family.
    render_mode : {"rgb_array", "human"}, optional
    pool : int
        Number of situations that are read, or that resets choose from and draw.
    pool_seed : int
        Of the draws.
    body : ArmBody, str or Path, optional
        Of arms with mass.
    settings : ArenaSettings or mapping, optional
        Fields of the arena's settings, and of `Weights` under "weights".
    control : str, optional
    fan, embedding : bool, optional
    arm : str or Path, optional
        These four settings for short, in arenas that have them.
    """

    arena: ClassVar[execution.Arena]
    metadata: ClassVar[dict[str, Any]] = {"render_modes": ["rgb_array", "human"], "render_fps": 50}

    def __init__(
        self,
        situations: execution.Source | execution.Pool | None = None,
        render_mode: str | None = None,
        *,
        pool: int = POOL,
        pool_seed: int = 0,
        body: execution.AnyBody = None,
        settings: execution.ArenaSettings | Mapping[str, Any] | None = None,
        control: str | None = None,
        fan: bool | None = None,
        embedding: bool | None = None,
        arm: str | Path | None = None,
    ) -> None:
        if render_mode is not None and render_mode not in self.metadata["render_modes"]:
            raise ArenaError(f"render_mode: {render_mode!r} is not rgb_array or human")
        chosen = execution.settings_of(
            self.arena.settings, settings, control=control, fan=fan, embedding=embedding, arm=arm
        )
        made = situations if situations is not None else self.arena.family
        held = execution.reserve_of(made, pool, pool_seed, chosen, body)
        self.plant: Any = self.arena.plant(held.at(0)[0], 1, chosen)
        self._held = self.plant.pool if isinstance(held, execution.Pool) else held
        self.settings, self.render_mode = chosen, render_mode
        self.observation_space, self.action_space = box(self.plant), commands(self.plant)
        self._body = body
        self._path: list[tuple[float, ...]] = []
        self._several = False  # whether the situation asks for several catches
        self._viewer: Viewer | None = None
        self._actions = np.zeros((1, self.plant.commands))
        self._shape, self._step = (self.plant.commands,), f"{type(self).__name__}.step"
        self._everyone = np.zeros(1, dtype=np.int64)
        self._places = np.zeros(1, dtype=np.int64)
        self._placings: dict[int, Placing] = {}  # of the pool's situations

    @property
    def pool(self) -> execution.Pool:
        """All situations in which episodes begin."""
        whole: execution.Pool = self._held.whole
        return whole

    @property
    def frame(self) -> Any:
        """Frame in which the present situation was drawn."""
        return self.plant.pool.frames[int(self.plant.state.place[0])]

    @property
    def trajectory(self) -> Any:
        """Movement of the arm until now, in the coordinates of the situation."""
        path = np.array(self._path)
        return self.plant.way(0, path[:, 0], path[:, 1:])

    @property
    def situation(self) -> Any:
        """Present situation; of planar arms in its canonical form."""
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
        if situation is not None:
            if not isinstance(situation, Situation):
                raise ArenaError(f"options.situation: must be a situation (got {situation!r})")
            given = execution.pool_for(self.settings, [situation], self._body)
            self.plant.pool, self._places[0], index = self.settings.prepared(given), 0, None
        else:
            index = self._chosen(index)
            self.plant.pool, self._places[0] = self._held.at(index)
        self.plant.put(self._everyone, self._places)
        self._path = [self._where()]
        self._placing = self._placing_of(index)
        self._several = self.situation.catch != "any"
        if self.render_mode == "human":
            self.render()
        return self.plant.observations[0].copy(), self._info(execution.RUNNING)

    def _chosen(self, index: int | None) -> int:
        """Return the index of a situation, drawn at random if none is given."""
        count = len(self._held)
        if index is None:
            return int(self.np_random.integers(count))
        if not 0 <= index < count:
            raise ArenaError(f"options.index: must be from 0 to {count - 1} (got {index})")
        return int(index)

    def step(self, action: np.ndarray) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        """Move for `dt` seconds; an action of another shape, or not finite, is an error."""
        if not self._path:
            raise ArenaError("step: reset comes first")
        self._actions[0] = finite(action, self._shape, self._step)
        outcome = self.plant.move(self._actions).item()
        observation = self.plant.observations[0].copy()
        self._path.append(self._where())
        info, terms = self._info(outcome), self.plant.terms[0].tolist()
        catch, touch, haste, guide = terms  # a literal costs a fourth of what a zip does
        info["reward_terms"] = {"catch": catch, "touch": touch, "haste": haste, "guide": guide}
        if outcome != execution.RUNNING:
            info["is_success"] = outcome == execution.CAUGHT
        if self.render_mode == "human":
            self.render()
        ended = outcome in (execution.CAUGHT, execution.COLLIDED)
        return observation, sum(terms), ended, outcome == execution.LATE, info

    def _where(self) -> tuple[float, ...]:
        """Return the time, and the posture."""
        state = self.plant.state
        return (state.time.item(0), *state.posture[0].tolist())

    def _placing_of(self, index: int | None) -> Placing:
        """Return the map from the arm's coordinates to the world's; cache it by a given index."""
        if index is None:
            return placing_of(self.situation, self.frame)
        if index not in self._placings:
            self._placings[index] = placing_of(self.situation, self.frame)
        return self._placings[index]

    def _info(self, outcome: int) -> dict[str, Any]:
        several = outcome == execution.CAUGHT or self._several
        return {
            "time": self._path[-1][0],
            "hand": self._placing(self.plant.state.hand[0]),
            "outcome": execution.OUTCOMES[outcome],
            "caught": self.plant.caught(0) if several else (),
        }

    def render(self) -> np.ndarray | None:  # type: ignore[override]
        """Return a picture (480, 480, 3) uint8 of the moment, or show it in a window."""
        if self.render_mode is None:
            return None
        if self._viewer is None:
            rate = self.metadata["render_fps"] if self.render_mode == "human" else None
            self._viewer = Viewer(self.arena.kind, rate)
        return self._viewer.show(self.situation, self.trajectory)

    def close(self) -> None:
        """Close the window."""
        if self._viewer is not None:
            self._viewer.close()
            self._viewer = None

    def __getstate__(self) -> dict[str, Any]:
        """Return everything but the window."""
        return {**self.__dict__, "_viewer": None}
