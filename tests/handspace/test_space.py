"""The lattice over hand-space in space: its cells, and the one posture that each of them has."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn.errors import LatticeError
from gcm_learn.handspace import Chart, SpaceLattice
from gcm_learn.handspace.space import NOWHERE, posture_for, rule_of
from gcm_learn.scene import forward_in_space, pack
from gcm_learn.scene.spatial_limb import limb_at, spatial_limb
from gcm_learn.situation import Base, read_situations
from tests.spatial import EXAMPLES

SITUATIONS = read_situations(EXAMPLES)[:12]
ARMS = [replace(s.arm, base=Base()) for s in SITUATIONS]


@pytest.fixture(scope="module", params=(0, 4))
def lattice(request):
    return SpaceLattice(ARMS[request.param], 16)


@pytest.mark.parametrize("arm", ARMS, ids=lambda arm: f"{arm.reach:.2f}")
def test_the_rule_gives_the_arms_own_joints_where_it_is(arm):
    limb, q = spatial_limb(arm), np.empty(4)
    assert posture_for(rule_of(limb), *limb_at(limb, limb.start)[3:], q)
    np.testing.assert_allclose(q, arm.joints, atol=1e-7)


@pytest.mark.parametrize("arm", ARMS[:6], ids=lambda arm: f"{arm.reach:.2f}")
def test_near_the_start_the_rule_is_continuous(arm):
    limb, way = spatial_limb(arm), 1e-5 * arm.reach
    rule, hand, q = rule_of(limb), np.array(limb_at(limb, limb.start)[3:]), np.empty(4)
    low, high = np.array(arm.joint_range).T
    if (np.minimum(limb.start - low, high - limb.start) < 0.01).any():
        pytest.skip("the swivel of the start is at the end of a range")
    for step in np.vstack([np.eye(3), -np.eye(3)]):
        assert posture_for(rule, *(hand + way * step), q)
        assert np.abs(q - limb.start).max() < 0.01


def test_joints_put_the_hand_in_its_cell_and_keep_their_ranges(lattice):
    low, high = np.array(lattice.arm.joint_range).T
    inside, joints = lattice.inside, lattice.joints
    assert 0.1 < inside.mean() < np.pi / 6
    assert (joints[inside] >= low).all() and (joints[inside] <= high).all()
    elbow, hand = forward_in_space(lattice.arm, joints[inside])
    np.testing.assert_allclose(hand, lattice.hands[inside], atol=1e-6 * lattice.arm.reach)
    np.testing.assert_allclose(lattice.limbs[inside, 1], elbow, atol=1e-9)
    np.testing.assert_allclose(lattice.limbs[:, 2], lattice.hands)


def test_some_cells_are_asked_as_all_of_them_are(lattice):
    some = np.flatnonzero(lattice.inside)[::97]
    np.testing.assert_array_equal(lattice.joints_at(some), lattice.joints[some])
    beyond = np.array([0])
    assert lattice.joints_at(beyond)[0, 0] == NOWHERE


def test_cells_are_found_again(lattice):
    for node in (0, 5, 16, 16 * 16, 2345):
        index = np.unravel_index(node, lattice.shape)
        assert lattice.cell_of(lattice.hands[node]) == tuple(int(i) for i in index)


def test_it_is_a_chart_whose_steps_take_as_long_as_joints_and_hand_need(lattice):
    assert isinstance(lattice, Chart)
    scene = pack(replace(SITUATIONS[0], arm=replace(lattice.arm, max_hand_speed=1.5)))
    steps = lattice.steps(scene.limits)
    home = np.repeat(np.arange(steps.first.size - 1), np.diff(steps.first))
    apart = np.linalg.norm(lattice.hands[home] - lattice.hands[steps.to], axis=1)
    np.testing.assert_allclose(apart, lattice.spacing)
    turn = np.abs(lattice.joints[home] - lattice.joints[steps.to]) / scene.limits.joint_speed
    np.testing.assert_allclose(steps.time, np.maximum(turn.max(axis=1), lattice.spacing / 1.5))
    near, far = np.sort(lattice.start(scene)[1])[[0, -1]]
    assert 0.0 <= near < far
    bound = lattice.lower_bound(lattice.hands[home[0]], 0.0, scene.limits)
    assert bound[home[0]] == 0.0 and (bound[steps.to] <= bound[home] + steps.time + 1e-12).all()


def test_the_limb_moves_no_less_than_the_hand(lattice):
    assert (lattice.strides >= 0.5 * lattice.spacing).all()


def test_sizes_out_of_range_are_refused():
    with pytest.raises(LatticeError, match="81 is outside"):
        SpaceLattice(ARMS[0], 81)
