"""The wave that may wait: against its plain version, the published wave, marching, the world."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from gcm_learn import seeding
from gcm_learn.arms.planar_limb import elbow_position
from gcm_learn.charts.extended import occupied_cells
from gcm_learn.families.random_planar import random_planar
from gcm_learn.situation import Body, Disc, PlanarQuadratic, Polygon
from gcm_learn.wave import (
    MarchingParams,
    WaveParams,
    front_speed,
    kappa_of,
    march_layers,
    propagate,
    propagate_layers,
)
from gcm_learn.wave.inhibition import TICK
from gcm_learn.wave.reference import propagate_reference
from gcm_learn.wave.waiting import free_clock
from tests.wave.scenes import (
    SPEED,
    STILL,
    SYMMETRIES,
    away,
    disc,
    earliest,
    in_threads,
    scene,
    setting_of,
    three_discs,
)

EXPLORE = "horizon"
NINE = WaveParams(n=80, laplacian=9, until=EXPLORE)
MARCH = MarchingParams(until=EXPLORE)
SPECK = 1e-4  # radius of bodies that are walls in hand-space and nothing else [forearm lengths]


def lateness(front, other, where):
    """By how much cells are reached later than by another front [tau], where a mask is true."""
    first, second = earliest(front, 80), earliest(other, 80)
    both = np.isfinite(first) & np.isfinite(second) & where(first)
    return (first[both] - second[both]) * 400.0


def excited(front, t):
    """Which states the hand can be in at time t [s] (m,)."""
    return (front.arrival <= t) & (t <= front.end)


def by_cell(front):
    """Arrivals and ends of the states of every cell, in order of time."""
    cells = {}
    for cell, came, end in zip(front.cells.tolist(), front.arrival, front.end, strict=True):
        cells.setdefault(tuple(cell), []).append((came, end))
    return cells


def beside_upper_arm(hand, along, aside):
    """The point beside the middle of the upper arm of a hand, and the direction across it."""
    elbow = elbow_position(hand)
    out = elbow / np.hypot(*elbow)
    across = np.array([-out[1], out[0]])
    return along * out + aside * across, across


def closing_specks(hand=(1.3, 0.4), least=0.03, turn=0.35, horizon=1.6):
    """Two specks close in on the upper arm from either side until t = turn and leave again."""
    bodies = []
    for side in (1.0, -1.0):
        place, across = beside_upper_arm(hand, 0.5, side * 0.3)
        pull = 2.0 * (0.3 - least) / turn**2 * side * across
        motion = PlanarQuadratic(tuple(place), tuple(-turn * pull), tuple(pull))
        bodies.append(Body("obstacle", f"speck {side}", Disc(SPECK), motion))
    return scene(*bodies, hand=hand, horizon=horizon)


def turning_speck(start, rate, hand=(1.3, 0.4)):
    """A speck `start` [rad] beside the upper arm turns towards it, and then along with it [rad/s].

    It clears away what the hand cannot flee from.
    """
    middle, (x, y) = 0.5, elbow_position(hand)
    corners = ((middle + SPECK, 0), (middle, SPECK), (middle - SPECK, 0), (middle, -SPECK))
    motion = PlanarQuadratic(STILL, STILL, STILL, float(np.arctan2(y, x)) - start, rate)
    return scene(Body("obstacle", "speck", Polygon(corners), motion), hand=hand)


# --- the lattice ------------------------------------------------------------------------------


@pytest.mark.parametrize(("points", "radius"), [(5, 0.0), (9, 0.0), (9, 4.0)])
def test_in_free_space_it_is_the_published_wave(points, radius):
    params = WaveParams(n=80, laplacian=points, start_radius=radius, until=EXPLORE)
    setting = setting_of(scene(hand=(-0.31, 0.77), horizon=1.3))
    waits, plain = propagate_layers(*setting, params), propagate(*setting, params)
    assert len(waits.cells) == np.count_nonzero(earliest(waits, 80) < np.inf) > 4000
    assert (waits.end == 1.3).all() and not waits.refused.any()
    # The same arrivals by another clock.
    clock = free_clock(params) * setting.lattice.spacing / SPEED
    tau = plain.first[tuple(waits.cells.T)] / kappa_of(*setting, params)
    assert tau.min() >= 0.0
    known = tau < TICK * (len(clock) - 1)
    expected = np.interp(tau, TICK * np.arange(len(clock)), clock)
    assert np.abs(waits.arrival - expected)[known].max() < 1e-3 * kappa_of(*setting, params)


@pytest.mark.parametrize("radius", [0.0, 3.0])
def test_the_start_of_the_wave_is_not_charged_to_the_hand(radius):
    """The published wave is late by some 26 tau (4 cells) at 38 cells; this one by half a cell."""
    params = WaveParams(n=80, laplacian=9, start_radius=radius, until=EXPLORE)
    setting = setting_of(scene(hand=(0.025, 0.025), horizon=1.3))
    first = earliest(propagate_layers(*setting, params), 80)
    late = first * SPEED / setting.lattice.spacing - away(setting)
    ring = away(setting) < 39.0
    assert -0.6 < late[ring].min() and late[ring].max() < 0.7
    plain = propagate(*setting, params).first * SPEED / setting.lattice.spacing - away(setting)
    assert plain[ring & (away(setting) > 10.0)].min() > 2.0


def compare(setting, params, median=0.1, most=1.3):
    """Hold the kernel against the reference, within some tau; returns the kernel's front."""
    fast, plain = (
        propagate_layers(*setting, params),
        propagate_reference(*setting, params, wait=True),
    )
    ours, theirs = by_cell(fast), by_cell(plain)
    # States that are grazed for an instant, and spans of freedom shorter than from look to look.
    odd = sum(len(ours.get(c, [])) != len(theirs.get(c, [])) for c in ours.keys() | theirs.keys())
    assert odd <= 0.02 * len(plain.cells)
    same = [
        pair
        for cell in ours.keys() & theirs.keys()
        if len(ours[cell]) == len(theirs[cell])
        for pair in zip(ours[cell], theirs[cell], strict=True)
    ]
    came, end = (np.abs(np.diff(same, axis=1)[:, 0] / kappa_of(*setting, params))).T
    assert np.median(came) < median and np.quantile(came, 0.97) < most
    if params.until == EXPLORE:  # else the reference does not look ahead
        assert np.quantile(end, 0.97) < 0.7
    assert fast.met_body == plain.met_body
    assert abs(fast.met_time - plain.met_time) / kappa_of(*setting, params) < max(most, 1.5)
    assert np.count_nonzero(fast.refused != plain.refused) <= 6
    return fast


