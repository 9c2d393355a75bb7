"""Verification by a hair: each promise of "caught" is just kept, and just broken."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn.arms import SIDE, Arm, forward_in_space, joints_of
from gcm_learn.motion import Failure, Movement, rules_of, verify
from gcm_learn.motion.joint_interception import ANGLE
from gcm_learn.motion.joint_verification import hand_too_fast, piece_fault
from gcm_learn.motion.rules import CATCH_SAFETY, SAFETY
from gcm_learn.motion.verification import joint_turns, nearest_to_shoulder
from gcm_learn.scene import pack
from gcm_learn.situation import (
    Approach,
    Body,
    Disc,
    PlanarQuadratic,
    Situation,
    SolidQuadratic,
    Sphere,
)
from tests.spatial import TURNED, TWO_BONES

HAIR = 1e-9
START, GOAL = (1.2, 0.3), (0.9, 1.0)
ARM = Arm(START, 3.0, thickness=0.02, grasp=0.02)
WAY = np.linspace(START, GOAL, 60)
TIME = np.linspace(0.0, 0.8, 60)


def in_plane(arm=ARM, at=GOAL, post=(5.0, 5.0), horizon=1.0):
    still = (0.0, 0.0)
    part = Body("target", "part", Disc(0.02), PlanarQuadratic(tuple(at), still, still))
    other = Body("obstacle", "post", Disc(0.02), PlanarQuadratic(tuple(post), still, still))
    return Situation("hairs", horizon, arm, (part, other))


def failure(situation, time=TIME, way=WAY):
    """Return what is wrong with a way of the hand, or with a movement in the joints."""
    scene, arm = pack(situation), situation.arm
    planar = isinstance(arm, Arm)
    moves = (Movement.of_hand if planar else Movement)(arm, np.array(time), np.array(way))
    verdict = verify(scene, rules_of(scene), moves, 0)
    return None if verdict.good else verdict.reason.failure


def hair(value, failing, made):
    """Check that a value keeps a promise, and that one beyond it by a hair breaks it."""
    good, bad = made(value - HAIR), made(value + HAIR)
    assert failure(*good) is None
    assert failure(*bad) is failing


def test_the_grasp_of_a_planar_arm_is_kept_with_half_of_its_safety():
    away = ARM.grasp + 0.02 - 0.5 * CATCH_SAFETY  # the target's radius is 0.02
    for side in ((1.0, 0.0), (0.0, 1.0), (-0.6, 0.8)):
        hair(
            away, Failure.MISSED, lambda x, s=side: (in_plane(at=np.array(GOAL) + x * np.array(s)),)
        )


def test_the_grasp_in_space_is_kept_with_half_of_its_safety():
    away = TWO_BONES.grasp + 0.02 - 0.5 * CATCH_SAFETY * 0.8  # of the forearm's length
    for side in np.eye(3):
        hair(away, Failure.MISSED, lambda x, s=side: reaching(off=x * s))


def reaching(arm=TWO_BONES, off=0.0, time=0.8, goal=TURNED, horizon=1.0):
    """Return a situation in space, times and joints that go straight to its target."""
    place = tuple((forward_in_space(TWO_BONES, goal)[1] + off).tolist())
    target = Body("target", "part", Sphere(0.02), SolidQuadratic(place, (0.0,) * 3, (0.0,) * 3))
    return Situation("hairs", horizon, arm, (target,)), [0.0, time], [TWO_BONES.joints, goal]


def test_planar_speeds_are_kept_up_to_a_hair():
    need = np.linalg.norm(WAY[-1] - WAY[0]) / 0.8
    for factor, wrong in ((1.0 - 2e-7, Failure.HAND_SPEED), (1.0, None)):
        assert failure(in_plane(replace(ARM, max_hand_speed=need * factor))) is wrong
    turns = joint_turns(WAY, 1.0, SIDE[ARM.elbow], 16) / np.diff(TIME)[:, None]
    for joint in range(2):
        for factor, wrong in ((1.0 - 2e-7, Failure.JOINT_SPEED), (1.0, None)):
            speeds = np.where(np.arange(2) == joint, factor * turns.max(axis=0), 9.0)
            assert failure(in_plane(replace(ARM, max_joint_speed=tuple(speeds)))) is wrong


def test_the_last_piece_is_judged_as_the_others():
    """A hand that is too fast only in the first or the last of its pieces."""
    need = np.linalg.norm(WAY[-1] - WAY[0]) / 0.8
    arm = replace(ARM, max_hand_speed=1.05 * need)
    for k in (0, 58):
        spans = np.diff(TIME)
        spans[k] *= 0.9
        assert failure(in_plane(arm), np.append(0.0, spans.cumsum())) is Failure.HAND_SPEED


def test_starts_and_ends_are_exact():
    assert failure(in_plane(), way=WAY + (0.0, 1e-12)) is Failure.WRONG_START
    assert failure(in_plane(), way=WAY + (1e-12, 0.0)) is Failure.WRONG_START
    assert failure(in_plane(), TIME + 1e-12) is Failure.WRONG_START
    assert failure(in_plane(horizon=0.8)) is None
    assert failure(in_plane(horizon=0.8 - HAIR)) is Failure.LATE
    situation, time, joints = reaching(horizon=0.8)
    assert failure(situation, time, joints) is None
    assert failure(situation, [0.0, 0.8 + HAIR], joints) is Failure.LATE
    for j in range(4):
        assert failure(situation, time, [joints[0] + 1e-12 * np.eye(4)[j], TURNED]) is (
            Failure.WRONG_START
        )


def test_a_planar_hand_stays_in_its_ring():
    arm = Arm((1.2, 0.3), 9.0, upper_arm=1.5)
    for radius, wrong in ((0.52, None), (0.499, Failure.OUTSIDE), (2.501, Failure.OUTSIDE)):
        way = np.linspace(arm.hand, (0.0, radius), 400)
        found = failure(in_plane(arm, at=(0.0, radius)), np.linspace(0.0, 0.9, 400), way)
        assert found is wrong


def test_the_place_nearest_to_the_shoulder_may_be_anywhere_on_a_way():
    for k in range(20):
        hand = np.random.default_rng(k).normal(size=(4, 2))
        fine = np.concatenate([np.linspace(hand[i], hand[i + 1], 4001) for i in range(3)])
        least = np.linalg.norm(fine, axis=1).min()
        assert nearest_to_shoulder(hand) == pytest.approx(least, abs=1e-3)
    assert nearest_to_shoulder(hand[:1]) == pytest.approx(np.linalg.norm(hand[0]))


def by_definition(hand, rho, side, parts):
    """Return the turns (2,) of a segment by their definition: mean rates, and rates at places."""

    def joints(s):
        places = hand[0] + np.atleast_1d(s)[:, None] * (hand[1] - hand[0])
        return joints_of(places, rho, side)

    share = np.linspace(0.0, 1.0, parts + 1)
    means = parts * np.abs(np.diff(joints(share), axis=0)).max(axis=0)
    way = hand[1] - hand[0]
    nearest = np.clip(-(hand[0] @ way) / (way @ way), 0.0, 1.0)
    rates = [np.abs(joints(s + 1e-6) - joints(s - 1e-6))[0] / 2e-6 for s in (*share, nearest)]
    return np.maximum(means, np.max(rates, axis=0))


@pytest.mark.parametrize("rho", [0.6, 1.0, 1.6])
@pytest.mark.parametrize("parts", [1, 2, 5])
def test_turns_of_segments_are_those_of_their_definition(rho, parts):
    rng, seen = np.random.default_rng(parts), 0
    for _ in range(60):
        angle, radius = rng.uniform(-3.0, 3.0), rng.uniform(abs(rho - 1.0) + 0.02, rho + 0.98, 2)
        turn = np.array((angle, angle + rng.uniform(-1.0, 1.0)))
        hand = radius[:, None] * np.stack([np.cos(turn), np.sin(turn)], axis=1)
        if nearest_to_shoulder(hand) < abs(rho - 1.0) + 0.01 or abs(turn).max() > 3.0:
            continue
        for side in (-1.0, 1.0):
            found = joint_turns(hand, rho, side, parts)[0]
            assert found == pytest.approx(by_definition(hand, rho, side, parts), rel=1e-3)
            seen += 1
    assert seen > 20


def test_near_the_shoulder_joints_do_not_leap():
    """A hand goes a little way there, while the arm turns far."""
    arm = Arm((0.01, 0.0), 3.0, grasp=0.02)
    for turn, wrong in ((0.45, None), (0.55, Failure.SINGULAR)):
        goal = 0.01 * np.array((np.cos(turn), np.sin(turn)))
        assert failure(in_plane(arm, at=goal), [0.0, 0.5], [arm.hand, goal]) is wrong


def test_every_piece_of_a_way_is_followed_by_the_joints():
    """Too few samples in the first, a middle or the last part of a way."""
    for k in (0, 11, 22, 33, 43):  # the last sample stays
        kept = np.delete(np.arange(60), np.arange(k + 1, k + 16))
        assert failure(in_plane(), TIME[kept], WAY[kept]) is Failure.ASTRAY


def test_an_approach_is_kept_up_to_a_hair():
    """The angle between the hand's axis and that of the target, in space."""
    situation, time, joints = reaching()
    elbow, hand = forward_in_space(TWO_BONES, TURNED)
    ahead = (hand - elbow) / np.linalg.norm(hand - elbow)
    other = np.cross(ahead, (0.0, 0.0, 1.0))
    aside = np.cos(0.3) * ahead + np.sin(0.3) * other / np.linalg.norm(other)
    for extra, wrong in ((1.9, None), (2.1, Failure.MISSED)):
        approach = Approach(tuple(aside.tolist()), 0.3 - extra * ANGLE)
        target = replace(situation.bodies[0], approach=(approach,))
        third = replace(situation, bodies=(target,), format="gcm-learn/situation@3")
        assert failure(third, time, joints) is wrong


