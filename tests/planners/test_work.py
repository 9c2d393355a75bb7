"""Limits of work: planning ends among bodies that spin absurdly fast, and says why."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import Polygon, families, solve
from gcm_learn.collision.sweep import DEEPEST, Sweep, leg_is_free
from gcm_learn.motion import Failure
from gcm_learn.scene import pack
from gcm_learn.situation import Body, Box, PlanarQuadratic, SolidQuadratic

SPIN = 1e5  # [rad/s]
STILL = (0.0, 0.0, 0.0)


def needle_in_the_way(family, seed):
    """Return a situation with a needle that spins where the hand would go straight."""
    for k in range(60):
        drawn = families.draw(family, seed, k)
        alone = replace(drawn, bodies=drawn.targets)
        plan = solve(alone, "straight")
        if plan.trajectory is None:
            continue
        hand = plan.trajectory.hand
        centre = tuple(hand[int(0.7 * (len(hand) - 1))].tolist())
        if len(centre) == 2:
            corners = ((-0.2, -0.003), (0.2, -0.003), (0.2, 0.003), (-0.2, 0.003))
            motion = PlanarQuadratic(centre, (0.0, 0.0), (0.0, 0.0), 0.0, SPIN)
            needle = Body("obstacle", "needle", Polygon(corners), motion)
        else:
            motion = SolidQuadratic(centre, STILL, STILL, (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, SPIN))
            needle = Body("obstacle", "needle", Box((0.4, 0.003, 0.003)), motion)
        situation = replace(alone, bodies=(*alone.bodies, needle))
        if solve(situation, "straight").status == "unreachable":
            return situation
    raise AssertionError("no situation in which the needle is in the way")


@pytest.fixture(scope="module", params=["gate", "falling-space"])
def situation(request):
    """Return a planar or a spatial situation with a needle in the way."""
    return needle_in_the_way(request.param, 7)


def test_the_search_ends_and_says_why(situation):
    plan = solve(situation, "search")
    assert plan.failure is Failure.OUT_OF_WORK
    again = solve(situation, "search")
    assert (again.message, again.nodes) == (plan.message, plan.nodes)


@pytest.mark.parametrize("planner", ["marching", "straight-wait"])
@pytest.mark.parametrize("family", ["gate", pytest.param("falling-space", marks=pytest.mark.slow)])
def test_other_planners_end_too(family, planner):
    assert solve(needle_in_the_way(family, 7), planner).status in ("caught", "unreachable")


def test_slower_needles_are_planned_for(situation):
    needle = situation.bodies[-1]
    spin = 1.0 if isinstance(needle.motion, PlanarQuadratic) else (0.0, 0.0, 1.0)
    calm = replace(needle, motion=replace(needle.motion, spin=spin))
    plan = solve(replace(situation, bodies=(*situation.targets, calm)), "search")
    assert plan.failure is not Failure.OUT_OF_WORK


def test_a_leg_beyond_the_limit_counts_as_touching():
    """The limit counts distances: one less than the leg takes is too few."""
    scene = pack(needle_in_the_way("gate", 7))
    hand = np.array([[scene.limb.x, scene.limb.y]] * 2)
    bodies = np.zeros((len(scene.bodies.rows), 12))
    work = Sweep(np.array([0.0, 1e-4]), hand, 0.0, 1e9, bodies, np.empty((DEEPEST + 2, 3)))
    enough = np.full(1, 1_000_000)
    assert leg_is_free(scene, work, np.empty(64), enough)
    taken = 1_000_000 - int(enough[0])
    assert taken > 1
    assert leg_is_free(scene, work, np.empty(64), np.full(1, taken))
    assert not leg_is_free(scene, work, np.empty(64), np.full(1, taken - 1))