VARIANTS = [
    WaveParams(n=32, until=EXPLORE),
    WaveParams(n=32, until=EXPLORE, laplacian=9),
    WaveParams(n=32, laplacian=9, start_radius=3.0, margin=0.0),
    WaveParams(n=32, until=EXPLORE, frozen="held", start="printed"),
    WaveParams(n=32, until=EXPLORE, step=0.4, threshold=1.5),
]


@pytest.mark.parametrize(("number", "k"), [(0, 3), (1, 6), (2, 3), (3, 6), (4, 3)])
def test_against_the_plain_version(number, k):
    params = VARIANTS[number]
    front = compare(setting_of(three_discs(seeding.rng(21, k)), params.n), params)
    assert len(front.cells) > 200 and front.refused.sum() > 10


def test_against_the_plain_version_where_joints_are_slow():
    situation = three_discs(seeding.rng(21, 3), max_joint_speed=(4.0, 5.0), horizon=1.3)
    limited = compare(setting_of(situation, 24), WaveParams(n=24, laplacian=9, until=EXPLORE))
    free = three_discs(seeding.rng(21, 3), horizon=1.3)
    unlimited = propagate_layers(
        *setting_of(free, 24), WaveParams(n=24, laplacian=9, until=EXPLORE)
    )
    late = lateness(limited, unlimited, np.isfinite)
    assert late.size > 100 and np.median(late) > 8.0


@pytest.mark.slow
@pytest.mark.parametrize("k", range(10, 20))
def test_against_the_plain_version_in_random_situations(k):
    """Where a front slips through a gap, a look more or less decides about a cell's crossing."""
    situation = random_planar(seeding.rng(25, k), (3, 6))
    params = VARIANTS[k % len(VARIANTS)]
    compare(setting_of(situation, params.n), params, median=2.0, most=7.0)


# --- what states say --------------------------------------------------------------------------


