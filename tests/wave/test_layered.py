"""Layered marching: its states against what is free when, its arrivals against plain marching."""

from __future__ import annotations

import numpy as np
import pytest

from gcm_learn import seeding
from gcm_learn.charts.extended import occupied_cells
from gcm_learn.charts.lattice import hand_space
from gcm_learn.families.random_planar import random_planar
from gcm_learn.wave import MarchingParams
from gcm_learn.wave.causal import march_in_plane as march, march_layers_in_plane as march_layers
from tests.wave.scenes import SPEED, away, disc, earliest, scene, setting_of, state_of, three_discs

N = 48
BARE = MarchingParams(n=N, margin=0.0, lookback=0.0, until="horizon")
GUARDED = MarchingParams(n=N, until="horizon")


def test_all_but_exact_in_free_space():
    for k in range(50):
        hand = tuple(float(v) for v in seeding.rng(61, k).uniform(-1.2, 1.2, size=2))
        setting = setting_of(scene(hand=hand, horizon=3.0), N)
        front = march_layers(*setting, GUARDED)
        inside = hand_space(setting.lattice).inside.reshape(N, N)
        first = earliest(front, N)
        assert np.array_equal(np.isfinite(first), inside)
        assert len(front.cells) == inside.sum()  # one sheet
        error = first * SPEED / setting.lattice.spacing - away(setting)
        # Next to the hand a cell may be reached round its neighbour: that is the only error.
        assert np.abs(error[inside]).max() < 0.1
        assert np.percentile(np.abs(error[inside]), 75) < 1e-9


def test_among_things_at_rest_waiting_gains_nothing():
    compared = 0
    for k in range(20):
        setting = setting_of(three_discs(seeding.rng(62, k), moving=False, horizon=2.0), N)
        plain, front = march(*setting, GUARDED), march_layers(*setting, GUARDED)
        layered = earliest(front, N)
        # Plain marching goes round the cells of a target, as round what is frozen.
        both = (plain.first >= 0.0) & (state_of(plain) == 0) & (layered < front.met_time)
        if not both.any():
            continue  # the limb is blocked at the start
        compared += 1
        h = setting.lattice.spacing / SPEED
        assert np.abs(plain.first - layered)[both].max() < 3.0 * h
        assert np.median(np.abs(plain.first - layered)[both]) < 1e-9
    assert compared > 10


@pytest.mark.parametrize("k", range(12))
def test_states_are_free_for_as_long_as_they_say(k):
    situation = random_planar(seeding.rng(63, k), (3, 6))
    setting = setting_of(situation, N)
    front = march_layers(*setting, BARE)
    instants = np.linspace(0.0, situation.horizon, 241)
    blocked = np.array([occupied_cells(situation, setting.lattice, t) for t in instants])
    # Intervals are that fine.
    step, slack = instants[1], 0.25 * setting.lattice.spacing / setting.speed
    grazed = 0
    for (iy, ix), came, end in zip(front.cells, front.arrival, front.end, strict=True):
        inner = (instants >= came) & (instants <= end - slack)
        if blocked[inner, iy, ix].any():
            grazed += 1
            continue
        if end < situation.horizon - step:  # something comes then; discs may only graze the cell
            after = occupied_cells(situation, setting.lattice, end + 1e-3)[iy, ix]
            before = occupied_cells(situation, setting.lattice, end)[iy, ix]
            after_that = blocked[(instants > end) & (instants < end + 3 * step), iy, ix].any()
            assert before or after or after_that
    # Touches shorter than what a span of time is searched for are left to the verification.
    assert grazed <= 2e-3 * len(front.cells)


@pytest.mark.parametrize("k", range(12))
def test_ways_are_as_fast_as_the_hand_and_states_follow_from_states(k):
    situation = random_planar(seeding.rng(63, k), (3, 6))
    setting = setting_of(situation, N)
    front = march_layers(*setting, GUARDED)
    if not len(front.cells):
        pytest.skip("blocked from the start")
    place = setting.lattice.centres[front.cells[:, ::-1]]
    start = np.where(front.via[:, None] >= 0, place[front.via], setting.hand)
    since = np.where(front.via >= 0, front.arrival[front.via], 0.0)
    least = np.hypot(*(place - start).T) / setting.speed
    assert (front.arrival >= since + least - 1e-9).all()
    assert (front.via < np.arange(len(front.via))).all()
    # The hand may have to wait there, but not longer than the state lasts.
    until = np.where(front.via >= 0, front.end[front.via], np.inf)
    assert (front.arrival - least <= until + 1e-9).all()


def test_no_two_states_share_an_interval():
    several = 0
    for k in range(20):
        setting = setting_of(random_planar(seeding.rng(64, k), (3, 6)), N)
        front = march_layers(*setting, GUARDED)
        order = np.lexsort((front.arrival, *front.cells.T))
        same = (np.diff(front.cells[order], axis=0) == 0).all(axis=1)
        gap = front.arrival[order][1:] - front.end[order][:-1]
        assert (gap[same] > 0.0).all()
        several += same.sum()
    assert several > 50


def test_a_cell_is_entered_again_when_it_is_free():
    """A disc crosses the way: what it covered is reached behind it, as soon as it has passed."""
    crossing = scene(
        disc("obstacle", "disc", (0.6, 1.6), (0.0, -1.6), radius=0.2), hand=(1.5, 0.0), horizon=2.0
    )
    setting = setting_of(crossing, N)
    plain, first = march(*setting, GUARDED), earliest(march_layers(*setting, GUARDED), N)
    frozen = state_of(plain) == 1
    assert frozen.sum() > 20
    again = frozen & np.isfinite(first)
    assert again.sum() > 0.8 * frozen.sum()
    for iy, ix in np.argwhere(again):
        assert not occupied_cells(crossing, setting.lattice, first[iy, ix] + 1e-9)[iy, ix]


def test_to_the_horizon_it_goes_on_after_the_meeting():
    near = scene(disc("target", "near", (1.2, 0.3)), hand=(1.0, 0.0), horizon=1.5)
    setting = setting_of(near, N)
    stopped = march_layers(*setting, MarchingParams(n=N))
    explored = march_layers(*setting, GUARDED)
    assert stopped.met_time == explored.met_time < 0.5
    assert len(explored.nodes) > 2 * len(stopped.nodes)
    assert explored.arrival.max() > 0.9
