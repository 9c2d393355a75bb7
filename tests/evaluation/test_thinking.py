"""Thinking is charged: by the clock, and by what happens meanwhile."""

from __future__ import annotations

import time

import pytest

from gcm_learn import Arm, Body, Disc, PlanarQuadratic, Situation, solve
from gcm_learn.evaluation import Entry, compare
from gcm_learn.evaluation.kinds import charged
from gcm_learn.evaluation.measures import charged_curve, measured
from gcm_learn.evaluation.methods import get_method
from gcm_learn.planners import registry

LATENCY = 0.3  # of a slow planner [s]


class Slow:
    """Goes straight, and thinks long about what is new to it."""

    name = "slow"

    def __init__(self):
        self.known = set()

    def plan(self, situation):
        """Answer."""
        until = time.process_time() + LATENCY
        while situation.name in WORTH and situation.name not in self.known:
            if time.process_time() > until:
                self.known.add(situation.name)
        return solve(situation, "straight")


def body(role, position, velocity):
    """A disc on its way."""
    return Body(role, role, Disc(0.1), PlanarQuadratic(position, velocity, (0.0, 0.0)))


def scene(name, *bodies, horizon=1.0):
    """A situation with the hand at (1.5, 0)."""
    return Situation(name, horizon, Arm((1.5, 0.0), 3.0), bodies)


STILL = body("target", (1.2, 0.5), (0.0, 0.0))
PASSING = body("target", (1.2, 0.2), (4.0, 0.0))
WORTH = {
    "stays": (scene("stays", STILL), "caught"),
    "passes": (scene("passes", PASSING), "declined"),
    "ends": (scene("ends", STILL, horizon=0.29), "late"),
}
"""Situations that a planner catches at once, and what comes of them when it has thought."""


@pytest.fixture(scope="module")
def results():
    """Return what a slow planner makes of them."""
    patch = pytest.MonkeyPatch()
    patch.setitem(registry._ABOVE, "slow", f"{__name__}:Slow")
    entries = [
        Entry("made", k, situation, "made", "L", 0.1)
        for k, (situation, _) in enumerate(WORTH.values())
    ]
    yield compare(["slow"], entries, charge=3, workers=1)
    patch.undo()


def test_own_thinking_is_charged_by_the_clock(results):
    assert results["latency_ms"].min() >= 1e3 * LATENCY
    assert results["charged_0"].tolist() == results["outcome"].tolist() == ["caught"] * 3
    assert results["charged_own"].tolist() == [outcome for _, outcome in WORTH.values()]


def test_measures_tell_own_thinking_apart(results):
    slow = measured(results, "slow")
    assert slow.caught.value == 1.0 and slow.own.value == pytest.approx(1 / 3)
    assert charged_curve(results, "slow")[0].value == 1.0


def test_a_delay_is_charged_as_it_is_named(results):
    straight = get_method("straight")
    for delay in (0.02, 0.05, 0.1, 0.2):
        wanted = [charged(straight, situation, delay) for situation, _ in WORTH.values()]
        assert results[f"charged_{round(1e3 * delay)}"].tolist() == wanted


def test_what_meets_the_hand_while_it_rests_decides():
    straight = get_method("straight")
    rock, ball = body("obstacle", (1.5, 1.0), (0.0, -2.0)), body("target", (1.5, 1.0), (0.0, -2.0))
    assert charged(straight, scene("rock", STILL, rock), 0.2) == "caught"
    assert charged(straight, scene("rock", STILL, rock), 0.6) == "touched"
    assert charged(straight, scene("ball", ball), 0.6) == "caught"