@pytest.mark.parametrize("k", range(8))
def test_states_are_free_for_as_long_as_they_say_and_follow_from_each_other(k):
    situation = random_planar(seeding.rng(63, k), (3, 6))
    params = WaveParams(n=48, laplacian=9, margin=0.0, until=EXPLORE)
    setting = setting_of(situation, 48)
    front = propagate_layers(*setting, params)
    instants = np.linspace(0.0, situation.horizon, 241)
    blocked = np.array([occupied_cells(situation, setting.lattice, t) for t in instants])
    look = 1.2 * kappa_of(*setting, params)
    grazed = 0
    states = zip(front.cells[1:], front.arrival[1:], front.end[1:], strict=True)
    for (iy, ix), came, end in states:  # all but the hand's own
        grazed += blocked[(instants >= came) & (instants <= end - 0.2 * look), iy, ix].any()
        if end < situation.horizon - instants[1]:  # something comes then
            around = [
                occupied_cells(situation, setting.lattice, end + t)[iy, ix] for t in (0, 1e-3)
            ]
            assert any(around) or blocked[(instants > end) & (instants < end + 0.02), iy, ix].any()
    assert grazed <= 2e-3 * len(front.cells)
    assert front.via[0] == -1 and (front.via[1:] >= 0).all()
    assert (front.via < np.arange(len(front.via))).all()
    assert (np.diff(front.arrival) >= 0.0).all()
    steps = np.abs(front.cells[1:] - front.cells[front.via[1:]])
    assert steps.max(initial=1) == 1 and (steps.sum(axis=1) > 0).all()
    assert (front.arrival[1:] <= front.end[front.via[1:]] + look).all()


def test_no_two_states_share_an_interval():
    several = 0
    for k in range(8):
        setting = setting_of(random_planar(seeding.rng(64, k), (3, 6)), 48)
        front = propagate_layers(*setting, WaveParams(n=48, laplacian=9, until=EXPLORE))
        for spans in by_cell(front).values():
            assert all(a[1] < b[0] for a, b in itertools.pairwise(spans))
            several += len(spans) > 1
    assert several > 20


def test_a_target_that_comes_in_behind_the_front_is_met():
    """When it first covers any excited cell, whenever the front was there (erratum 16)."""
    ball = disc("target", "ball", (0.3, -6.8), velocity=(0.1, 4.0), radius=0.05)
    screen = disc("obstacle", "screen", (1.0, -0.8), velocity=(-0.3, 0.0))
    setting = setting_of(scene(ball, screen, grasp=0.05, horizon=1.5))
    assert propagate(*setting, NINE).met_state == -1
    front = propagate_layers(*setting, NINE)
    place = setting.lattice.centres[front.cells[:, ::-1]]
    reach = max(0.05, 0.71 * setting.lattice.spacing)
    for t in np.linspace(0.0, 1.5, 3001):
        near = np.hypot(*(place - (0.3 + 0.1 * t, -6.8 + 4.0 * t)).T) <= 0.05 + reach
        if (near & excited(front, t)).any():
            break
    assert 1.1 < t < 1.4
    assert front.met_body == 0 and front.met_time == pytest.approx(t, abs=1e-3)
    assert front.arrival[front.met_state] < front.met_time - 0.1  # long after the front
    stopped = propagate_layers(*setting, WaveParams(n=80, laplacian=9))
    assert stopped.met_time == front.met_time and len(stopped.cells) < len(front.cells)


# --- what flows back --------------------------------------------------------------------------


def test_the_excited_region_shrinks_to_a_pocket_and_flows_back():
    """Where the hand can be: a wedge that closes to a handful of cells and opens again."""
    setting = setting_of(closing_specks())
    wave, marched = propagate_layers(*setting, NINE), march_layers(*setting, MARCH)
    for t, few, many in ((0.1, 20, 200), (0.35, 1, 20), (0.5, 40, 120), (1.5, 3800, 5000)):
        ours, theirs = (np.count_nonzero(excited(front, t)) for front in (wave, marched))
        assert few <= ours <= many and few <= theirs <= many
    # The region that came back grows like the one of marching, along with the walls and after.
    # From a few cells it starts as slowly as from the hand's neuron: by some 26 tau (erratum 9).
    late = lateness(wave, marched, lambda first: first > 0.6)
    assert 10.0 < np.median(late) < 45.0 and np.quantile(late, 0.95) < 100.0


def test_a_front_that_returns_is_as_fast_as_the_first():
    """A speck sweeps a wedge of the excited region in no time, and it is filled again behind it."""
    hand = (1.3, 0.4)
    place, across = beside_upper_arm(hand, 0.5, -8.0)
    motion = PlanarQuadratic(tuple(place), tuple(20.0 * across), STILL)
    sweep = Body("obstacle", "sweep", Disc(0.1), motion)
    setting = setting_of(scene(sweep, hand=hand, horizon=1.6))
    wave, marched = propagate_layers(*setting, NINE), march_layers(*setting, MARCH)
    again = [
        {cell: spans[1][0] for cell, spans in by_cell(front).items() if len(spans) == 2}
        for front in (wave, marched)
    ]
    cells = sorted(again[0].keys() & again[1].keys())
    assert len(cells) > 300
    ours, theirs = (np.array([later[c] for c in cells]) * 400.0 for later in again)
    assert np.quantile(np.abs(ours - theirs), 0.9) < 20.0


