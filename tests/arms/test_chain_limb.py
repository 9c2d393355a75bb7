"""Kinematics of chains and trees against the referee and MuJoCo; bounds against samples."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, strategies as st

from gcm_learn.arms import Chain, hands_along, limb_of_chain, limbs, links_along
from gcm_learn.arms.chain_limb import travel
from gcm_learn.arms.curves import hermite, on_curve
from gcm_learn.motion.joint_verification import hand_too_fast
from gcm_learn.situation import FORMATS
from gcm_learn.situation.arm_files import arm_members
from tests import strategies
from tests.geometry import arm_of, hand_of, links_of

SEEDS = st.integers(0, 2**32 - 1)
HAIR = 1e-9
TREES = pytest.param(strategies.chains(trees=True), marks=pytest.mark.slow)
EACH = pytest.mark.parametrize("arms", [strategies.chains(), TREES], ids=["chains", "trees"])
"""Trees compile all of it once more."""


def judged(arm):
    """An arm as the referee reads it."""
    return arm_of(arm_members(arm, FORMATS["gcm-learn/situation@3"]))


def postures(arm, seed, count):
    """Random postures (count, n) within the ranges."""
    low, high = np.array(arm.joint_range).T
    return np.random.default_rng(seed).uniform(low, high, (count, arm.dof))


def moved(arm, seed):
    """A cubic move (n, 4) that stays within the ranges: rates at its ends of at most 3 slopes."""
    rng, (q, p) = np.random.default_rng(seed), postures(arm, seed, 2)
    curve = np.zeros((arm.dof, 4))
    first, last = rng.uniform(0.0, 3.0, (2, arm.dof)) * (p - q)
    hermite(q, first, p, last, 1.0, curve)
    return curve


def along(curve, shares):
    """Joints (k, n) at shares (k,) of a move."""
    joints = np.zeros((len(shares), len(curve)))
    for row, share in zip(joints, shares, strict=True):
        on_curve(curve, share, row)
    return joints


@EACH
@given(st.data(), SEEDS)
def test_links_and_hands_are_the_referees(arms, data, seed):
    arm = data.draw(arms)
    joints, other = postures(arm, seed, 5), judged(arm)
    (ends, radii), (hands, axes) = links_along(arm, joints), hands_along(arm, joints)
    links, thick = links_of(other, joints)
    assert ends == pytest.approx(np.transpose(links, (2, 0, 1, 3)), abs=1e-9)
    assert radii == pytest.approx(thick)
    for mine, theirs in zip((hands, axes), hand_of(other, joints), strict=True):
        assert mine == pytest.approx(theirs, abs=1e-9)


@given(strategies.chains(), SEEDS)
def test_hands_are_mujocos(arm, seed):
    mujoco = pytest.importorskip("mujoco")
    model = mujoco.MjModel.from_xml_string(mjcf(arm))
    data = mujoco.MjData(model)
    joints = postures(arm, seed, 3)
    near = 1e-6  # MuJoCo takes frames as one if they are nearer than 1.2e-7
    hands, axes = hands_along(arm, joints)
    for q, hand, axis in zip(joints, hands, axes, strict=True):
        data.qpos[:] = q
        mujoco.mj_kinematics(model, data)
        assert data.site("hand").xpos == pytest.approx(hand, abs=near)
        turn = data.site("hand").xmat.reshape(3, 3)
        assert turn @ arm.model.hand.axis == pytest.approx(axis, abs=near)


def mjcf(arm: Chain):
    """A chain in MuJoCo's format: a body for each joint, and a site for the hand."""

    def row(values):
        return " ".join(f"{x:.17g}" for x in values)

    text = ""
    for k in range(arm.dof, 0, -1):
        joint, hand = arm.model.joints[k - 1], arm.model.hand
        site = f'<site name="hand" pos="{row(hand.point)}"/>' if hand.joint == k else ""
        kind = "hinge" if joint.type == "revolute" else "slide"
        text = (
            f'<body pos="{row(joint.origin)}" quat="{row(joint.rotation)}">'
            f'<joint type="{kind}" axis="{row(joint.axis)}"/>{site}'
            f'<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>{text}</body>'
        )
    base = f'<body pos="{row(arm.base.origin)}" quat="{row(arm.base.rotation)}">{text}</body>'
    return f'<mujoco><compiler angle="radian"/><worldbody>{base}</worldbody></mujoco>'


@EACH
@given(st.data(), SEEDS)
def test_derivatives_are_differences(arms, data, seed):
    arm = data.draw(arms)
    limb, q = limb_of_chain(arm), postures(arm, seed, 1)[0]
    spins, moves, h = np.zeros((3, arm.dof)), np.zeros((3, arm.dof)), 1e-6
    limbs.place(limb, q)
    limbs.jacobian(limb, q, moves)
    limbs.spins(limb, q, spins)
    turns = np.cross(spins.T, limbs.axis_of(limb, 0)).T
    at_base = replace(arm, base=type(arm.base)())
    for j in range(arm.dof):
        step = h * np.eye(arm.dof)[j]
        hands, axes = hands_along(at_base, np.stack([q + step, q - step]))
        assert moves[:, j] == pytest.approx((hands[0] - hands[1]) / (2 * h), abs=1e-6)
        assert turns[:, j] == pytest.approx((axes[0] - axes[1]) / (2 * h), abs=1e-6)