def test_a_plan_keeps_its_distance():
    """Beyond the hand's last place: the thickness, the post's radius, and the safety of plans."""
    ahead = np.array((-0.39, 0.92)) / np.linalg.norm((-0.39, 0.92))
    for extra, wrong in ((1e-6, None), (-1e-6, Failure.COLLISION)):
        post = GOAL + (0.02 + 0.02 + SAFETY + extra) * ahead
        assert failure(in_plane(post=post)) is wrong


@pytest.mark.parametrize("what", ["range below", "range above", "speed"])
@pytest.mark.parametrize("joint", range(4))
def test_limits_in_space_are_kept_up_to_a_hair(what, joint):
    """By a straight move in 0.8 s, whose joint at one end is at the limit."""
    situation, time, joints = reaching()
    ends = np.array(joints)
    low, high = [-3.0] * 4, [3.0] * 4
    need = abs(ends[1] - ends[0])[joint] / 0.8
    for inside in (True, False):
        arm = TWO_BONES
        if what == "range below":
            low[joint] = ends[:, joint].min() + (0.0 if inside else 1e-6)
        elif what == "range above":
            high[joint] = ends[:, joint].max() - (0.0 if inside else 1e-6)
        elif what == "speed":
            speeds = np.full(4, 9.0)
            speeds[joint] = need * (1.0 if inside else 1.0 - 2e-7)
            arm = replace(arm, max_joint_speed=tuple(speeds))
        if what.startswith("range"):
            if not low[joint] <= TWO_BONES.joints[joint] <= high[joint]:
                continue  # such a start is refused before
            arm = replace(arm, joint_range=tuple(zip(low, high, strict=True)))
        wrong = Failure.JOINT_SPEED if what == "speed" else Failure.JOINT_RANGE
        assert failure(replace(situation, arm=arm), time, joints) is (None if inside else wrong)


