"""Speed, delay and bias of the free front, and what its parameters may be (errata 8 to 10)."""

from __future__ import annotations

import numpy as np
import pytest

from gcm_learn import seeding
from gcm_learn.charts.lattice import Lattice, hand_space
from gcm_learn.errors import LatticeError
from gcm_learn.wave import MarchingParams, WaveParams, front_speed
from gcm_learn.wave.causal import march_in_plane as march
from gcm_learn.wave.kernels import live_weight
from gcm_learn.wave.solver import propagate_in_plane as propagate
from gcm_learn.wave.stencil import LEFT, layout, room, two_steps
from tests.wave.scenes import SPEED, arrival_tau, away, disc, scene, setting_of


def free_arrival(**changes):
    """Distance [cells] and arrival [tau] of the free front on the paper's lattice."""
    params = WaveParams(until="horizon", **changes)
    setting = setting_of(scene(hand=(0.025, 0.025), horizon=3.0))
    arrival, distance = arrival_tau(setting, propagate(*setting, params), params), away(setting)
    ring = (distance > 5.0) & (distance < 39.0)
    return distance[ring], arrival[ring]


def delay(**changes):
    """Arrival extrapolated back to the hand [tau]."""
    return np.polyfit(*free_arrival(**changes), 1)[1]


def test_speed_on_five_points():
    speed = front_speed(WaveParams())
    assert 0.160 < speed.axis < 0.163
    assert 0.167 < speed.diagonal < 0.172
    assert speed.diagonal == pytest.approx(speed.fastest, rel=0.01)
    assert 0.05 <= speed.anisotropy <= 0.07


def test_speed_on_nine_points():
    speed = front_speed(WaveParams(laplacian=9))
    assert speed.anisotropy <= 0.035
    assert speed.fastest == pytest.approx(0.163, abs=0.003)


@pytest.mark.parametrize("points", [5, 9])
def test_nowhere_faster_than_the_hand(points):
    """Kappa is such that the front of a free scene moves at hand speed at most."""
    params = WaveParams(laplacian=points, until="horizon")
    setting = setting_of(scene(hand=(0.4, 0.9), horizon=3.0))
    front, distance = propagate(*setting, params), away(setting)
    cells = distance > 10.0
    speed = distance[cells] * setting.lattice.spacing / front.first[cells]
    assert speed.max() < SPEED
    grown = np.gradient(front.first, setting.lattice.spacing)
    slope = np.hypot(*grown)[20:60, 20:60][distance[20:60, 20:60] > 25.0]
    assert 1.0 / slope.min() < 1.01 * SPEED


@pytest.mark.parametrize("points", [5, 9])
def test_a_single_neuron_takes_its_time(points):
    single = delay(laplacian=points)
    assert single == pytest.approx(18.0, abs=3.0)
    assert delay(laplacian=points, start_radius=3.0) < single - 3.0


def test_a_stretched_arm_starts_a_front():
    """The hand's own cell may have its centre beyond the rim."""
    outside = 0
    for k in range(60):
        angle = 2.0 * np.pi * (k + 0.3) / 60
        hand = (2.0 * np.cos(angle), 2.0 * np.sin(angle))
        setting = setting_of(scene(hand=hand, horizon=4.0), 40)
        inside = hand_space(setting.lattice).inside.reshape(40, 40)
        outside += not inside[setting.lattice.cell_of(hand)]
        wave = propagate(*setting, WaveParams(n=40, until="horizon"))
        marched = march(*setting, MarchingParams(n=40, until="horizon"))
        assert np.array_equal(wave.first >= 0.0, inside)
        assert np.array_equal(marched.first >= 0.0, inside)
    assert outside > 5


@pytest.mark.parametrize("points", [5, 9])
def test_the_printed_start_is_late_by_six(points):
    late = delay(laplacian=points, start="printed") - delay(laplacian=points)
    assert late == pytest.approx(6.0, abs=1.0)


def test_bias_of_the_time_step():
    _, exact = free_arrival(step=0.02)
    bias = {
        step: np.mean(free_arrival(step=step)[1] - exact) for step in (0.1, 0.2, 0.25, 0.5, 0.86)
    }
    assert bias[0.1] == pytest.approx(0.3, abs=0.15)
    assert bias[0.2] == pytest.approx(0.6, abs=0.2)
    assert bias[0.25] == pytest.approx(0.8, abs=0.25)
    assert bias[0.5] == pytest.approx(1.5, abs=0.3)
    assert bias[0.86] < 3.5


