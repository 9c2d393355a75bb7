"""Causal marching: exact in free space, close to the shortest way round walls, kin to the wave."""

from __future__ import annotations

import numpy as np
import pytest

from gcm_learn import seeding
from gcm_learn.charts.lattice import hand_space
from gcm_learn.wave import MarchingParams, WaveParams
from gcm_learn.wave.causal import march_in_plane as march
from gcm_learn.wave.kernels import CONTACT, FREE, FROZEN
from gcm_learn.wave.solver import propagate_in_plane as propagate
from tests.wave.scenes import (
    SPEED,
    SYMMETRIES,
    away,
    disc,
    in_threads,
    scene,
    setting_of,
    state_of,
    three_discs,
)

EXPLORE = MarchingParams(until="horizon")
COARSE = MarchingParams(n=40, until="horizon")


def in_cells(setting, front):
    """Arrival as a distance at hand speed [cells], nan where the front never came."""
    return np.where(front.first >= 0.0, front.first * SPEED / setting.lattice.spacing, np.nan)


@pytest.mark.parametrize("arm", [{}, {"upper_arm": 0.4, "hand": (0.9, 0.1)}])
def test_exact_in_free_space(arm):
    """With an inner hole (rho = 0.4) exact where the hole is not in the way."""
    params = MarchingParams(n=56, until="horizon")
    for k in range(300):
        rng = seeding.rng(41, k)
        hand = tuple(float(v) for v in rng.uniform(-1.2, 1.2, size=2))
        setting = setting_of(scene(horizon=3.0, **({"hand": hand} | arm)), 56)
        front = march(*setting, params)
        inside = hand_space(setting.lattice).inside.reshape(56, 56)
        assert np.array_equal(front.first >= 0.0, inside)
        assert (state_of(front) == FREE).all()
        x, _ = np.meshgrid(setting.lattice.centres, setting.lattice.centres)
        seen = inside & ((setting.lattice.upper_arm == 1.0) | (x > 0.65))
        error = np.abs(in_cells(setting, front) - away(setting))[seen]
        assert error.max() < 1e-9, f"start {k}"
        if arm:
            break


def test_anisotropy():
    setting = setting_of(scene(hand=(0.41, -0.2), horizon=3.0))
    distance = away(setting)
    far = (distance > 10.0) & hand_space(setting.lattice).inside.reshape(80, 80)
    speed = distance[far] / in_cells(setting, march(*setting, EXPLORE))[far]
    assert 1.0 - speed.min() / speed.max() <= 0.01


def closed_corners(blocked):
    """Blocked cells (3n, 3n) on a grid three times as fine, with no way between two that touch."""
    fine = np.kron(blocked, np.ones((3, 3), dtype=bool))
    for i, j in np.argwhere(blocked[:-1, :-1] & blocked[1:, 1:]):
        fine[3 * i + 2, 3 * j + 3] = fine[3 * i + 3, 3 * j + 2] = True
    for i, j in np.argwhere(blocked[:-1, 1:] & blocked[1:, :-1]):
        fine[3 * i + 2, 3 * j + 2] = fine[3 * i + 3, 3 * j + 3] = True
    return fine


def free_lengths(fine, points, others):
    """Lengths (p, o) [cells] of straight ways, infinite where something is in between."""
    share = np.linspace(0.0, 1.0, 240)[:, None, None]
    out = np.empty((len(points), len(others)))
    for k, point in enumerate(points):
        way = np.floor(3.0 * (point + share * (others - point) + 0.5)).astype(int)
        way = np.clip(way, 0, len(fine) - 1)
        free = ~fine[way[..., 0], way[..., 1]].any(axis=0)
        out[k] = np.where(free, np.hypot(*(others - point).T), np.inf)
    return out


def shortest_ways(setting, blocked):
    """Lengths (n, n) [cells] of the shortest ways from the hand past blocked cells.

    Ways are polygons whose corners are free cells next to blocked ones: a visibility graph.
    """
    n, reach = len(blocked), setting.lattice.upper_arm + 1.0
    hand = (np.array(setting.hand)[::-1] + reach) / setting.lattice.spacing - 0.5
    ring = hand_space(setting.lattice).inside.reshape(n, n)
    padded, free = np.pad(blocked, 1), ring & ~blocked
    shifts = [(i, j) for i in range(3) for j in range(3)]
    near = np.any([padded[i : i + n, j : j + n] for i, j in shifts], axis=0)
    # Cells beyond the rim may be crossed, but not to slip round the end of a wall.
    fine = closed_corners(blocked | (near & ~ring))
    corners = np.vstack([hand, np.argwhere(free & near)])
    between = free_lengths(fine, corners, corners)
    length = between[0].copy()
    for _ in range(40):
        length = np.minimum(length, (length[:, None] + between).min(axis=0))
    cells = np.argwhere(free)
    ways = np.full((n, n), np.nan)
    ways[tuple(cells.T)] = (length[:, None] + free_lengths(fine, corners, cells)).min(axis=0)
    return ways


