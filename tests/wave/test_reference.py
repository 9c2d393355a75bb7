"""The dynamics of Eq. 10, in the plain implementation that the kernel is held against."""

from __future__ import annotations

import numpy as np
import pytest

from gcm_learn.wave import WaveParams
from gcm_learn.wave.params import EXCITED, REST
from gcm_learn.wave.reference import couplings, euler_step, reaction

SADDLE = (1.0, -1.0 / 7.0)
PARAMS = WaveParams()


def jacobian(r, epsilon=PARAMS.epsilon):
    return np.array([[(-3 * r**2 + 8 * r - 2) / 7, -1.0], [epsilon, -7 * epsilon]])


@pytest.mark.parametrize("point", [REST, SADDLE, EXCITED])
def test_fixed_points(point):
    assert reaction(*map(np.float64, point), PARAMS.epsilon) == pytest.approx((0.0, 0.0), abs=1e-15)


def test_rest_and_excited_states_are_stable_and_the_third_is_a_saddle():
    assert np.linalg.eigvals(jacobian(REST[0])).real.max() < 0.0
    assert np.linalg.eigvals(jacobian(EXCITED[0])).real.max() < 0.0
    saddle = np.sort(np.linalg.eigvals(jacobian(SADDLE[0])).real)
    assert saddle == pytest.approx([-0.218, 0.367], abs=1e-3)


def run(r, z, steps, params=PARAMS, q=1.0, diffusion=None):
    coupled = couplings(np.ones(r.shape, dtype=bool), params.laplacian)
    for _ in range(steps):
        r, z = euler_step(r, z, q * np.ones_like(r), coupled, params, diffusion)
    return r, z


def test_true_rest_is_at_rest_and_the_printed_start_is_not():
    shape = (6, 6)
    r, _ = run(np.full(shape, REST[0]), np.full(shape, REST[1]), 100)
    assert np.abs(r).max() < 1e-14
    r, _ = run(np.zeros(shape), np.zeros(shape), 12)  # 2.4 tau
    assert r.min() == pytest.approx(-0.28, abs=0.02)


def strip_front(length, steps, params=PARAMS, diffusion=None, rows=3):
    """Crossing times [tau] of the columns of a strip whose first column is held excited."""
    r, z = np.full((rows, length), REST[0]), np.full((rows, length), REST[1])
    q = np.ones_like(r)
    r[:, 0], q[:, 0] = EXCITED[0], 0.0
    coupled = couplings(np.ones(r.shape, dtype=bool), params.laplacian)
    crossing = np.full(r.shape, np.nan)
    for k in range(steps):
        before = r
        r, z = euler_step(r, z, q, coupled, params, diffusion)
        up = (before < 1.0) & (r >= 1.0)
        crossing[up] = (k + (1.0 - before[up]) / (r[up] - before[up])) * params.step
    return crossing


def test_planar_front():
    crossing = strip_front(50, 1500)
    speed = 1.0 / np.polyfit(np.arange(20, 45), crossing[1, 20:45], 1)[0]
    assert speed == pytest.approx(0.166, abs=5e-4)
    # No flux crosses the border: the front stays as straight as it set out.
    assert np.ptp(crossing[:, 1:45], axis=0).max() < 1e-9


def test_planar_front_on_nine_points():
    """Corner neighbours beyond the border are missed there, so the front lags along it."""
    crossing = strip_front(50, 1500, WaveParams(laplacian=9), rows=41)
    speed = 1.0 / np.polyfit(np.arange(20, 45), crossing[20, 20:45], 1)[0]
    assert speed == pytest.approx(0.166, abs=1e-3)
    lag = crossing[0, 1:45] - crossing[20, 1:45]
    assert 2.0 < lag.max() < 6.0


def test_the_front_fails_at_small_diffusion():
    assert np.isnan(strip_front(12, 2000, diffusion=0.045)[1, 6])
    assert strip_front(12, 2000, diffusion=0.05)[1, 6] > 0.0


def test_nothing_flows_into_cells_that_are_not_live(rng):
    live = rng.random((7, 9)) < 0.6
    for points in (5, 9):
        flow = np.zeros(live.shape)
        for (i, j), weight in couplings(live, points):
            flow += weight
            there = np.roll(live, (-i, -j), axis=(0, 1))
            assert not weight[~live | ~there].any()
        # Only cells within, all of whose neighbours are live, exchange with full weight.
        assert flow.max() <= 4.0 + 1e-12
        assert (couplings(np.ones((3, 3), dtype=bool), points)[0][1][:, :2] > 0.0).all()