def chessboard_left(points, step, diffusion):
    """What a chessboard of 1e-3 on an excited lattice has become after 800 steps."""
    n, shape = 40, layout(40)
    buffer = np.zeros_like(room(n))
    plane = [
        buffer[k * shape.plane :][: (n + 2) * shape.width].reshape(n + 2, -1) for k in range(5)
    ]
    r, _, z, rate, live = (p[1:-1, LEFT : LEFT + n] for p in plane)
    r[:], z[:], rate[:] = 3.0 + 1e-3 * (-1.0) ** np.add.outer(range(n), range(n)), 1.0 / 7.0, step
    ones = np.pad(np.ones((n, n)), 1)
    turns = [(a, b) for a in (-1, 0, 1) for b in (-1, 0, 1) if (a, b) != (0, 0)]
    for a, b in turns:
        live += live_weight(points, a != 0 and b != 0) * np.roll(ones, (a, b), (0, 1))[1:-1, 1:-1]
    first = np.arange(1, n + 1, dtype=np.uint64) * np.uint64(shape.width) + np.uint64(LEFT)
    d, eps = np.float32(diffusion), np.float32(0.04 * step)
    for _ in range(400):
        two_steps(buffer, first, first + np.uint64(n), n, d, eps, shape.width, points)
    return float(np.abs(r - 3.0).max())


@pytest.mark.parametrize(("points", "largest"), [(5, 8.0), (9, 16.0 / 3.0)])
def test_steps_are_refused_from_where_a_chessboard_grows(points, largest):
    bound = 2.0 / (5.0 / 7.0 + largest * 0.5)
    settling = WaveParams(laplacian=points, step=0.995 * bound, diffusion=0.5)
    assert chessboard_left(points, settling.step, 0.5) < 1e-4
    assert not chessboard_left(points, 1.03 * bound, 0.5) < 1e-2
    with pytest.raises(LatticeError, match=f"unstable with diffusion 0.5 on {points} points"):
        WaveParams(laplacian=points, step=1.005 * bound, diffusion=0.5)


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"diffusion": 0.045}, "diffusion"),
        ({"diffusion": 1.5}, "diffusion"),
        ({"diffusion": float("nan")}, "diffusion"),
        ({"epsilon": 0.0}, "epsilon"),
        ({"epsilon": 0.2}, "epsilon"),
        ({"step": 0.0}, "step"),
        ({"step": 1.0}, "step"),
        ({"threshold": 0.4}, "threshold"),
        ({"threshold": 2.5}, "threshold"),
        ({"laplacian": 7}, "laplacian"),
        ({"start": "cold"}, "start"),
        ({"start_radius": -1.0}, "start_radius"),
        ({"start_radius": 11.0}, "start_radius"),
        ({"frozen": "solid"}, "frozen"),
        ({"margin": -0.1}, "margin"),
        ({"margin": 11.0}, "margin"),
        ({"until": "tomorrow"}, "until"),
        ({"step": 0.9, "diffusion": 1.0}, "step"),
        ({"step": 0.87}, "step"),  # at the default diffusion
    ],
)
def test_refused_parameters(changes, named):
    with pytest.raises(LatticeError, match=named) as refusal:
        WaveParams(**changes)
    assert "\n" not in str(refusal.value)
    assert str(next(iter(changes.values()))) in str(refusal.value)


@pytest.mark.parametrize("n", [15, 0, 10_000])
def test_refused_lattices(n):
    with pytest.raises(LatticeError, match=str(n)):
        Lattice(n)
    with pytest.raises(LatticeError, match="elbow"):
        Lattice(40, elbow="up")


@pytest.mark.parametrize("run", ["wave", "marching"])
def test_thin_and_fast_targets_are_not_missed(run):
    """A speck that flies across the hand's place must cross the front on its way."""
    for k in range(100):
        rng = seeding.rng(31, k)
        angle, speed = rng.uniform(-np.pi, np.pi), rng.uniform(0.5, 20.0) * SPEED
        flight = rng.uniform(0.2, 0.45)  # until it is where the hand was, before the rim is reached
        way = np.array([np.cos(angle), np.sin(angle)]) * speed
        start = np.array([0.3, 0.1]) - way * flight
        speck = disc("target", "speck", tuple(start), tuple(way), radius=1e-4)
        setting = setting_of(scene(speck, hand=(0.3, 0.1), horizon=1.5, grasp=0.0), 40)
        if run == "wave":
            front = propagate(*setting, WaveParams(n=40))
        else:
            front = march(*setting, MarchingParams(n=40))
        assert front.met_body == 0
        # At some instant while the front was on its way into that cell, the speck was there.
        iy, ix = divmod(front.met_state, 40)
        cell, crossing = setting.lattice.centres[[ix, iy]], setting.lattice.spacing / SPEED
        times = front.met_time - np.linspace(0.0, 1.5 * crossing, 4000)
        distance = np.hypot(*(start + way * times[:, None] - cell).T)
        assert distance.min() <= 0.72 * setting.lattice.spacing
