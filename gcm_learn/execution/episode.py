"""Episodes: an agent tells a plant what to do until it is over."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from gcm_learn.execution.world import RUNNING


class Moment(NamedTuple):
    """What an agent sees, a row for each arm; the arrays are the plant's own."""

    time: np.ndarray
    """(n,) [s]"""
    hand: np.ndarray
    """(n, 2), canonical coordinates of t = 0 [forearm lengths]."""
    observations: np.ndarray
    """(n, width) float32, as `envs.CatchArm` lists them."""
    running: np.ndarray
    """Whose episode is not over (n,) bool."""


class Agent(Protocol):
    """Whatever acts: it sees a moment and gives commands."""

    def act(self, moment: Moment) -> np.ndarray:
        """Commands (n, 2); those to arms whose episode is over do not matter."""


class Plant(Protocol):
    """Whatever carries commands out: arms, each in a situation of its own."""

    time: np.ndarray
    """As `Moment` has it, and so the next two."""
    hand: np.ndarray
    observations: np.ndarray

    @property
    def rewards(self) -> np.ndarray:
        """Of the last step (n,)."""

    def put(self, arms: np.ndarray, places: np.ndarray) -> None:
        """Put arms (m,) at the start of situations (m,)."""

    def move(self, actions: np.ndarray) -> np.ndarray:
        """Carry commands (n, 2) out for a step: the outcomes (n,)."""

    def hold(self, arms: np.ndarray) -> None:
        """Let arms (m,) whose episode is over stay where they are."""


class Steps(NamedTuple):
    """One step of those arms whose episode is not over, or several steps joined."""

    arms: np.ndarray
    """Which they are (m,)."""
    told: np.ndarray
    """Before (m, width) float32."""
    actions: np.ndarray
    """(m, 2) float32."""
    rewards: np.ndarray
    """(m,) float32."""
    following: np.ndarray
    """What is told after (m, width) float32."""
    outcomes: np.ndarray
    """As `world` codes them (m,)."""


@dataclass(frozen=True)
class Episodes:
    """What came of episodes, one for each arm."""

    places: np.ndarray
    """Situations (n,)."""
    outcomes: np.ndarray
    """CAUGHT, COLLIDED or LATE of `world` (n,)."""
    times: np.ndarray
    """When they ended [s] (n,)."""
    steps: np.ndarray
    """How many steps they had (n,)."""
    time: np.ndarray
    """Samples [s] (most + 1, n); after the end all are the last one."""
    hand: np.ndarray
    """The same of the hand, canonical coordinates (most + 1, n, 2)."""

    def path(self, e: int) -> tuple[np.ndarray, np.ndarray]:
        """Time (m,) and hand (m, 2) of an episode."""
        last = int(self.steps[e]) + 1
        return self.time[:last, e], self.hand[:last, e]


def run_episode(
    agent: Agent,
    plant: Plant,
    places: np.ndarray,
    watch: Callable[[Steps], object] | None = None,
) -> Episodes:
    """Let an agent act until every arm's episode is over.

    Parameters
    ----------
    agent : Agent
    plant : Plant
    places : (n,) ndarray of int
        Situations in which its arms begin.
    watch : callable, optional
        Called with each step.
    """
    n = len(places)
    plant.put(np.arange(n), places)
    running, outcomes = np.ones(n, bool), np.full(n, RUNNING)
    steps = np.zeros(n, np.int64)
    time, hand = [plant.time.copy()], [plant.hand.copy()]
    while running.any():
        arms = np.flatnonzero(running)
        actions = agent.act(Moment(plant.time, plant.hand, plant.observations, running))
        told = None if watch is None else plant.observations[arms]
        outcomes[arms] = plant.move(actions)[arms]
        if watch is not None and told is not None:
            rewards = plant.rewards[arms].astype(np.float32)
            following = plant.observations[arms]
            watch(Steps(arms, told, actions[arms].astype("f4"), rewards, following, outcomes[arms]))
        steps[arms] += 1
        time.append(np.where(running, plant.time, time[-1]))
        hand.append(np.where(running[:, None], plant.hand, hand[-1]))
        running = outcomes == RUNNING
        plant.hold(np.flatnonzero(~running))
    return Episodes(places, outcomes, time[-1], steps, np.array(time), np.array(hand))


def into_frame(hand: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Vectors (n, 2), turned into the frames in which hands (n, 2) are on the x axis."""
    r = np.maximum(np.hypot(*hand.T), 1e-12)
    c, s = hand[:, 0] / r, hand[:, 1] / r
    x, y = vectors.T
    return np.stack([c * x + s * y, c * y - s * x], axis=1)