@EACH
@given(st.data(), SEEDS, st.floats(0.0, 1.0))
def test_no_point_of_a_link_travels_farther_than_its_bound(arms, data, seed, width):
    arm = data.draw(arms)
    limb, curve = limb_of_chain(arm), moved(arm, seed)
    middle, half = 0.5, 0.5 * width
    joints = along(curve, np.linspace(middle - half, middle + half, 101))
    at = along(curve, np.array([middle]))
    limbs.swept(limb, curve, middle, half, limbs.place(limb, at[0]))
    (now, _), (then, _) = links_along(arm, at), links_along(arm, joints)
    way = np.linalg.norm(then - now, axis=3).max(axis=(0, 2))
    assert (way <= limb.ways + HAIR).all()


@EACH
@given(st.data(), SEEDS, st.floats(0.0, 2.0))
def test_travel_bounds_any_turns_either_way(arms, data, seed, most):
    """Joints may leave their ranges, as those of a bound do."""
    arm = data.draw(arms)
    limb, (q,) = limb_of_chain(arm), postures(arm, seed, 1)
    rng, factors = np.random.default_rng(seed), arm.model.factors
    limbs.place(limb, q)
    for turns in most * rng.uniform(-1, 1, (20, arm.dof)):
        (now, _), (then, _) = links_along(arm, q[None]), links_along(arm, q + [turns, -turns])
        way = np.linalg.norm(then - now, axis=3).max(axis=(0, 2))
        rates = factors @ turns
        bounds = [travel(limb, i, abs(rates), rates, 1.0) for i in range(len(arm.model.links))]
        assert (way <= np.array(bounds) + HAIR).all()


@EACH
@given(st.data(), SEEDS)
def test_the_hands_rate_and_its_bounds(arms, data, seed):
    arm = data.draw(arms)
    limb, curve, q = limb_of_chain(arm), moved(arm, seed), np.zeros(arm.dof)
    h, shares = 1e-6, np.linspace(0.01, 0.99, 23)
    ahead, behind = (hands_along(arm, along(curve, shares + side)) for side in (h, -h))
    speeds = np.linalg.norm(ahead[0] - behind[0], axis=1) / (2 * h)
    spins = np.linalg.norm(ahead[1] - behind[1], axis=1) / (2 * h)
    rates = np.abs(
        curve[:, 1, None] + shares * (2 * curve[:, 2, None] + 3 * shares * curve[:, 3, None])
    )
    for k, share in enumerate(shares):
        exact = limbs.hand_rate(limb, curve, share, q)
        assert exact == pytest.approx(speeds[k], abs=1e-5)
        assert exact <= limbs.hand_bound(limb, rates[:, k].copy()) + HAIR
        assert spins[k] <= limbs.axis_bound(limb, rates[:, k].copy()) + 1e-5
        assert exact <= limbs.lever(limb) * rates[:, k].sum() + HAIR
    first, last = along(curve, np.array([0.0, 1.0]))
    straight = np.linspace(0.0, 1.0, 200)[:, None]
    hands, _ = hands_along(arm, first + straight * (last - first))
    way = np.linalg.norm(np.diff(hands, axis=0), axis=1).sum()
    assert way <= limbs.hand_travel(limb, first, last) + HAIR


@EACH
@given(st.data(), SEEDS)
def test_no_hand_that_is_too_fast_is_missed(arms, data, seed):
    arm = data.draw(arms)
    limb, curve, q = limb_of_chain(arm), moved(arm, seed), np.zeros(arm.dof)
    fastest = max(limbs.hand_rate(limb, curve, s, q) for s in np.linspace(0.0, 1.0, 2001))
    assert fastest == 0.0 or hand_too_fast(limb, curve, fastest * (1.0 - 1e-9), q)
    assert not hand_too_fast(limb, curve, fastest * 1.02 + 1e-6, q)


@EACH
@given(st.data(), SEEDS)
def test_the_nearest_pair_by_many_points(arms, data, seed):
    arm = data.draw(arms)
    pairs = tuple(itertools.combinations(range(len(arm.model.links)), 2))
    arm = replace(arm, model=replace(arm.model, self_collision=pairs))
    limb, (q,) = limb_of_chain(arm), postures(arm, seed, 1)
    where = limbs.place(limb, q)
    gap, same = limbs.self_gap(limb, where, limbs.still(limb), 1e300)
    (ends,), radii = links_along(arm, q[None])
    share = np.linspace(0.0, 1.0, 101)[:, None]
    best, coarse = np.inf, 0.0
    for i, j in pairs:
        a, b = (ends[k, 0] + share * (ends[k, 1] - ends[k, 0]) for k in (i, j))
        apart = np.linalg.norm(a[:, None] - b[None], axis=2).min() - radii[i] - radii[j]
        best = min(best, apart)
        coarse = max(
            coarse, 0.005 * np.linalg.norm(ends[[i, j], 1] - ends[[i, j], 0], axis=1).sum()
        )
    assert gap == same and gap <= best + HAIR and best <= gap + coarse + HAIR
