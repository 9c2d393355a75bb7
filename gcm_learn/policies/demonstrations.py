"""Demonstrations: planned catches, acted out step by step."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gcm_learn.execution import (
    CAUGHT,
    ArenaSettings,
    Episodes,
    Pool,
    Steps,
    follower_of,
    plant_of,
    run_episode,
)


@dataclass(frozen=True)
class Demonstrations:
    """Observations, and the actions of demonstrators."""

    observations: np.ndarray
    """(m, width) float32."""
    actions: np.ndarray
    """(m, 2) float32: velocities in the frame of the moment, in hand speeds; in space (m, 4): rates
    of the joints, in their greatest."""
    caught: np.ndarray
    """Which of the plans still catch when they are acted out in steps (n,)."""

    @classmethod
    def joined(cls, parts: Iterable[Demonstrations]) -> Demonstrations:
        """Several, one after the other."""
        columns = zip(*((p.observations, p.actions, p.caught) for p in parts), strict=True)
        return cls(*map(np.concatenate, columns))


def act_out(pool: Pool, plans: Sequence[Any], settings: ArenaSettings) -> Demonstrations:
    """Follow plans step by step.

    Parameters
    ----------
    pool : Pool
    plans : sequence of Movement
        One for each situation of the pool, in its coordinates.
    settings : ArenaSettings

    Returns
    -------
    Demonstrations
        Only of episodes that end with a catch: what corners cut by steps spoil is left out.
    """
    episodes, steps = _followed(pool, plans, settings)
    caught = episodes.outcomes == CAUGHT
    good = caught[steps.arms]
    return Demonstrations(steps.told[good], steps.actions[good], caught)


def transitions(pool: Pool, plans: Sequence[Any], settings: ArenaSettings) -> Steps:
    """All steps of following plans, one after the other, for learners with a replay buffer.

    Failures because steps cut corners are included: they come with their rewards.
    """
    return _followed(pool, plans, settings)[1]


def _followed(pool: Pool, plans: Sequence[Any], settings: ArenaSettings) -> tuple[Episodes, Steps]:
    """Follow plans: what came of it, and all steps joined."""
    plant, steps = plant_of(pool, len(pool), settings), list[Steps]()
    agent = follower_of(plans, pool, settings.dt)
    episodes = run_episode(agent, plant, np.arange(len(pool)), steps.append)
    return episodes, Steps(*map(np.concatenate, zip(*steps, strict=True)))
