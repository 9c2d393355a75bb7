"""Batches of arms, and arms without mass, which follow commands as nearly as limits allow."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from typing import Any

import numpy as np

from gcm_learn.arms import PLANAR, ByKind
from gcm_learn.execution.arena.kernels.world import EXTREME, TERMS, Told
from gcm_learn.execution.arena.kinds import KERNELS
from gcm_learn.execution.arena.pool import Pool
from gcm_learn.execution.arena.settings import FARTHEST, ArenaSettings
from gcm_learn.motion import Movement


class Batch(ABC):
    """Arms that move together step by step in situations of a pool, without randomness.

    Every step overwrites the arrays: copy values that are needed later. One arm is a batch of
    one.

    Parameters
    ----------
    pool : Pool
    count : int
        Number of arms.
    settings : ArenaSettings
    threads : int
        Threads that share the arms among them.
    """

    def __init__(self, pool: Pool, count: int, settings: ArenaSettings, threads: int = 1) -> None:
        self.pool, self.settings = settings.prepared(pool), settings
        self.count, self.threads = count, threads
        pool, self._kernels = self.pool, KERNELS.of(settings.kind)
        width = settings.width + pool.embeddings.shape[1]
        told = Told(np.zeros(count, np.int64), np.zeros((count, TERMS)),
                    np.zeros((count, width), "f4"))  # fmt: skip
        self.told = told
        self.observations = told.observations
        """Of the arms (count, width) float32."""
        self.terms = told.terms
        """Of the rewards of the last step (count, 4)."""
        self.state = self._kernels.state(count, settings.commands)
        # Plain tuples: of named ones, finding the types takes as long as a step.
        self._arms, self._options = tuple(self.state), settings.options
        self._told, self._world = tuple(told), tuple(pool.world)
        marks = np.linspace(0, count, min(threads, count) + 1).astype(int).tolist()
        self._shares = list(pairwise(marks))
        self._crew: ThreadPoolExecutor | None = None

    def __getstate__(self) -> dict[str, Any]:
        """Return everything but the threads, and the kernels, which follow from the kind."""
        return {**self.__dict__, "_crew": None, "_kernels": None}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._kernels = KERNELS.of(self.settings.kind)

    @property
    def bounds(self) -> np.ndarray:
        """Largest sizes of the numbers of an observation (width,) float32."""
        out = np.full(self.observations.shape[1], EXTREME, np.float32)
        out[self.settings.width :] = FARTHEST
        return out

    @property
    def commands(self) -> int:
        """Numbers that command an arm."""
        return self.settings.commands

    @property
    def time(self) -> np.ndarray:
        """Time since the start of each episode (count,) [s]."""
        return self.state.time

    @property
    def hand(self) -> np.ndarray:
        """Hands (count, 2), in canonical coordinates of t = 0, or (count, 3) in the base's."""
        return self.state.hand

    @property
    def posture(self) -> np.ndarray:
        """Samples of trajectories (count, k): hands; of other arms joints, then their rates."""
        return self.state.posture

    @property
    def rewards(self) -> np.ndarray:
        """Rewards of the last step (count,)."""
        total: np.ndarray = self.terms.sum(axis=1)
        return total

    def put(self, arms: np.ndarray, places: np.ndarray) -> None:
        """Put arms (m,) at the start of situations (m,) of the pool, and observe."""
        self._world = tuple(self.pool.world)  # the pool may be another now
        self._widen(int(np.diff(self.pool.world.first).max()))
        state = self.state
        state.place[arms], state.time[arms], state.caught[arms] = places, 0.0, -1.0
        self._begin(arms, places)
        self.observations[arms, self.settings.width :] = self.pool.embeddings[places]
        self._kernels.observe(self._world, self._arms, arms, self._options, self.observations)

    def _widen(self, bodies: int) -> None:
        """Make sure that states have a column for each of so many bodies."""
        before = self.state.caught
        if before.shape[1] < bodies:
            caught = np.full((self.count, bodies), -1.0)
            caught[:, : before.shape[1]] = before
            self.state = self.state._replace(caught=caught)
            self._arms = tuple(self.state)

    def caught(self, e: int) -> tuple[str, ...]:
        """Return the names of the targets that arm e has caught, in order."""
        when = self.state.caught[e]
        order = np.argsort(when, kind="stable")[np.count_nonzero(when < 0.0) :]
        bodies = self.pool.situations[int(self.state.place[e])].bodies
        return tuple(bodies[b].name for b in order.tolist())

    def hold(self, arms: np.ndarray) -> None:
        """Let arms (m,) rest after their episodes, at little cost."""
        self.state.time[arms] = self.pool.horizons[self.state.place[arms]]

    def move(self, actions: np.ndarray) -> np.ndarray:
        """Make one step of every arm, observe, and return the outcomes (count,).

        Parameters
        ----------
        actions : (count, commands) ndarray
            As the environments have them.
        """
        if len(self._shares) == 1:
            self._play(actions, 0, self.count)
            return self.told.outcomes
        if self._crew is None:
            self._crew = ThreadPoolExecutor(len(self._shares) - 1)
        (first, last), *others = self._shares
        waiting = [self._crew.submit(self._play, actions, *share) for share in others]
        self._play(actions, first, last)
        for share in waiting:
            share.result()
        return self.told.outcomes

    @abstractmethod
    def way(self, e: int, time: np.ndarray, posture: np.ndarray) -> Any:
        """Return the trajectory of arm e until now.

        Parameters
        ----------
        e : int
        time : (m,) ndarray
            [s]
        posture : (m, k) ndarray
            Samples of `posture` at these times.
        """

    @abstractmethod
    def _begin(self, arms: np.ndarray, places: np.ndarray) -> None:
        """Write the postures of arms (m,) at the start of situations (m,)."""

    @abstractmethod
    def _play(self, actions: np.ndarray, first: int, last: int) -> None:
        """Make one step of arms first to last - 1; several threads may call this at once."""


def way_of(arm: Any, time: np.ndarray, posture: np.ndarray) -> Any:
    """Return the trajectory of an arm from the times (m,) and the postures (m, k) of its plant."""
    return _WAYS.of(arm)(arm, time, posture)


def _way_of_joints(arm: Any, time: np.ndarray, posture: np.ndarray) -> Movement:
    new = np.append(True, np.diff(time) > 0.0)  # a catch at t = 0 takes no time
    dof = len(arm.joints)
    joints, rates = posture[new, :dof], posture[new, dof:]
    limited = arm.max_joint_acceleration is not None
    return Movement(arm, time[new], joints, rates if limited else None)


_WAYS: ByKind[Callable[[Any, np.ndarray, np.ndarray], Any]] = ByKind(
    {PLANAR: Movement.of_hand}, default=_way_of_joints, who="the arena"
)


class KinematicPlant(Batch):
    """Kinematic arms of any kind.

    Parameters
    ----------
    pool : Pool
    count : int
    settings : ArenaSettings
    threads : int
        As `Batch` has them.
    """

    def way(self, e: int, time: np.ndarray, posture: np.ndarray) -> Any:
        """As `Batch` says."""
        return way_of(self.pool.situations[self.state.place[e]].arm, time, posture)

    def _begin(self, arms: np.ndarray, places: np.ndarray) -> None:
        self.state.posture[arms] = self.pool.starts[places]

    def _play(self, actions: np.ndarray, first: int, last: int) -> None:
        self._kernels.play(self._world, self._arms, actions, self._options, self._told, first, last)
