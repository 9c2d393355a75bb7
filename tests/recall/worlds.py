"""Situations of spatial arms with and without limits of acceleration, and memories of them."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from gcm_learn import families, solve
from gcm_learn.arms import SPATIAL
from gcm_learn.recall import MEMORIES, Adaptation
from tests.recall.conftest import memory_in_space

RAMP = 0.08  # in which joints come to their full speed [s]
MOVEMENTS = MEMORIES.of(SPATIAL)


def limited(situation, ramp=RAMP, moving=0.4, seed=0):
    """A situation whose joints need a time to come to full speed, and may move at t = 0."""
    arm, rng = situation.arm, np.random.default_rng(seed)
    limits = tuple(speed / ramp for speed in arm.max_joint_speed)
    rates = tuple(moving * rng.uniform(-1.0, 1.0, 4) * arm.max_joint_speed)
    return replace(situation, arm=replace(arm, max_joint_acceleration=limits, joint_rates=rates))


@dataclass(frozen=True)
class World:
    """Situations of four families, with or without limits of acceleration."""

    names: tuple[str, ...]
    seed: int
    entries: int
    accelerates: bool = False

    def drawn(self, seed, count, names=None):
        """Situations of a seed."""
        names = names or self.names
        for k in range(count):
            situation = families.draw(names[k % len(names)], seed, k)
            yield limited(situation, seed=k) if self.accelerates else situation


FREE = World(
    ("static-clutter-space", "window-space", "late-target-space", "pendulum-space"), 171, 120
)
LIMITED = World(
    ("static-clutter-space", "window-space", "falling-space", "crate-space"), 311, 36, True
)


@cache
def catches_of(world):
    """Situations of a world with their catches."""
    found = ((s, solve(s)) for s in world.drawn(world.seed, 10 * world.entries))
    caught = ((s, plan) for s, plan in found if plan.caught)
    return [next(caught) for _ in range(world.entries)]


@cache
def memory_of(world):
    """A memory of them."""
    return memory_in_space(catches_of(world))


def times(situations, memory, bends):
    """When the memories catch in situations (n, m), -1 where they do not."""
    rows = np.arange(len(memory))
    problems = [MOVEMENTS.problem(situation, "labels") for situation in situations]
    tries = [MOVEMENTS.tries(problem, Adaptation(bends=bends)) for problem in problems]
    return np.array([one.catch_times(memory.knots, memory.goals, rows) for one in tries])
