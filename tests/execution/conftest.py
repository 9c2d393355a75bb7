"""Situations that the tests of the arena share."""

from __future__ import annotations

import pytest

from gcm_learn import families, seeding
from gcm_learn.motion.rules import start_clearance
from gcm_learn.scene.packing import pack

NAMES = ("random-planar", "gate", "moving-point", "pendulum", "falling-solid", "spinning")


@pytest.fixture(scope="session")
def scenes():
    """Return situations of several families, planar and in space, with and without joint limits."""
    from dataclasses import replace

    found = [families.draw(name, 5, k) for name in NAMES for k in range(5)]
    free = [s for s in found if start_clearance(pack(s)) > 0.0]
    slow = [replace(s, arm=replace(s.arm, max_joint_speed=(3.0, 4.0))) for s in free[:3]]
    return tuple(free + slow)


@pytest.fixture
def rng():
    """Return a generator of its own for every test."""
    return seeding.rng(11)
