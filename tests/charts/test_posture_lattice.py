"""Cells and postures of an arm in space: a rule that starts where the arm is, and how it jumps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn.arms import forward_in_space, inverse_in_space
from gcm_learn.arms.spatial_limb import limb_at, spatial_limb_of
from gcm_learn.charts import PostureLattice, posture_lattice_of
from gcm_learn.charts.posture_lattice import NOWHERE, hand_of_node, ring_leap
from gcm_learn.charts.postures import posture_of, rule_of
from gcm_learn.scene import pack
from gcm_learn.situation import read_situations
from tests.charts.steps import steps_of
from tests.spatial import EXAMPLES

SITUATIONS = read_situations(EXAMPLES)
ARMS = [SITUATIONS[k].arm for k in (0, 1, 2, 15, 16)]
N = 20


def hands_of(arm, count, seed=0):
    """Draw hands from all over the ranges of the joints, in the frame of the base."""
    limb = spatial_limb_of(arm)
    joints = limb.low + np.random.default_rng(seed).random((count, 4)) * (limb.high - limb.low)
    return np.array([limb_at(limb, q)[3:] for q in joints])


@pytest.mark.parametrize("arm", ARMS)
def test_the_first_posture_of_the_hand_at_the_start_is_the_arms_own(arm):
    limb, q = spatial_limb_of(arm), np.empty(4)
    for postures in (1, 4):
        rule = rule_of(limb, postures)
        assert posture_of(rule, 0, *limb_at(limb, limb.start)[3:], q)
        np.testing.assert_allclose(q, arm.joints, atol=1e-9)


@pytest.mark.parametrize("arm", ARMS)
@pytest.mark.parametrize("straight", [0.0, -1e-9])
def test_a_straight_arm_has_a_rule_as_well(arm, straight):
    ranges = (*arm.joint_range[:3], (-2.0, 2.0))
    stretched = replace(arm, forearm=(1.0, 0.0, 0.0), upper_arm=(1.0, 0.0, 0.0),
                        joints=(*arm.joints[:3], straight), joint_range=ranges)  # fmt: skip
    space = PostureLattice(stretched, N)
    cells, times = space.start(pack(replace(SITUATIONS[0], arm=stretched)))
    assert len(cells) > 0 and (times < 1.0).all()


@pytest.mark.parametrize("arm", ARMS)
@pytest.mark.parametrize("postures", [1, 4])
def test_postures_hold_the_hand_within_the_ranges_of_the_joints(arm, postures):
    limb, q = spatial_limb_of(arm), np.empty(4)
    rule, found = rule_of(limb, postures), 0
    for hand in hands_of(arm, 200):
        for k in range(postures):
            if posture_of(rule, k, *hand, q):
                found += 1
                assert (limb.low <= q).all() and (q <= limb.high).all()
                np.testing.assert_allclose(limb_at(limb, q)[3:], hand, atol=1e-9)
    assert found > 150


@pytest.mark.parametrize("arm", ARMS)
def test_hands_that_the_arm_can_hold_have_a_posture(arm):
    """As the inverse finds them, at many swivels; narrow ranges of swivels may be missed."""
    limb, q = spatial_limb_of(arm), np.empty(4)
    rule = rule_of(limb)
    held = [posture_of(rule, 0, *hand, q) for hand in hands_of(arm, 300, 1)]
    assert np.mean(held) > 0.96
    for hand in np.random.default_rng(2).uniform(-1.0, 1.0, (60, 3)) * (limb.rho + limb.length):
        if not posture_of(rule, 0, *hand, q):
            world = PostureLattice(arm, 16).in_world(hand)
            solved = [len(inverse_in_space(arm, world, s)) for s in np.arange(24) * np.pi / 12]
            assert np.count_nonzero(solved) <= 2


@pytest.mark.parametrize("arm", ARMS)
def test_joints_change_little_but_where_they_jump(arm):
    """Hands nearer together have joints nearer together, or there is a jump between them."""
    limb, rule = spatial_limb_of(arm), rule_of(spatial_limb_of(arm))
    far = limb.rho + limb.length
    rng, q, p = np.random.default_rng(3), np.empty(4), np.empty(4)
    steps = {}
    for hand in hands_of(arm, 250, 4):
        way = rng.normal(size=3)
        way *= far / np.linalg.norm(way)
        for size in (1e-2, 1e-5):
            if posture_of(rule, 0, *hand, q) and posture_of(rule, 0, *(hand + size * way), p):
                steps.setdefault(size, []).append(np.abs(p - q).max())
    jumps = np.mean(np.array(steps[1e-5]) > 0.02)
    assert jumps < 0.01  # a jump is met by a short step as rarely as it is short
    assert np.median(steps[1e-5]) < 3e-3 * np.median(steps[1e-2])
    assert np.quantile(steps[1e-2], 0.8) < 0.2


@pytest.mark.parametrize("arm", ARMS)
def test_steps_are_short_and_most_cells_are_a_few_of_them_from_the_start(arm):
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import connected_components

    space = PostureLattice(arm, N)
    scene = pack(replace(SITUATIONS[0], arm=arm))
    steps, (start, _) = steps_of(space, scene), space.start(scene)
    joints, inside = space.joints, space.inside
    begin = np.repeat(np.arange(space.size), np.diff(steps.first))
    turn = np.abs(joints[steps.to] - joints[begin])
    assert turn.max() <= space.nodes.leap < 1.3
    wanted = np.maximum(
        (turn / scene.limits.joint_speed).max(axis=1),
        np.linalg.norm(space.hands[steps.to] - space.hands[begin], axis=1) / scene.limits.speed,
    )
    np.testing.assert_allclose(steps.time, wanted, rtol=1e-5)
    graph = csr_array((np.ones(len(begin)), (begin, steps.to)), shape=(space.size,) * 2)
    _, part = connected_components(graph, directed=False)
    own_branch = np.cos(arm.joints[1]) > 0.0  # beyond, few hands are on the same branch
    reached = np.mean(part[inside] == part[start[0]])
    assert reached > 0.9 if own_branch else reached > 0.15


@pytest.mark.parametrize("postures", [1, 4])
def test_nodes_are_cells_and_their_postures(postures):
    space = PostureLattice(ARMS[3], 16, postures)
    assert space.shape == ((16, 16, 16) if postures == 1 else (16, 16, 16, 4))
    inside = space.inside
    node = int(np.flatnonzero(inside)[50])
    hand = limb_at(space.limb, space.joints[node].astype(float))[3:]
    np.testing.assert_allclose(hand, space.hands[node], atol=1e-6)
    np.testing.assert_allclose(space.hands[node], hand_of_node(space.nodes, node))
    np.testing.assert_allclose(space.joints_at([node])[0], space.joints[node], atol=1e-6)
    assert space.joints_at([0])[0, 0] == space.joints[0, 0] == NOWHERE and not inside[0]


def test_postures_in_a_cell_are_a_ring():
    space = PostureLattice(ARMS[0], 16, 4)
    steps, joints = steps_of(space, pack(SITUATIONS[0])), space.joints
    cell = np.arange(space.size) // 4
    begin = np.repeat(np.arange(space.size), np.diff(steps.first))
    ring = cell[begin] == cell[steps.to]
    apart = (steps.to - begin)[ring] % 4
    assert ring.sum() > 100 and set(apart.tolist()) == {1, 3}
    assert np.abs(joints[steps.to] - joints[begin])[ring].max() <= ring_leap(4)
    assert (((steps.to - begin) % 4)[~ring] == 0).all()


def test_frames():
    arm = ARMS[3]
    space = PostureLattice(arm, 16)
    hand = np.array(limb_at(space.limb, space.limb.start)[3:])
    np.testing.assert_allclose(space.in_world(hand), forward_in_space(arm, arm.joints)[1])
    np.testing.assert_allclose(space.in_base(space.in_world(hand)), hand)
    assert posture_lattice_of(arm, 16) is posture_lattice_of(arm, 16)
