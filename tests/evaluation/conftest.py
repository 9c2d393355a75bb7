"""Fixtures of the tests of comparisons."""

from __future__ import annotations

import pytest

from gcm_learn import seeding


@pytest.fixture
def rng():
    """Return a generator of its own for every test."""
    return seeding.rng(12)
