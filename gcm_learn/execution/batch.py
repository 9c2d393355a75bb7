"""Arms side by side, each in its situation: what plants in the plane and in space share."""

from __future__ import annotations

from abc import ABC, abstractmethod
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from typing import Any

import numpy as np

from gcm_learn.execution.stepping import TERMS
from gcm_learn.execution.world import Told


class Batch(ABC):
    """Arms that move, catch and touch; nothing of it is drawn at random.

    The arrays are renewed in place at every step: copy what is to be kept. One arm is a batch of
    one.

    Parameters
    ----------
    count : int
        Number of arms.
    width : int
        Of what each is told.
    threads : int
        How many of them move the arms, each its share.
    """

    settings: Any
    """Of the arms."""
    state: Any
    """Where the arms are; has `place`, `time` and `hand`."""

    def __init__(self, count: int, width: int, threads: int) -> None:
        self.count, self.threads = count, threads
        told = Told(np.zeros(count, np.int64), np.zeros((count, TERMS)),
                    np.zeros((count, width), "f4"))  # fmt: skip
        self.told = told
        self.observations = told.observations
        """What the arms are told (count, width) float32."""
        self.terms = told.terms
        """Of the rewards of the last step (count, 4)."""
        marks = np.linspace(0, count, min(threads, count) + 1).astype(int).tolist()
        self._shares = list(pairwise(marks))
        self._crew: ThreadPoolExecutor | None = None

    def __getstate__(self) -> dict[str, Any]:
        """All but the threads."""
        return {**self.__dict__, "_crew": None}

    @property
    @abstractmethod
    def bounds(self) -> np.ndarray:
        """Largest sizes of the numbers of an observation (width,) float32."""

    @property
    @abstractmethod
    def commands(self) -> int:
        """How many numbers command an arm."""

    @property
    def time(self) -> np.ndarray:
        """How long the arms have been under way (count,) [s]."""
        found: np.ndarray = self.state.time
        return found

    @property
    def hand(self) -> np.ndarray:
        """Hands (count, 2 or 3): in canonical coordinates of t = 0, in space in the base's."""
        found: np.ndarray = self.state.hand
        return found

    @property
    @abstractmethod
    def posture(self) -> np.ndarray:
        """What trajectories are made of (count, k): hands; in space joints, then their rates."""

    @property
    def rewards(self) -> np.ndarray:
        """Of the last step (count,)."""
        total: np.ndarray = self.terms.sum(axis=1)
        return total

    @abstractmethod
    def put(self, arms: np.ndarray, places: np.ndarray) -> None:
        """Put arms (m,) at the start of situations (m,) of the pool, and observe."""

    @abstractmethod
    def hold(self, arms: np.ndarray) -> None:
        """Let arms (m,) whose episode is over stay where they are, at little cost."""

    def move(self, actions: np.ndarray) -> np.ndarray:
        """One step of every arm, and what they are told then: the outcomes (count,).

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
    def _play(self, actions: np.ndarray, first: int, last: int) -> None:
        """One step of arms first to last - 1; many threads at once may be in it."""
