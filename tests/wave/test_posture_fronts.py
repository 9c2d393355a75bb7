"""The wave in space: against its slow reference, and what a wave in space has to be like."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn.arms import SpatialArm
from gcm_learn.charts import PostureLattice
from gcm_learn.collision.postures import desk_of, distance_at
from gcm_learn.errors import LatticeError
from gcm_learn.scene import pack
from gcm_learn.situation import Body, Situation, SolidQuadratic, Sphere
from gcm_learn.wave import WaveParams, posture_solver
from gcm_learn.wave.posture_solver import (
    front_speed_in_space,
    kappa_in_space,
    propagate_in_space,
    quickest,
)
from tests.wave.posture_reference import Reference

ARM = SpatialArm(
    upper_arm=(1.0, 0.0, 0.0),
    forearm=(1.0, 0.0, 0.0),
    joints=(0.3, 0.4, -0.5, -1.4),
    joint_range=((-2.5, 2.5), (-1.5, 1.5), (-2.5, 2.5), (-2.6, 0.0)),
    max_joint_speed=(5.0, 5.0, 7.0, 7.0),
    grasp=0.05,
    thickness=0.04,
    max_hand_speed=3.0,
)
EXPLORE = WaveParams(until="horizon")


def ball(name, place, velocity=(0.0, 0.0, 0.0), radius=0.2, role="obstacle"):
    motion = SolidQuadratic(place, velocity, (0.0, 0.0, 0.0))
    return Body(role, name, Sphere(radius), motion)


FAR = ball("far", (50.0, 0.0, 0.0), role="target")


def setting(n, *bodies, arm=ARM, horizon=1.0):
    scene = pack(Situation("test", horizon, arm, (FAR, *bodies)))
    return scene, PostureLattice(arm, n)


def test_it_does_what_the_slow_reference_does():
    scene, lattice = setting(
        20,
        ball("left", (0.6, 0.9, 0.2), (0.3, -0.6, 0.0), 0.25),
        ball("right", (1.0, -0.6, -0.3), (0.0, 0.5, 0.2), 0.2),
        ball("prize", (0.5, 0.4, -0.6), (0.0, 0.0, -0.3), 0.15, "target"),
        horizon=1.2,
    )
    slow = Reference(scene, lattice, EXPLORE).run()
    front = propagate_in_space(scene, lattice, EXPLORE)
    tau = front.first / kappa_in_space(scene, lattice, EXPLORE)
    both = (tau >= 0.0) & (slow.arrival >= 0.0)
    assert both.sum() > 1000
    assert ((tau >= 0.0) != (slow.arrival >= 0.0)).sum() <= 0.02 * both.sum()
    # at the sharp edge of the ball cells are up and down again within a look, which is 1.2 tau long
    off = np.abs(tau - slow.arrival)[both]
    assert np.median(off) < 0.1 and np.quantile(off, 0.95) < 2.4
    refused = slow.state == 1
    assert refused.sum() > 20
    assert (front.refused != refused).sum() <= 0.05 * refused.sum()
    assert (front.met != (slow.state == 2)).sum() <= 2 and front.met.sum() > 0
    assert front.met_body == slow.contact[2] == 3
    assert front.met_time == pytest.approx(slow.contact[0], abs=0.01)


def centred(n, cell):
    """A hand that is slower than its joints, which are free to turn, at the centre of a cell."""
    wide = ((-6.0, 6.0), (-3.0, 3.0), (-6.0, 6.0), (-3.0, 0.0))
    arm = replace(ARM, joint_range=wide, max_hand_speed=0.02)
    joints = PostureLattice(arm, n).joints_at(np.array([np.ravel_multi_index(cell, (n,) * 3)]))[0]
    return replace(arm, joints=tuple(joints.tolist()))


@pytest.fixture(scope="module")
def free():
    """A free front over 40 cells to a side, and the hand's cell."""
    cell = (24, 22, 28)
    scene, lattice = setting(40, arm=centred(40, cell), horizon=125.0)
    lattice.__dict__["nodes"] = lattice.nodes._replace(leap=100.0)  # jumps of the rule are steps
    return propagate_in_space(scene, lattice, EXPLORE), cell, scene


def test_a_free_front_looks_the_same_after_a_quarter_turn(free):
    front, (z, y, x), _ = free
    around = front.first[z - 7 : z + 8, y - 7 : y + 8, x - 7 : x + 8]
    grid = np.stack(np.meshgrid(*(np.arange(-7, 8),) * 3))
    around = np.where(np.linalg.norm(grid, axis=0) < 7.0, around, 0.0)
    assert (around >= 0.0).all() and (around > 0.0).sum() > 1000
    for axes in ((0, 1), (0, 2), (1, 2)):
        np.testing.assert_allclose(np.rot90(around, axes=axes), around, rtol=1e-3)
    np.testing.assert_allclose(around[::-1], around, rtol=1e-3)


def test_arrivals_grow_on_the_way_from_the_hand(free):
    front, cell, _ = free
    home = int(np.ravel_multi_index(cell, front.chart.shape))
    reached = np.flatnonzero((front.arrival >= 0.0) & ~front.refused.ravel())
    others = reached[reached != home]
    assert front.via[home] == -1 and front.arrival[home] == 0.0
    assert (front.via[others] >= 0).all()
    assert (front.arrival[front.via[others]] < front.arrival[others]).all()
    apart = np.abs(front.chart.hands[front.via[others]] - front.chart.hands[others])
    assert apart.max() < 1.01 * front.chart.spacing


