"""Down the map: smooth, short, monotone, and never through what is masked."""

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import seeding
from gcm_learn.arms import Arm
from gcm_learn.charts import Lattice
from gcm_learn.families.random_planar import random_planar
from gcm_learn.maps import CognitiveMap, build_map, descend
from gcm_learn.motion import Movement
from gcm_learn.wave import MarchingParams, WaveParams
from tests.planar_geometry import by_hand, nearest
from tests.worlds import among, disc

ENGINES = {"wave": WaveParams(), "marching": MarchingParams()}


@pytest.fixture(params=ENGINES)
def engine(request):
    return request.param


def post(radius, place):
    return disc("post", place, radius=radius)


def scene(target, *obstacles, hand=(1.3, 0.6), horizon=3.0):
    goal = disc("target", target, role="target", radius=0.08)
    return among(Arm(hand, 3.4), goal, *obstacles, horizon=horizon)


def turning(points):
    """Sum of the angles between successive steps of a path (n, 2) [rad]."""
    steps = np.diff(points, axis=0)
    steps = steps[np.linalg.norm(steps, axis=1) > 1e-9]
    cross = steps[:-1, 0] * steps[1:, 1] - steps[:-1, 1] * steps[1:, 0]
    return np.abs(np.arctan2(cross, (steps[:-1] * steps[1:]).sum(axis=1))).sum()


def start_distance(situation):
    """Distance of the limb to the obstacles at t = 0."""
    path = Movement.of_hand(situation.arm, np.zeros(1), np.array([situation.arm.hand]))
    start = np.zeros(1)
    return nearest(situation, lambda t: by_hand(situation.arm, path, t), start)


def length(points):
    return np.linalg.norm(np.diff(points, axis=0), axis=1).sum()


@pytest.mark.parametrize("angle", np.linspace(-1.2, 2.0, 9))
def test_in_free_space_the_path_is_straight(engine, angle):
    """No staircase, whatever the direction on the lattice."""
    hand = np.array([1.3, 0.6])
    for away in (0.4, 0.9):
        goal = hand + away * np.array([-np.sin(angle), np.cos(angle)])
        if not 0.4 < np.hypot(*goal) < 1.9:
            continue
        found = build_map(scene(tuple(goal)), ENGINES[engine])
        points, _ = descend(found)
        straight = np.linalg.norm(points[-1] - points[0])
        # A wave starts in the centre of the hand's cell, so its path ends with a small kink.
        kink = 0.2 * found.lattice.spacing if engine == "wave" else 0.0
        assert length(points) <= 1.01 * straight + kink
        assert turning(points) < (1.0 if engine == "wave" else 0.25)
        assert turning(points[1:]) < 0.25


@pytest.mark.parametrize("seed", range(30))
def test_it_runs_from_the_hand_to_the_contact_in_order_of_arrival(engine, seed):
    situation = random_planar(seeding.rng(51, seed))
    found = build_map(situation, ENGINES[engine])
    way = descend(found)
    if found.interception is None or start_distance(situation) < 0.1:
        return
    assert way is not None
    points, arrival = way
    assert tuple(points[0]) == situation.arm.hand and arrival[0] == 0.0
    np.testing.assert_allclose(points[-1], found.interception.position, atol=1e-9)
    assert (np.diff(arrival) > 0.0).all()
    assert arrival[-1] <= found.interception.time + 1e-6 or arrival[-1] <= situation.horizon
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1) / found.lattice.spacing
    assert steps.max() < 2.2  # cells; the first step is the one straight from the hand


@pytest.mark.parametrize("seed", range(30))
def test_it_stays_on_what_the_front_reached(engine, seed):
    situation = random_planar(seeding.rng(52, seed), (2, 5))
    found = build_map(situation, ENGINES[engine])
    way = descend(found)
    if way is None:
        return
    h, reach = found.lattice.spacing, found.lattice.upper_arm + 1.0
    for x, y in (way[0][1:] + reach) / h - 0.5:
        i, j = int(np.floor(y)), int(np.floor(x))
        around = found.arrival.mask[max(i, 0) : i + 2, max(j, 0) : j + 2]
        assert not around.all()


