"""Episodes of actors: many situations at once, in compiled code."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gcm_learn.envs import kernels as k
from gcm_learn.envs.arena import Arena
from gcm_learn.envs.pool import Pool
from gcm_learn.policies.actor import Actor


@dataclass(frozen=True)
class Episodes:
    """What came of episodes, one for each arm."""

    places: np.ndarray
    """Situations of the pool (n,)."""
    outcomes: np.ndarray
    """CAUGHT, TOUCHED or LATE of `gcm_learn.envs.kernels` (n,)."""
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


def play(
    actor: Actor, pool: Pool, places: np.ndarray, rng: np.random.Generator | None = None
) -> Episodes:
    """Let an actor play one episode in each of some situations (n,) of a pool.

    With a generator, actions are drawn; else they are the most likely ones.
    """
    n = len(places)
    arena = Arena(pool, n, actor.settings)
    arena.put(np.arange(n), places)
    outcomes, steps = np.zeros(n, np.int64), np.zeros(n, np.int64)
    time, hand = [arena.state.time.copy()], [arena.state.hand.copy()]
    alive = np.ones(n, bool)
    while alive.any():
        got = arena.move(actor.act(arena.observations, rng))
        steps[alive] += 1
        outcomes[alive] = got[alive]
        time.append(np.where(alive, arena.state.time, time[-1]))
        hand.append(np.where(alive[:, None], arena.state.hand, hand[-1]))
        alive &= got == k.RUNNING
        # Arms whose episode is over stay where they are, at little cost.
        arena.state.time[~alive] = pool.world.arms[places[~alive], k.HORIZON]
    return Episodes(places, outcomes, time[-1], steps, np.array(time), np.array(hand))
