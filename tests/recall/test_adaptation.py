"""Bending remembered paths: identities, symmetry, sides of bodies, and verdicts that hold."""

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import seeding
from gcm_learn.arms import Arm
from gcm_learn.families.paper import gate_scene
from gcm_learn.families.random_planar import random_planar
from gcm_learn.families.random_solid import random_solid
from gcm_learn.motion.movement import Movement
from gcm_learn.planners.completion import Problem, checked
from gcm_learn.planners.goal_directed import layered
from gcm_learn.recall import Adaptation, adapt, path_of, transfer, waypoints_of
from gcm_learn.recall.hand_paths import ANGLE, EARLIEST, KNOTS, RING, TIME
from gcm_learn.recall.planners import random_waypoints
from gcm_learn.recall.waypoints import NEAR, passing, passing_of
from gcm_learn.scene.bodies import pose_at
from gcm_learn.scene.shapes.choice import gap_in_plane
from gcm_learn.situation.canonical import canonical
from tests.recall.conftest import limited, stacked
from tests.transforms import mirrored, turned
from tests.worlds import among, disc

EVERY = [
    Adaptation(style, tempo) for style in ("polar", "cartesian") for tempo in ("hurry", "keep")
]


def apart(way, other):
    """Largest distance of the hands of two movements at the same times."""
    t = np.linspace(0.0, min(way.duration, other.duration), 400)
    return np.linalg.norm(way.hand_at(t) - other.hand_at(t), axis=1).max()


def test_knots_keep_corners_and_waits(catches, traces):
    """The path between the knots is the plan's, to a hundredth of a hand's width."""
    for (situation, plan), trace in zip(catches, traces, strict=True):
        time, hand = path_of(trace, situation.arm)
        frame = canonical(situation)[1]
        kept = np.stack(
            [np.interp(plan.trajectory.time, time, hand[:, k]) for k in (0, 1)], axis=-1
        )
        off = np.linalg.norm(frame.original(kept) - plan.trajectory.hand, axis=1).max()
        assert off < 2e-3
        assert trace.catch_time == pytest.approx(plan.catch_time, rel=1e-6)


def test_a_wait_is_remembered_as_one():
    situation = gate_scene()
    plan = layered().plan(situation)
    longest = max(plan.trajectory.waits(), key=lambda wait: wait.duration)
    knots = waypoints_of(situation, plan).knots
    ends = knots[knots[:, EARLIEST] > 0.0, TIME]
    assert np.abs(ends - longest.end).min() < 0.02
    assert adapt(Problem(situation, "same"), waypoints_of(situation, plan)) is not None


@pytest.mark.parametrize("how", EVERY, ids=lambda how: f"{how.style}-{how.tempo}")
def test_the_same_situation_gives_the_same_path(catches, traces, how):
    """But for catches that come sooner, and what the knots have lost."""
    same = late = 0
    for (situation, plan), trace in zip(catches, traces, strict=True):
        attempt = adapt(Problem(situation, "same"), trace, how)
        if attempt is None or attempt.trajectory.duration > plan.catch_time + 0.01:
            late += 1
            continue
        if abs(attempt.trajectory.duration - plan.catch_time) < 0.01:
            same += 1
            # A path that is hurried is not at the same places at the same times.
            ends = attempt.trajectory.hand[-1] - plan.trajectory.hand[-1]
            assert np.linalg.norm(ends) < 0.06
            if how.tempo == "keep":
                assert apart(attempt.trajectory, plan.trajectory) < 0.06
    assert late <= 0.01 * len(traces)  # those that pass nearer to the hole than paths are bent
    assert same > 0.9 * len(traces)
    held = [
        transfer(s, t.knots[None], t.goal[None], how=how)[0] >= 0.0
        for (s, _), t in zip(catches, traces, strict=True)
    ]
    assert np.mean(held) > 0.97