def curve(*rows):
    """Return a curve (4, 4) whose first joints have coefficients of the share."""
    out = np.zeros((4, 4))
    out[: len(rows)] = rows
    return out


def fault(arm, moves, span):
    return piece_fault(pack(reaching(arm)[0]), moves, span, np.zeros(4))


RANGE, JOINT, FORCED, FAST = 3, 4, 5, 6
BENT = {
    "turns back": ((0.0, 1.0, -1.0, 0.0), (0.25, 0.0), 1.0, (2.0, 2.0)),
    "turns back from below": ((0.0, -1.0, 1.0, 0.0), (0.0, -0.25), 1.0, (2.0, 2.0)),
    "fastest in the middle": ((0.0, 0.0, 3.0, -2.0), (1.0, 0.0), 1.5, (6.0, 6.0)),
    "fastest at the end": ((0.0, 0.0, 0.0, 1.0), (1.0, 0.0), 3.0, (0.0, 6.0)),
    "hardest at the begin": ((0.0, 3.0, -3.0, 1.0), (1.0, 0.0), 3.0, (6.0, 0.0)),
    "twice back": ((0.0, 1.0, -3.0, 2.0), (0.09622504486, -0.09622504486), 1.0, (6.0, 6.0)),
}  # fmt: skip


@pytest.mark.parametrize("name", BENT)
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_cubic_moves_are_judged_at_their_extremes(name, sign):
    """Ranges, rates and accelerations of the second joint, that are just kept or just not."""
    row, (above, below), rate, bends = BENT[name]
    high, low = (above, below) if sign > 0.0 else (-below, -above)
    moves, span = curve((0.0,) * 4, sign * np.array(row)), 0.5
    free = replace(TWO_BONES, max_joint_acceleration=(99.0,) * 4, joint_range=((-3.0, 3.0),) * 4)
    assert fault(free, moves, span) == 0
    for share, found in ((1.0, 0), (1.0 - 1e-5, 1)):
        fast = (9.0, share * rate / span, 9.0, 9.0)
        assert fault(replace(free, max_joint_speed=fast), moves, span) == found * JOINT
        most = (99.0, share * max(bends) / span**2, 99.0, 99.0)
        assert fault(replace(free, max_joint_acceleration=most), moves, span) == found * FORCED
        slack = 1e-5 if found else 0.0
        for ends in ((low + slack, 3.0), (-3.0, high - slack)):
            if ends[0] <= 0.0 <= ends[1]:
                ranges = replace(free, joint_range=((-3.0, 3.0), ends, *((-3.0, 3.0),) * 2))
                assert fault(ranges, moves, span) == found * RANGE