@pytest.mark.parametrize(("start", "rate"), [(0.06, 0.8), (0.05, 0.4)])
def test_excitation_survives_in_a_single_cell(start, rate):
    """The hand's neuron is inhibited before there is a wave; the hand itself has stepped aside."""
    setting = setting_of(turning_speck(start, rate))
    wave, marched = propagate_layers(*setting, NINE), march_layers(*setting, MARCH)
    assert wave.end[0] < 0.03 and np.count_nonzero(excited(wave, 0.05)) < 25
    ours, theirs = (np.count_nonzero(excited(front, 0.9)) for front in (wave, marched))
    assert 0.5 * theirs < ours < 1.05 * theirs


@pytest.mark.parametrize("place", [None, (0.2, 1.2), (1.4, -0.5)])
def test_among_things_at_rest_it_agrees_with_marching(place):
    walls = [] if place is None else [disc("obstacle", "wall", place)]
    setting = setting_of(scene(*walls, horizon=3.0))
    wave, marched = propagate_layers(*setting, NINE), march_layers(*setting, MARCH)
    assert len(wave.cells) == np.isfinite(earliest(wave, 80)).sum() > 4000  # one sheet
    # A curved front is slow (behind obstacles), a flat or concave one fast (along the rim).
    late = lateness(wave, marched, lambda _: away(setting) < 45.0)
    assert abs(np.median(late)) < 8.0
    assert np.quantile(late, 0.05) > -20.0 and np.quantile(late, 0.95) < 10.0


def test_held_and_insulating_inhibition_agree_in_wide_spaces():
    setting = setting_of(three_discs(seeding.rng(21, 6)), 80)
    held = propagate_layers(*setting, WaveParams(n=80, laplacian=9, until=EXPLORE, frozen="held"))
    insulating = propagate_layers(*setting, NINE)
    late = lateness(held, insulating, np.isfinite)
    assert late.size > 0.9 * np.isfinite(earliest(insulating, 80)).sum()
    assert late.min() > -1.0 and 0.5 < np.median(late) < 8.0  # cells held at rest draw from it


def test_a_hand_that_is_fast_beyond_measure_waits_for_what_is_slow():
    """Hundreds of thousands of tau pass until a wall has gone; nothing is stepped meanwhile."""
    place, across = beside_upper_arm((1.2, 0.3), 0.5, 0.3)
    slow = Body("obstacle", "slow", Disc(0.05), PlanarQuadratic(tuple(place), STILL, tuple(across)))
    setting = setting_of(scene(slow, horizon=1.0))
    front = propagate_layers(*setting.limited(speed=2e5 * SPEED), NINE)
    again = [spans[1] for spans in by_cell(front).values() if len(spans) > 1]
    assert len(again) > 100
    assert len(by_cell(front)) > 3500


# --- the same again ---------------------------------------------------------------------------


@SYMMETRIES
def test_symmetry(move, back):
    """The lattice is symmetric, so a moved scene has the moved states."""
    params = WaveParams(n=40, laplacian=9, until=EXPLORE)
    several = 0
    for k in range(4):
        situation = three_discs(seeding.rng(44, k), hand=(1.23, 0.31))
        sheets = []
        for s in (situation, move(situation)):
            picture = np.full((3, 40, 40), np.nan)
            for (iy, ix), spans in by_cell(propagate_layers(*setting_of(s, 40), params)).items():
                for sheet, (came, _) in enumerate(spans[:3]):
                    picture[sheet, iy, ix] = came * 400.0
            sheets.append(picture)
        here, there = sheets[0], back(sheets[1])
        assert np.count_nonzero(np.isnan(here) != np.isnan(there)) <= 2
        assert np.nanquantile(np.abs(here - there), 0.99) < 0.01
        several += np.isfinite(here[1]).sum()
    assert several > 40


def test_same_bytes_again_and_in_threads():
    params = WaveParams(n=40, laplacian=9, until=EXPLORE)
    settings = [setting_of(three_discs(seeding.rng(45, k)), 40) for k in range(6)]

    def work():
        fronts = [propagate_layers(*s, params) for s in settings]
        return [front.arrival.tobytes() + front.via.tobytes() for front in fronts]

    assert in_threads(work, work) == [work()] * 2


def test_the_front_speed_is_measured_once_whatever_the_lattice():
    assert front_speed(WaveParams(n=160, margin=0.0)) is front_speed(WaveParams(slack=0.7))