def test_paths_start_at_the_hand_and_end_at_the_target(catches, traces):
    """Whatever is remembered and whatever is asked."""
    rng, ends = seeding.rng(5), 0
    for situation, _ in catches[:60]:
        problem = Problem(situation, "ends")
        for k in rng.integers(len(traces), size=5):
            attempt = adapt(problem, traces[k], EVERY[k % len(EVERY)])
            if attempt is None:
                continue
            way, poses = attempt.trajectory, np.zeros((len(situation.bodies), 12))
            pose_at(problem.bodies, attempt.body, way.duration, poses)
            assert tuple(way.hand[0]) == situation.arm.hand
            last = gap_in_plane(problem.bodies, poses, attempt.body, *way.hand[-1])
            assert last <= problem.rules.catch
            assert way.duration <= situation.horizon
            ends += 1
    assert ends > 150


@pytest.mark.parametrize("style", ["polar", "cartesian"])
def test_paths_turn_and_mirror_with_the_situation(catches, traces, style):
    """What is bent branches at roundings, so there only most times are the same."""
    how, bent, compared, off = Adaptation(style, "both", 0), Adaptation(style, "both"), 0, 0
    knots, goals = stacked(traces[:40])
    for situation, _ in catches[100:110]:
        there = turned(situation, 2.0)
        other = mirrored(there)
        times = [transfer(s, knots, goals, how=how) for s in (situation, there, other)]
        for moved in times[1:]:
            assert np.mean((moved >= 0.0) == (times[0] >= 0.0)) > 0.97  # roundings may decide
            both = (moved >= 0.0) & (times[0] >= 0.0)
            np.testing.assert_allclose(moved[both], times[0][both], atol=1e-3)
            compared += both.sum()
        bends = [transfer(s, knots, goals, how=bent) for s in (situation, other)]
        off += np.sum(np.abs(bends[1] - bends[0]) > 1e-3)
        first = adapt(Problem(situation, "a"), traces[0], how)
        second = adapt(Problem(other, "b"), traces[0], how)
        if first is not None and second is not None:
            back = second.trajectory.hand * (1.0, -1.0)
            c, s = np.cos(2.0), np.sin(2.0)
            np.testing.assert_allclose(
                back[-1] @ np.array([[c, -s], [s, c]]), first.trajectory.hand[-1], atol=2e-3
            )
    assert compared > 100
    assert off <= 0.05 * 400


@pytest.mark.parametrize(
    ("family", "situations"), [(random_planar, 100), (random_solid, 40), (limited, 30)]
)
def test_the_quick_verdict_is_that_of_the_verification(traces, family, situations):
    """Both ways round: of what transfers, what is verified; of what does not, what would be."""
    knots, goals = stacked(traces)
    counts = np.zeros((2, 2), dtype=int)
    for k in range(situations):
        rng = seeding.rng(72, k)
        situation = family(rng)
        problem = Problem(situation, "verdicts")
        if problem.early_answer() is not None:
            continue
        how = replace(EVERY[k % len(EVERY)], bends=0)
        chosen = rng.integers(len(traces), size=12)
        times = transfer(situation, knots, goals, chosen, how)
        for i, t in zip(chosen, times, strict=True):
            attempt = adapt(problem, traces[i], how)
            good = attempt is not None and checked(problem, attempt)[0] is not None
            counts[int(t >= 0.0), int(good)] += 1
    assert counts.sum() > 4 * situations
    assert counts[1].sum() > 50
    assert counts[1, 0] <= 0.01 * counts[1].sum()
    assert counts[0, 1] <= 0.01 * counts[0].sum()


