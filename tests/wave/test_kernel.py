"""The fast wave against the plain one, and what must hold of it whatever the scene."""

from __future__ import annotations

import numpy as np
import pytest

from gcm_learn import seeding
from gcm_learn.families import random_planar
from gcm_learn.situation import Body, PlanarQuadratic, Polygon
from gcm_learn.wave import WaveParams, kappa_of
from gcm_learn.wave.kernels import FREE, FROZEN
from gcm_learn.wave.reference import propagate_reference
from gcm_learn.wave.solver import propagate_in_plane as propagate
from tests.wave.scenes import (
    SYMMETRIES,
    arrival_tau,
    disc,
    in_threads,
    scene,
    setting_of,
    state_of,
    three_discs,
)

EXPLORE = "horizon"
LATE = 0.25  # the kernel traces a crossing back over at most 1.2 tau of curved rise [tau]
HANDFUL = 3  # cells grazed for so short a time that arrivals a hundredth of a tau apart decide


def compare(setting, params):
    """Hold the kernel against the reference; returns the kernel's front."""
    fast, plain = propagate(*setting, params), propagate_reference(*setting, params)
    assert np.count_nonzero(state_of(fast) != state_of(plain)) <= HANDFUL
    reached = (fast.first >= 0.0) & (plain.first >= 0.0)
    assert np.count_nonzero((fast.first >= 0.0) != (plain.first >= 0.0)) <= HANDFUL
    late = np.abs(fast.first - plain.first)[reached] / kappa_of(*setting, params)
    assert np.median(late) < 0.03
    assert np.quantile(late, 0.995) < LATE
    assert (fast.met_state, fast.met_body) == (plain.met_state, plain.met_body)
    assert abs(fast.met_time - plain.met_time) / kappa_of(*setting, params) < LATE
    return fast


VARIANTS = [
    WaveParams(n=40, until=EXPLORE),
    WaveParams(n=40, until=EXPLORE, laplacian=9),
    WaveParams(n=40, until=EXPLORE, start="printed", frozen="held"),
    WaveParams(n=40, until=EXPLORE, start_radius=3.0, margin=0.0),
    WaveParams(n=40, laplacian=9, start="printed", start_radius=3.0),
    WaveParams(n=80),
    WaveParams(n=80, until=EXPLORE, laplacian=9, frozen="held"),
]


@pytest.mark.parametrize(
    "number", [*range(5), *(pytest.param(k, marks=pytest.mark.slow) for k in (5, 6))]
)
def test_moving_discs(number):
    params = VARIANTS[number]
    situation = three_discs(seeding.rng(21, params.n))
    front = compare(setting_of(situation, params.n), params)
    assert np.count_nonzero(state_of(front) == FROZEN) >= (20 if params.until == EXPLORE else 1)
    assert front.met_body == 0


def test_free_space():
    params = WaveParams(n=80)
    setting = setting_of(scene(hand=(-0.31, 0.77), horizon=0.9))
    front = compare(setting, params)
    assert (state_of(front) == FREE).all() and front.met_state == -1
    assert np.count_nonzero(front.first >= 0.0) > 3000


@pytest.mark.parametrize(
    ("k", "arm", "frozen"),
    [
        (0, {}, "insulating"),
        (1, {"elbow": "left", "upper_arm": 0.9, "thickness": 0.03}, "held"),
        (2, {"elbow": "left", "upper_arm": 1.2}, "insulating"),
        (5, {"upper_arm": 0.6, "thickness": 0.05}, "insulating"),
    ],
)
@pytest.mark.parametrize("moving", [False, True])
def test_static_and_moving_discs(k, arm, frozen, moving):
    situation = three_discs(seeding.rng(22, k), moving, **arm)
    params = WaveParams(n=40, until=EXPLORE, frozen=frozen)
    front = compare(setting_of(situation, 40), params)
    assert np.count_nonzero(front.first >= 0.0) > 300


@pytest.mark.slow
@pytest.mark.parametrize("k", range(40))
def test_random_situations(k):
    situation = random_planar(seeding.rng(23, k))
    variant = VARIANTS[k % len(VARIANTS)]
    compare(setting_of(situation, variant.n), variant)


def test_contact_stops_the_front_unless_it_explores():
    situation = scene(disc("target", "ball", (-0.4, 1.0), (0.3, 0.2)))
    setting = setting_of(situation, 40)
    stopped, explored = (
        propagate(*setting, WaveParams(n=40, until=u)) for u in ("contact", EXPLORE)
    )
    assert stopped.met_body == explored.met_body == 0
    assert stopped.met_time == explored.met_time > 0.0
    assert stopped.steps < explored.steps
    assert stopped.first.max() < stopped.met_time + 2.0 * kappa_of(*setting, WaveParams(n=40))


def test_two_runs_give_the_same_bytes():
    setting = setting_of(three_discs(seeding.rng(21, 40)), 40)
    a, b = (propagate(*setting, WaveParams(n=40)) for _ in range(2))
    assert a.first.tobytes() == b.first.tobytes() and state_of(a).tobytes() == state_of(b).tobytes()


def test_threads_do_not_share_their_lattices():
    settings = [setting_of(three_discs(seeding.rng(24, k)), 40) for k in range(12)]
    params = WaveParams(n=40, until=EXPLORE)
    alone = [propagate(*s, params).first.tobytes() for s in settings]

    def work(order):
        return {k: propagate(*settings[k], params).first.tobytes() for k in order}

    up, down = list(range(12)) * 4, list(range(12))[::-1] * 4
    for found in in_threads(lambda: work(up), lambda: work(down)):
        assert [found[k] for k in range(12)] == alone


def square(position, velocity):
    corners = ((-0.1, -0.1), (0.1, -0.1), (0.1, 0.1), (-0.1, 0.1))
    return Body(
        "obstacle", "square", Polygon(corners), PlanarQuadratic(position, velocity, (0.0, 0.0))
    )


@SYMMETRIES
def test_symmetry(move, back):
    """The lattice is symmetric, so a moved scene gives the moved map."""
    situation = scene(
        square((0.2, 1.3), (0.4, -0.3)), disc("obstacle", "o", (-1.0, -0.6)), hand=(1.23, 0.31)
    )
    params = WaveParams(n=40, until=EXPLORE)
    setting, moved = setting_of(situation, 40), setting_of(move(situation), 40)
    here, there = propagate(*setting, params), propagate(*moved, params)
    assert (state_of(here) == FROZEN).sum() > 20
    assert np.array_equal(state_of(here), back(state_of(there)))
    difference = arrival_tau(setting, here, params) - back(arrival_tau(moved, there, params))
    assert np.nanmax(np.abs(difference)) < 0.01
