"""A memory of random catches, made once."""

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import seeding
from gcm_learn.arms import SPATIAL
from gcm_learn.families.random_planar import random_planar
from gcm_learn.planners.goal_directed import layered
from gcm_learn.recall import Memory, RawIndex, waypoints_of
from gcm_learn.wave import MarchingParams

ENTRIES = 300


def caught(seed, count):
    """The first situations of a seed that are caught, and their plans."""
    planner, found, k = layered(MarchingParams(n=40)), [], 0
    while len(found) < count:
        situation = random_planar(seeding.rng(seed, k), name=f"random {k}")
        plan = planner.plan(situation)
        if plan.caught:
            found.append((situation, plan))
        k += 1
    return found


def limited(rng):
    """A random planar situation whose joints have limits of speed."""
    situation = random_planar(rng)
    limits = tuple(float(v) for v in rng.uniform(3.0, 12.0, 2))
    return replace(situation, arm=replace(situation.arm, max_joint_speed=limits))


def stacked(traces):
    """Knots and goals of several traces."""
    return np.array([t.knots for t in traces]), np.array([t.goal for t in traces])


def memory_by(index, embeddings, knots, goals, search="auto"):
    """A memory of catches whose embeddings are known; it keeps no situations."""
    memory, count = Memory(index, search), len(knots)
    columns = {"embeddings": embeddings.astype(np.float32), "traces": knots, "goals": goals}
    columns |= {"labels": np.zeros((count, 2), np.int16), "lengths": np.zeros(count, np.int32)}
    memory._append(columns, [b""] * count)
    return memory


def memory_in_space(catches):
    """A memory of situations in space and their catches, filed by raw parameters."""
    situations = [situation for situation, _ in catches]
    memory = Memory(RawIndex.fit(situations), kind=SPATIAL)
    memory.add(situations, [waypoints_of(situation, plan) for situation, plan in catches])
    return memory


@pytest.fixture(scope="package")
def catches():
    """Situations with their catches."""
    return caught(71, ENTRIES)


@pytest.fixture(scope="package")
def traces(catches):
    """The catches as memory keeps them."""
    return [waypoints_of(situation, plan) for situation, plan in catches]


@pytest.fixture
def memory(catches, traces):
    """A memory of all of them, filed by raw parameters; each test may change it."""
    situations = [situation for situation, _ in catches]
    strata = ["W" if len(s.obstacles) > 2 else "L" for s in situations]
    memory = Memory(RawIndex.fit(situations))
    memory.add(situations, traces, ["random-planar"] * len(traces), strata)
    return memory