def test_random_splines_are_of_their_distribution():
    knots, goals = random_waypoints(3, 5, 400, 0.5, 1.2)
    again, _ = random_waypoints(3, 5, 400, 0.5, 1.2)
    other, _ = random_waypoints(3, 6, 400, 0.5, 1.2)
    assert np.array_equal(knots, again) and not np.array_equal(knots, other)
    assert knots.shape == (400, KNOTS, 4) and np.array_equal(goals, knots[:, -1, :2])
    assert np.all(knots[:, 0, ANGLE] == 0.0) and np.allclose(knots[:, 0, RING], 0.5)
    assert 0.15 < (knots[:, :, EARLIEST].max(axis=1) > 0.0).mean() < 0.35


STILL = (0.0, 0.0)


def passed(*obstacles):
    """An arm that reaches from right to left, with discs at (place, velocity) around."""
    ball = disc("ball", (-1.2, 0.9), role="target", radius=0.05)
    discs = [disc(f"disc {k}", *given, radius=0.05) for k, given in enumerate(obstacles)]
    return among(Arm((1.2, 0.9), 4.0), ball, *discs)


def straight(bend=0.0, duration=0.8, n=60):
    """From (1.2, 0.9) to (-1.2, 0.9), aside by `bend` in the middle."""
    s = np.linspace(0.0, 1.0, n)
    hand = np.stack([1.2 - 2.4 * s, 0.9 + bend * np.sin(np.pi * s)], axis=1)
    return Movement.of_hand(Arm((1.2, 0.9), 4.0), s * duration, hand)


def test_a_hand_that_goes_left_has_what_is_above_on_its_right():
    above = passing(passed(((0.0, 1.1), STILL)), straight())
    assert above.sides == "r"
    both = passing(passed(((-0.3, 1.1), STILL), ((0.3, 0.75), STILL)), straight())
    assert both.sides == "lr" and both.when[1] < both.when[0]


def test_far_bodies_and_bodies_beyond_the_ends_are_not_passed():
    far = passing(passed(((0.0, 0.9 + NEAR + 0.8), STILL)), straight())
    assert far.sides == "" and far.clearance[0] > NEAR
    beyond = passing(passed(((-1.35, 1.0), STILL)), straight())
    assert beyond.sides == "" and abs(beyond.turn[0]) < 0.5 * np.pi


def test_a_deformation_that_touches_nothing_changes_no_turn():
    situation = passed(((0.0, 1.2), STILL))
    turns = [passing(situation, straight(bend)).turn[0] for bend in (-0.4, 0.0, 0.2)]
    np.testing.assert_allclose(turns, turns[0], atol=1e-9)
    across = passing(situation, straight(0.7)).turn[0]
    assert across - turns[0] == pytest.approx(2.0 * np.pi)


def test_before_and_behind_a_moving_body_are_two_sides():
    situation = passed(((0.0, 0.2), (0.0, 1.4)))  # it crosses the way at 0.5 s
    first, later = straight(duration=0.7), straight(duration=1.3)
    before, behind = passing(situation, first).turn[0], passing(situation, later).turn[0]
    assert before > 0.5 * np.pi and behind < -0.5 * np.pi


def test_sides_turn_and_mirror_with_the_situation(catches, traces):
    seen = 0
    for (situation, plan), trace in list(zip(catches, traces, strict=True))[:80]:
        there = passing(situation, plan.trajectory)
        flip = np.diag([1.0, -1.0])
        flipped = mirrored(situation)
        way = plan.trajectory
        other = Movement.of_hand(flipped.arm, way.time, way.hand @ flip)
        here = passing(flipped, replace(other, joints=way.joints))
        np.testing.assert_allclose(here.turn, there.turn, atol=1e-9)
        c, s = np.cos(1.1), np.sin(1.1)
        about = Movement.of_hand(situation.arm, way.time, way.hand @ np.array([[c, s], [-s, c]]))
        np.testing.assert_allclose(
            passing(turned(situation, 1.1), about).turn, there.turn, atol=1e-9
        )
        kept = passing_of(canonical(situation)[0], trace)
        assert kept.sides == there.sides
        seen += there.sides != ""
    assert seen > 10