@pytest.mark.parametrize(
    ("hand", "place", "radius"),
    [
        ((1.2, -0.5), (0.3, 0.6), 0.05),
        ((0.3, 1.3), (1.2, 0.3), 0.2),
        pytest.param((0.3, 1.3), (1.0, -0.3), 0.1, marks=pytest.mark.slow),
        pytest.param((-1.3, 0.3), (1.0, 0.3), 0.1, marks=pytest.mark.slow),
    ],
)
def test_round_a_static_wall(hand, place, radius):
    """The front's times are those of the shortest ways round what it froze, or nearly so."""
    wall = disc("obstacle", "wall", place, radius=radius)
    setting = setting_of(scene(wall, hand=hand, horizon=5.0), 40)
    front = march(*setting, COARSE)
    frozen = state_of(front) == FROZEN
    exact, found = shortest_ways(setting, frozen), in_cells(setting, front)
    cells = ~frozen & np.isfinite(found)
    assert np.array_equal(cells, np.isfinite(exact))
    error = (found - exact)[cells]
    hidden = (exact - away(setting))[cells] > 0.5
    assert np.count_nonzero(hidden) > 100
    assert error.min() > -0.2 and error.max() < 1.0
    assert np.median(np.abs(error[hidden])) < 0.15
    assert np.quantile(np.abs(error), 0.95) < 0.3


def test_static_obstacles_only_make_it_later():
    for k in range(15):
        rng = seeding.rng(42, k)
        situation = three_discs(rng, moving=False)
        bodies = situation.bodies[1:4]
        before = None
        for count in range(4):
            setting = setting_of(scene(*bodies[:count], horizon=5.0))
            front = march(*setting, EXPLORE)
            arrival = np.where(state_of(front) == FREE, in_cells(setting, front), np.nan)
            arrival[np.isnan(arrival)] = np.inf
            if before is not None:
                assert np.isinf(arrival[np.isinf(before)]).all()
                # A front of several bends may be late by 3 % where an earlier wall meets a later.
                assert (arrival >= 0.97 * before)[np.isfinite(before)].all()
                assert np.mean(arrival < before - 0.1) < 0.06
            before = arrival


@pytest.mark.parametrize(
    ("place", "scatter"), [(None, 4.0), ((0.2, 1.2), 8.0), ((1.4, -0.5), 8.0), ((1.6, 1.0), 5.0)]
)
def test_marching_and_wave_agree(place, scatter):
    """Beyond 10 cells and but for an affine map: a single neuron starts slowly, bends cost time."""
    walls = [] if place is None else [disc("obstacle", "wall", place)]
    setting = setting_of(scene(*walls, horizon=3.0))
    wave = propagate(*setting, WaveParams(until="horizon", laplacian=9))
    marched = march(*setting, EXPLORE)
    both = (away(setting) > 10.0) & (wave.first > 0.0) & (marched.first > 0.0)
    both &= (state_of(wave) == FREE) & (state_of(marched) == FREE)
    assert np.count_nonzero(both) > 4000
    ours, theirs = (front.first[both] * 400.0 for front in (marched, wave))  # [tau]
    slope, shift = np.polyfit(ours, theirs, 1)
    assert 1.0 <= slope < 1.06 and 15.0 < shift < 30.0
    assert np.std(theirs - slope * ours - shift) < scatter
    frozen = [state_of(front) == FROZEN for front in (wave, marched)]
    assert np.count_nonzero(frozen[0] != frozen[1]) <= 0.05 * np.count_nonzero(frozen[0])


@SYMMETRIES
def test_symmetry(move, back):
    for k in range(8):
        situation = three_discs(seeding.rng(44, k))
        here, there = (march(*setting_of(s, 40), COARSE) for s in (situation, move(situation)))
        assert np.count_nonzero(state_of(here) != back(state_of(there))) <= 2
        setting = setting_of(situation, 40)
        difference = np.abs(in_cells(setting, here) - back(in_cells(setting, there)))
        # Of two ways of the same length round an obstacle, either may be the first.
        assert np.nanmedian(difference) < 1e-9 and np.nanmax(difference) < 1.0


def test_contact():
    ball = disc("target", "ball", (-0.4, 1.0), radius=0.05)
    setting = setting_of(scene(ball, grasp=0.05))
    front = march(*setting, MarchingParams())
    assert front.met_body == 0 and state_of(front).ravel()[front.met_state] == CONTACT
    exact = (np.hypot(-0.4 - 1.2, 1.0 - 0.3) - 0.1) / SPEED
    assert front.met_time == pytest.approx(exact, abs=setting.lattice.spacing / SPEED)


def test_same_bytes_again_and_in_threads():
    settings = [setting_of(three_discs(seeding.rng(45, k)), 40) for k in range(8)]
    alone = [march(*s, COARSE).first.tobytes() for s in settings]

    def work():
        return [march(*s, COARSE).first.tobytes() for _ in range(10) for s in settings]

    assert in_threads(work, work) == [alone * 10] * 2
