"""Situations that the tests of execution and of the environments share."""

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import families, read_situations, seeding
from gcm_learn.execution import KinematicPlant
from gcm_learn.execution.arena.pool import stops
from gcm_learn.motion.rules import start_clearance
from gcm_learn.scene.packing import pack
from gcm_learn.situation import situation_from_json
from tests.chains import COUNT, drawn
from tests.spatial import EXAMPLES

NAMES = ("random-planar", "gate", "moving-point", "pendulum", "falling-solid", "spinning")
SPATIAL_NAMES = ("static-clutter-space", "falling-space", "pendulum-space", "crossing-swarm-space")
RAMP = 0.15  # in which joints come to their full speed, where accelerations are limited [s]


@pytest.fixture(scope="session")
def scenes():
    """Return situations of several families, planar and in space, with and without joint limits."""
    found = [families.draw(name, 5, k) for name in NAMES for k in range(5)]
    free = [s for s in found if start_clearance(pack(s)) > 0.0]
    slow = [replace(s, arm=replace(s.arm, max_joint_speed=(3.0, 4.0))) for s in free[:3]]
    return tuple(free + slow)


@pytest.fixture
def rng():
    """Return a generator of its own for every test."""
    return seeding.rng(11)


class Straight:
    """An agent that follows the command that leads straight to the target."""

    def __init__(self, settings):
        self._part = slice(settings.straight, settings.straight + settings.commands)

    def act(self, moment):
        return moment.observations[:, self._part].astype(float)


def limited(situation):
    """Return the situation with limits of acceleration, the arm moving a little at first."""
    arm = situation.arm
    joints = range(len(arm.joints))
    rates = tuple((-0.2) ** (j + 1) * arm.max_joint_speed[j] for j in joints)
    most = tuple(arm.max_joint_speed[j] / RAMP for j in joints)
    return replace(situation, arm=replace(arm, max_joint_acceleration=most, joint_rates=rates))


def begun(pool, settings, threads=1):
    """Return a plant with one arm in each situation of a pool."""
    plant = KinematicPlant(pool, len(pool), settings, threads=threads)
    plant.put(np.arange(len(pool)), np.arange(len(pool)))
    return plant


def good(situation):
    """Return whether an episode can begin."""
    return start_clearance(pack(situation)) > 0.0 and stops(situation, 0.02)


@pytest.fixture(scope="session")
def arms():
    """Return situations of several families and arms, with and without limits of acceleration."""
    drawn = [families.draw(name, 5, k) for name in SPATIAL_NAMES for k in range(5)]
    read = read_situations(EXAMPLES)[::5]
    quick = [s for s in [*drawn, *read] if good(s)]
    slow = [s for s in map(limited, drawn[::3]) if good(s)]
    one = quick[0]
    other = replace(quick[1].targets[0], name="another")
    return (*quick, *slow, replace(one, bodies=(*one.bodies, other)))


@pytest.fixture(scope="session")
def chains():
    """Return situations of a Panda, with and without limits and approaches."""
    made = [situation_from_json(drawn("panda", k)) for k in range(COUNT)]
    slow = [limited(s) for s in made[::3]]
    return tuple(s for s in [*made, *slow] if good(s))