def test_the_front_does_not_outrun_the_hand(free):
    front, cell, scene = free
    hand = front.chart.hands[np.ravel_multi_index(cell, front.chart.shape)]
    away = np.linalg.norm(front.chart.hands - hand, axis=1)
    reached = (front.arrival >= 0.0) & (away > 0.0) & (away <= 20 * front.chart.spacing)
    assert (away[reached] / front.arrival[reached]).max() <= scene.limits.speed * (1.0 + 1e-6)
    # nor is it much slower, once it is less curved
    z, y, x = cell
    along = np.diff(front.first[z, y, x - 14 : x - 9])
    assert front.chart.spacing / -along.mean() > 0.7 * scene.limits.speed


def test_plane_fronts_are_quickest_along_the_cubes_diagonal():
    speeds = [posture_solver._chain_speed(EXPLORE, k) / np.sqrt(k) for k in (1, 2, 3)]
    assert speeds == sorted(speeds)
    assert speeds[0] == pytest.approx(0.166, abs=1e-3)  # that of the plane
    assert front_speed_in_space(EXPLORE) == speeds[-1] == pytest.approx(0.1813, abs=1e-3)


@pytest.mark.parametrize("radius, spreads", [(0.1, False), (3.2, False), (4.3, True)])
def test_one_neuron_starts_no_wave_in_space(radius, spreads, monkeypatch):
    monkeypatch.setattr(posture_solver, "START_BALL", radius)
    monkeypatch.setattr(posture_solver, "FEWEST", 0)
    scene, lattice = setting(40, arm=centred(40, (24, 22, 28)), horizon=100.0)
    front = propagate_in_space(scene, lattice, EXPLORE)
    grown = np.linalg.norm(lattice.hands - lattice.hands[front.arrival.argmax()], axis=1)
    cells = (front.arrival >= 0.0).sum() / max(4.19 * radius**3, 7.0)
    assert (cells > 1.5) == spreads, (cells, grown.max())


def test_what_was_reached_was_free_then_and_what_was_refused_was_not():
    movers = [
        ball(f"ball {k}", place, velocity, 0.15)
        for k, (place, velocity) in enumerate(
            [((0.9, 0.8, 0.0), (0.0, -0.8, 0.1)), ((0.2, -0.9, 0.9), (0.5, 0.4, -0.5))]
        )
    ]
    scene, lattice = setting(32, *movers)
    front, desk = propagate_in_space(scene, lattice, replace(EXPLORE, margin=0.0)), desk_of(scene)
    reached = np.flatnonzero((front.arrival >= 0.0) & ~front.refused.ravel())
    joints = lattice.joints.astype(float)
    rooms = [distance_at(scene, joints[m], front.arrival[m], desk) for m in reached[::7]]
    assert len(rooms) > 500 and min(rooms) > scene.limb.thickness - 1e-5
    refused = np.flatnonzero(front.refused)
    assert refused.size > 10
    near = [distance_at(scene, joints[m], front.arrival[m], desk) for m in refused]
    # the obstacle was there at some instant since the front was next door
    assert np.median(near) < scene.limb.thickness + 0.02 and max(near) < 0.3


def test_it_stops_at_the_first_contact_and_passes_over_those_before_a_time():
    prize = ball("prize", (0.5, -0.6, 1.0), (0.0, 0.0, -0.4), 0.1, "target")
    scene, lattice = setting(32, prize)
    first = propagate_in_space(scene, lattice, WaveParams())
    assert first.met_body == 1 and 0.0 < first.met_time < 1.0
    hand = lattice.hands[first.met_state]
    centre = np.array([0.5, -0.6, 1.0 - 0.4 * first.met_time])
    assert np.linalg.norm(hand - centre) < 0.1 + 2.0 * lattice.spacing
    all_of_it = propagate_in_space(scene, lattice, EXPLORE)
    assert all_of_it.met_time == first.met_time and all_of_it.steps > first.steps
    later = propagate_in_space(scene, lattice, WaveParams(), ignore=first.met_time + 0.05)
    assert later.met_body < 0 or later.met_time >= first.met_time + 0.05


def test_a_wave_leaves_nothing_behind_for_the_next_one():
    scene, lattice = setting(24, ball("left", (0.6, 0.9, 0.2), (0.3, -0.6, 0.0), 0.25))
    once = propagate_in_space(scene, lattice, EXPLORE)
    propagate_in_space(*setting(20), EXPLORE)
    again = propagate_in_space(scene, PostureLattice(ARM, 24), EXPLORE)
    np.testing.assert_array_equal(once.arrival, again.arrival)
    np.testing.assert_array_equal(once.refused, again.refused)


def test_a_front_is_slow_where_joints_are():
    lame = replace(ARM, max_joint_speed=(1.0, 1.0, 1.0, 1.0), max_hand_speed=None)
    scene, lattice = setting(24, arm=lame, horizon=2.0)
    assert quickest(scene, lattice) < 2.0
    front = propagate_in_space(scene, lattice, EXPLORE)
    turn = np.abs(lattice.joints - scene.limb.start).max(axis=1)
    reached = (front.arrival > 0.0) & lattice.inside
    # a mean over directions is quicker than joints in some of them, and much slower in none
    share = front.arrival[reached] / np.maximum(turn[reached], 1e-9)
    assert 0.5 < np.quantile(share, 0.05) and np.median(share) < 6.0


def test_a_step_that_is_unstable_in_space_is_refused():
    with pytest.raises(LatticeError, match=r"step 0.7 is unstable with diffusion 0.2 on 7 points"):
        front_speed_in_space(WaveParams(step=0.7))
