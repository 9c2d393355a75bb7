"""Episodes: an agent commands a plant until all is over."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from gcm_learn.execution.arena.kernels.world import RUNNING


class Moment(NamedTuple):
    """Input of an agent, a row for each arm; the arrays are the plant's own."""

    time: np.ndarray
    """(n,) [s]"""
    hand: np.ndarray
    """(n, 2), canonical coordinates of t = 0 [forearm lengths]; (n, 3) in space, in those of the
    arm's base."""
    observations: np.ndarray
    """(n, width) float32, as `envs.CatchArm` and `envs.CatchArm3D` list them."""
    running: np.ndarray
    """Whose episode is not over (n,) bool."""
    posture: np.ndarray
    """(n, k): hands; in space joints, then their rates."""


class Agent(Protocol):
    """Agent that sees a moment and gives commands."""

    def act(self, moment: Moment) -> np.ndarray:
        """Return commands (n, k); rows of arms whose episode is over do not matter."""


class Plant(Protocol):
    """Arms that carry commands out, each in a situation of its own."""

    observations: np.ndarray
    """As `Moment` has it."""

    @property
    def time(self) -> np.ndarray:
        """Times of the arms, as in `Moment`."""

    @property
    def hand(self) -> np.ndarray:
        """Hands, as in `Moment`."""

    @property
    def posture(self) -> np.ndarray:
        """Postures, as in `Moment`."""

    @property
    def rewards(self) -> np.ndarray:
        """Rewards of the last step (n,)."""

    def put(self, arms: np.ndarray, places: np.ndarray) -> None:
        """Put arms (m,) at the start of situations (m,)."""

    def move(self, actions: np.ndarray) -> np.ndarray:
        """Carry commands out for a step; return the outcomes (n,)."""

    def hold(self, arms: np.ndarray) -> None:
        """Let arms (m,) whose episode is over stay where they are."""


class Steps(NamedTuple):
    """One step of all arms with a running episode, or several steps joined."""

    arms: np.ndarray
    """Numbers of the arms (m,)."""
    told: np.ndarray
    """Observations before (m, width) float32."""
    actions: np.ndarray
    """(m, 2) float32, in space (m, 4)."""
    rewards: np.ndarray
    """(m,) float32."""
    following: np.ndarray
    """Observations after (m, width) float32."""
    outcomes: np.ndarray
    """As `world` codes them (m,)."""


@dataclass(frozen=True)
class Episodes:
    """Results of episodes, one for each arm."""

    places: np.ndarray
    """Situations (n,)."""
    outcomes: np.ndarray
    """CAUGHT, COLLIDED or LATE of `world` (n,)."""
    times: np.ndarray
    """Times of their ends [s] (n,)."""
    steps: np.ndarray
    """Numbers of steps (n,)."""
    time: np.ndarray
    """Sample times [s] (most + 1, n); after the end the last one is repeated."""
    hand: np.ndarray
    """Places of the hand at these times, as `Moment` has them (most + 1, n, 2 or 3)."""
    posture: np.ndarray
    """Postures at these times, of which trajectories are made (most + 1, n, k)."""

    def path(self, e: int) -> tuple[np.ndarray, np.ndarray]:
        """Time (m,) and hand (m, 2) of an episode; in space joints and rates (m, 8)."""
        last = int(self.steps[e]) + 1
        return self.time[:last, e], self.posture[:last, e]


def run_episode(
    agent: Agent, plant: Plant, places: np.ndarray, watch: Callable[[Steps], object] | None = None
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
    time, hand, posture = [[now.copy()] for now in (plant.time, plant.hand, plant.posture)]
    while running.any():
        arms = np.flatnonzero(running)
        moment = Moment(plant.time, plant.hand, plant.observations, running, plant.posture)
        actions = agent.act(moment)
        told = None if watch is None else plant.observations[arms]
        outcomes[arms] = plant.move(actions)[arms]
        if watch is not None and told is not None:
            rewards = plant.rewards[arms].astype(np.float32)
            following = plant.observations[arms]
            watch(Steps(arms, told, actions[arms].astype("f4"), rewards, following, outcomes[arms]))
        steps[arms] += 1
        time.append(np.where(running, plant.time, time[-1]))
        hand.append(np.where(running[:, None], plant.hand, hand[-1]))
        posture.append(np.where(running[:, None], plant.posture, posture[-1]))
        running = outcomes == RUNNING
        plant.hold(np.flatnonzero(~running))
    courses = np.array(time), np.array(hand), np.array(posture)
    return Episodes(places, outcomes, time[-1], steps, *courses)


def into_frame(hand: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    """Vectors (n, 2), turned into the frames in which hands (n, 2) are on the x axis."""
    r = np.maximum(np.hypot(*hand.T), 1e-12)
    c, s = hand[:, 0] / r, hand[:, 1] / r
    x, y = vectors.T
    return np.stack([c * x + s * y, c * y - s * x], axis=1)
