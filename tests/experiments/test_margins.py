"""Scenes among recorded bodies: their draws know laws only."""

from __future__ import annotations

import importlib

import numpy as np
import pytest

from gcm_learn.outside import Window, places_of
from gcm_learn.situation import Margin
from tests.experiments.test_outside import ROOT

TIMES = np.linspace(0.0, 0.5, 6)


def walkers(seed, bends):
    """Return windows of people who are seen to walk straight, and bend off by some acceleration."""
    rng, looks = np.random.default_rng(seed), np.array([-0.2, -0.1, 0.0])
    found = []
    for _ in range(40):
        way = np.append(rng.normal(size=2), 0.0)
        seen, ahead = np.outer(looks, way), np.outer(TIMES, way)
        found.append(Window(looks, seen, TIMES, ahead + bends * np.outer(TIMES**2, way[[1, 0, 2]])))
    return found


@pytest.fixture
def scenes(monkeypatch):
    monkeypatch.syspath_prepend(ROOT / "experiments" / "25_margins")
    return importlib.import_module("scenes")


def test_draws_know_laws_alone_and_keep_the_errors(scenes):
    straight, bent = (scenes.draws(scenes.People(walkers(4, b)), 3, 4) for b in (0.0, 2.0))
    for one, other in zip(straight, bent, strict=True):
        assert one.laws == other.laws and one.arm == other.arm and one.fixed == other.fixed
        for law, same, wrong in zip(one.laws, one.windows, other.windows, strict=True):
            np.testing.assert_allclose(places_of(law, TIMES), same.places, atol=1e-9)
            off = np.linalg.norm(wrong.places - same.places, axis=1)
            fast = np.linalg.norm(same.places[-1] - same.places[0]) / TIMES[-1]
            np.testing.assert_allclose(off, 2.0 * fast * TIMES**2, atol=1e-9)
        foretold, truth = (other.situation(margin) for margin in (Margin(0.1, 0.2), None))
        assert foretold.obstacles[0].margin == Margin(0.1, 0.2)
        assert [body.motion.kind for body in truth.obstacles] == ["sampled"]