def fastest(moves):
    """Return the hand's largest way per share of a move, by small steps."""
    s = np.linspace(0.0, 1.0, 2001)[:, None]
    hands = [
        np.array([forward_in_space(TWO_BONES, q)[1] for q in place])
        for place in (_along(moves, s - 1e-6), _along(moves, s + 1e-6))
    ]
    return np.linalg.norm(hands[1] - hands[0], axis=1).max() / 2e-6


def _along(moves, s):
    a, b, c, d = moves.T
    return a + s * (b + s * (c + s * d))


@pytest.mark.parametrize("seed", range(6))
def test_the_fastest_hand_is_found_wherever_it_is(seed):
    limb, rng = pack(reaching()[0]).limb, np.random.default_rng(seed)
    moves = np.stack([TURNED, *rng.normal(size=(3, 4)) * (1.0, 3.0, 2.0, 1.0)[seed % 4]], axis=1)
    most = fastest(moves)
    assert not hand_too_fast(limb, moves, 1.001 * most, np.zeros(4))
    assert hand_too_fast(limb, moves, 0.999 * most, np.zeros(4))


FIRST = {
    "in the middle": (TURNED, 3, (0.0, 0.0, 0.3, -0.2)),
    "soon after the begin": (TURNED, 3, (0.0, 0.01, 0.002, -0.02 / 3.0)),
    "of a stretched arm": (0.0 * TURNED, 1, (0.0, 0.5, 0.0, 0.0)),
    "at the begin": (TURNED, 0, (0.0, 0.4, -0.2, 0.0)),
}


@pytest.mark.parametrize("name", FIRST)
def test_the_fastest_hand_of_one_joint_is_found(name):
    """Slow at both ends, or a little faster than at an end, as rates change little."""
    place, joint, row = FIRST[name]
    moves = np.stack([place, *np.zeros((3, 4))], axis=1)
    moves[joint, 1:] = row[1:]
    limb, most = pack(reaching()[0]).limb, fastest(moves)
    assert not hand_too_fast(limb, moves, 1.0005 * most, np.zeros(4))
    assert hand_too_fast(limb, moves, 0.9995 * most, np.zeros(4))


def test_the_last_piece_of_a_move_keeps_its_distance():
    """A ball that only the last of three pieces comes near to."""
    situation, _, joints = reaching()
    way = np.linspace(*np.array(joints), 4)
    hand = [forward_in_space(TWO_BONES, q)[1] for q in way]
    ahead = (hand[3] - hand[2]) / np.linalg.norm(hand[3] - hand[2])
    for gap, wrong in ((0.02, None), (-0.005, Failure.COLLISION)):
        place = tuple((hand[3] + (0.05 + 0.02 + gap) * ahead).tolist())
        law = SolidQuadratic(place, (0.0,) * 3, (0.0,) * 3)
        post = Body("obstacle", "post", Sphere(0.02), law)
        both = replace(situation, bodies=(*situation.bodies, post))
        assert failure(both, np.linspace(0.0, 0.8, 4), way) is wrong


def test_rates_begin_as_the_arm_moves():
    """Under limits of acceleration, a catch at t = 0 included, where the hand may be too fast."""
    rates = (0.0, 0.5, 0.0, 0.0)
    arm = replace(TWO_BONES, max_joint_acceleration=(99.0,) * 4, joint_rates=rates)
    situation, time, joints = reaching(arm)
    scene = pack(situation)
    for change, wrong in ((0.0, None), (1e-9, Failure.WRONG_START)):
        given = np.array([np.add(rates, (0.0, 0.0, change, 0.0)), (0.0,) * 4])
        moves = Movement(arm, np.array(time), np.array(joints), given)
        verdict = verify(scene, rules_of(scene), moves, 0)
        assert (None if verdict.good else verdict.reason.failure) is wrong
    here = np.array([arm.joints])
    hand = forward_in_space(TWO_BONES, here[0])[1]
    speed = 0.5 * np.hypot(hand[0], hand[1])  # the second joint turns about z
    for share, wrong in ((1.001, None), (0.999, Failure.HAND_SPEED)):
        fast = replace(arm, max_hand_speed=share * speed)
        at_once = reaching(fast, goal=here[0])[0]
        scene = pack(at_once)
        moves = Movement(fast, np.zeros(1), here, np.array([rates]))
        verdict = verify(scene, rules_of(scene), moves, 0)
        assert (None if verdict.good else verdict.reason.failure) is wrong