def test_it_goes_round_an_obstacle(engine):
    """A disc right on the straight way: the arm has to be drawn in."""
    target, hand = (1.5, -1.0), (1.5, 1.0)
    stone = post(0.2, (1.5, 0.0))
    free = descend(build_map(scene(target, hand=hand), ENGINES[engine]))[0]
    around = descend(build_map(scene(target, stone, hand=hand), ENGINES[engine]))[0]
    assert np.abs(free[:, 0] - 1.5).max() < 0.08
    assert around[:, 0].min() < 1.3 and 1.01 < length(around) / length(free) < 1.2


def test_without_contact_there_is_no_way(engine):
    assert descend(build_map(scene((-1.5, 0.5), horizon=0.1), ENGINES[engine])) is None


def flat_map(arrival, hand=(0.0, 0.0)):
    """Return a map of given arrivals, by hand."""
    n = arrival.shape[0]
    nothing = np.zeros((n, n), dtype=bool)
    masked = np.ma.MaskedArray(arrival, mask=arrival < 0.0)
    return CognitiveMap(Lattice(n), hand, masked, nothing, nothing, None, 0.0025, "marching")


def radial(n=40, hand=(0.05, 0.05)):
    centres = Lattice(n).centres
    x, y = np.meshgrid(centres, centres)
    return np.hypot(x - hand[0], y - hand[1])


def test_any_reached_point_can_be_the_start():
    found = flat_map(radial(), (0.05, 0.05))
    for start in ((1.2, 0.7), (-0.9, 0.33), (-1.0, -1.3)):
        points, arrival = descend(found, start)
        np.testing.assert_allclose(points[-1], start, atol=1e-9)
        assert length(points) <= 1.002 * np.hypot(start[0] - 0.05, start[1] - 0.05)
        assert arrival[-1] == pytest.approx(np.hypot(start[0] - 0.05, start[1] - 0.05), rel=0.02)


def test_a_start_beyond_the_front_has_no_way():
    arrival = radial()
    arrival[arrival > 1.0] = -1.0
    assert descend(flat_map(arrival), (1.5, 0.0)) is None


def test_a_local_minimum_is_no_way():
    """Arrivals that fall towards somewhere else than the hand: stuck, not looping."""
    assert descend(flat_map(radial(hand=(1.0, 1.0)), (0.05, 0.05)), (0.6, 0.9)) is None


def test_it_bends_round_masked_cells():
    """A slot in a wall of masked cells: arrivals come through it."""
    n, hand = 40, (-1.05, 0.05)
    centres = Lattice(n).centres
    x, y = np.meshgrid(centres, centres)
    gate = np.array([0.05, 0.95])
    before = np.hypot(x - hand[0], y - hand[1])
    after = np.hypot(*(gate - hand)) + np.hypot(x - gate[0], y - gate[1])
    arrival = np.where(x < 0.0, before, after)
    wall = (np.abs(x) < 0.1) & (np.abs(y - 0.95) > 0.1)
    arrival[wall] = -1.0
    points, _ = descend(flat_map(arrival, hand), (1.05, 0.05))
    through = points[np.abs(points[:, 0]).argmin()]
    assert through[1] == pytest.approx(0.95, abs=0.2)
    best = np.hypot(*(gate - hand)) + np.hypot(*(gate - (1.05, 0.05)))
    assert length(points) <= 1.05 * best


def test_waves_and_marching_agree_on_the_way():
    stone = post(0.1, (1.55, 0.1))
    ways = [
        descend(build_map(scene((1.0, -1.1), stone, hand=(1.0, 1.2)), params))[0]
        for params in ENGINES.values()
    ]
    assert length(ways[0]) == pytest.approx(length(ways[1]), rel=0.03)
    middle = [way[np.abs(way[:, 1]).argmin()] for way in ways]
    np.testing.assert_allclose(middle[0], middle[1], atol=0.12)


def test_the_lattice_hardly_matters():
    stone = post(0.1, (1.55, 0.1))
    situation = scene((1.0, -1.1), stone, hand=(1.0, 1.2))
    lengths = [
        length(descend(build_map(situation, replace(MarchingParams(), n=n)))[0])
        for n in (60, 80, 120)
    ]
    assert np.ptp(lengths) < 0.12
