"""What tests of policies share: a generator, and actors that do not look."""

import numpy as np
import pytest

from gcm_learn import seeding
from gcm_learn.execution import COMMANDS, SpatialSettings
from gcm_learn.policies import Actor


@pytest.fixture
def rng():
    """Return a generator of its own for every test."""
    return seeding.rng(12)


def constant_actor(settings, scores, head):
    """Return an actor with the same scores of choices, or the same velocity, whatever it sees."""
    width = settings.width
    layer = np.zeros((len(scores), width), np.float32), np.array(scores, np.float32)
    return Actor(
        layers=(layer,), mean=np.zeros(width), deviation=np.ones(width), head=head,
        activation="relu", squash=False, spread=np.zeros(settings.commands), settings=settings,
    )  # fmt: skip


def straight_in_space():
    """Return an actor of spatial arms that never differs from the straight way."""
    return constant_actor(SpatialSettings(), np.zeros(4), "velocity")


def leaning_in_space(ray=0):
    """Return an actor of spatial arms that always chooses the same command."""
    return constant_actor(SpatialSettings(fan=True), 5.0 * np.eye(COMMANDS)[ray], "choice")
