"""Perception that is not exact."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import families
from gcm_learn.evaluation.noise import Habit, Noise, _Memory, under_noise
from gcm_learn.evaluation.suites import Entry
from gcm_learn.motion.movement import Movement
from gcm_learn.planners import get_planner
from gcm_learn.scene.later import later
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
        outcomes = under_noise(straight, entries, Noise(0.0), Habit(replan))
        assert outcomes.count("caught") >= 14  # a last hair may be lost between steps
    blind = under_noise(straight, entries, Noise(0.08), Habit()).count("caught")
    again = under_noise(straight, entries, Noise(0.08), Habit(replan=True)).count("caught")
    assert blind < 12 and again > blind


def test_all_looks_tell_more_than_the_last(rng):
    """Errors of what is remembered are smaller, and as large as the memory says they are."""
    situation, _ = canonical(families.draw("crossing-swarm", 31, 4))
    noise, speed = Noise(0.05), situation.arm.max_hand_speed
    last, known, said = [], [], 0.0
    for _ in range(150):
        memory = _Memory(speed)
        for k in range(6):
            now = later(situation, 0.05 * k)
            seen = noise.seen(now, rng)
            joined = memory.joined(seen, 0.05 * k)
        said = memory.share
        for true, one, all_looks in zip(now.bodies, seen.bodies, joined.bodies, strict=True):
            if any(true.motion.velocity):
                last.append(np.subtract(one.motion.position, true.motion.position))
                known.append(np.subtract(all_looks.motion.position, true.motion.position))
    assert np.std(last) == pytest.approx(0.05, rel=0.1)
    assert np.std(known) == pytest.approx(0.05 * said, rel=0.1) and said < 0.8


def test_a_pendulum_is_remembered_too(rng):
    situation, _ = canonical(families.draw("pendulum", 31, 3))
    swings = [k for k, b in enumerate(situation.bodies) if b.motion.kind == "pendulum"]
    off = {"last": [], "known": []}
    for _ in range(100):
        memory = _Memory(situation.arm.max_hand_speed)
        for k in range(6):
            now = later(situation, 0.05 * k)
            seen = Noise(0.05).seen(now, rng)
            joined = memory.joined(seen, 0.05 * k)
        for b in swings:
            angle = now.bodies[b].motion.angle
            off["last"].append(seen.bodies[b].motion.angle - angle)
            off["known"].append(joined.bodies[b].motion.angle - angle)
    assert swings and np.std(off["known"]) < 0.8 * np.std(off["last"])


class Waverer:
    """Goes straight at first, and at every later look wants to rest for long."""

    def __init__(self):
        self.asked = 0

    def plan(self, situation):
        plan = get_planner("straight").plan(situation)
        self.asked += 1
        if self.asked == 1:
            return plan
        arm = situation.arm
        rest = Movement.of_hand(arm, np.array([0.0, 9.0]), np.array([arm.hand, arm.hand]))
        return replace(plan, status="caught", trajectory=rest)


def test_a_way_that_still_holds_is_kept():
    for entry in entries_of(6):
        waverer = Waverer()
        assert under_noise(waverer, [entry], Noise(0.0), Habit(replan=True)) == ["caught"]
        assert waverer.asked > 1
