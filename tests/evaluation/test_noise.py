"""Perception that is not exact."""

from __future__ import annotations

import numpy as np

from gcm_learn import families
from gcm_learn.evaluation.noise import Noise, under_noise
from gcm_learn.evaluation.suites import Entry
from gcm_learn.planners import get_planner
from gcm_learn.situation.canonical import canonical


def entries_of(count):
    """Situations that `straight` catches."""
    found, k = [], 0
    while len(found) < count:
        situation, _ = canonical(families.draw("random-planar", 31, k))
        if get_planner("straight").plan(situation).caught:
            found.append(Entry("made", k, situation, "random-planar", "L", 0.5))
        k += 1
    return found


def test_errors_are_as_large_as_said(rng):
    (entry,) = entries_of(1)
    seen = [Noise(0.03).seen(entry.situation, rng) for _ in range(400)]
    motion = entry.situation.bodies[0].motion
    off = np.array([s.bodies[0].motion.position for s in seen]) - motion.position
    assert np.abs(off.mean(axis=0)).max() < 0.006
    np.testing.assert_allclose(off.std(axis=0), 0.03, rtol=0.15)


def test_exact_perception_changes_nothing_and_looking_again_helps():
    entries, straight = entries_of(15), get_planner("straight")
    for replan in (False, True):
        outcomes = under_noise(straight, entries, Noise(0.0), replan=replan)
        assert outcomes.count("caught") >= 14  # a last hair may be lost between steps
    blind = under_noise(straight, entries, Noise(0.08), replan=False).count("caught")
    again = under_noise(straight, entries, Noise(0.08), replan=True).count("caught")
    assert blind < 12 and again > blind
