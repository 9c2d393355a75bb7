"""Proofs over cells: they hold wherever they are checked, and fail where they have to."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn.arms import forward, joint_angles
from gcm_learn.cover import Cover, CoveredPlanner, StoredCatch, doubt_of, draws, planned
from gcm_learn.cover.limits import elbow_rates
from gcm_learn.cover.reaching import Work, room_of
from gcm_learn.evaluation import complaints
from gcm_learn.motion import rules_of, verify
from gcm_learn.scene import pack, pose


def middle_of(cell):
    """Return middle and half the sides of a cell."""
    return 0.5 * (cell.low + cell.high), 0.5 * (cell.high - cell.low)


def held(cover):
    """Return the proven cells of a cover, each with its catch."""
    return [(cell, cover.catches[cell.held]) for cell in cover.leaves() if cell.held >= 0]


def holds(family, catch, theta):
    """Return whether a bent catch is verified in a situation of its family."""
    scene = pack(family.situation(theta))
    return verify(scene, rules_of(scene), catch.movement(family, theta), catch.body).good


def doubted(family, catch, centre, half):
    """Return the doubt about a cell, or None."""
    return doubt_of(family, catch, centre, half, pack(family.situation(centre)))


def test_draws_from_proven_cells_keep_every_promise(cover):
    assert all(holds(cover.family, catch, theta) for theta, catch in draws(cover, 700, 5))


def test_corners_of_proven_cells_keep_every_promise(cover):
    for cell, catch in held(cover):
        for corner in ((0, 0), (0, 1), (1, 0), (1, 1)):
            theta = np.where(corner, cell.high, cell.low)
            assert holds(cover.family, catch, theta)


def test_the_referee_finds_nothing(cover):
    planner = CoveredPlanner((cover,))
    for theta, _ in draws(cover, 6, 6):
        situation = cover.family.situation(theta)
        plan = planner.plan(situation)
        assert plan.caught and not complaints(situation, plan)


def test_proven_cells_are_proven_and_larger_ones_are_not(cover):
    for cell, catch in held(cover):
        centre, half = middle_of(cell)
        assert doubted(cover.family, catch, centre, half) is None
        assert doubted(cover.family, catch, centre, 6.0 * half) is not None
    halves = [(catch, *middle_of(cell)) for cell, catch in held(cover)]
    grown = [doubted(cover.family, catch, centre, 1.5 * half) for catch, centre, half in halves]
    assert any(doubt is not None for doubt in grown)


def test_movements_far_from_their_cells_break_promises(cover):
    """So the draws above could have found something."""
    low, high = cover.family.low, cover.family.high
    ends = [np.where(corner, high, low) for corner in ((0, 0), (0, 1), (1, 0), (1, 1))]
    assert not all(holds(cover.family, catch, theta) for _, catch in held(cover) for theta in ends)


def moved(family, name, position):
    """Return a family in which one body lies elsewhere."""
    bodies = tuple(
        replace(body, motion=replace(body.motion, position=position)) if body.name == name else body
        for body in family.middle.bodies
    )
    return replace(family, middle=replace(family.middle, bodies=bodies))


def test_an_obstacle_in_the_way_takes_the_proof_away(cover):
    cell, catch = held(cover)[0]
    centre, half = middle_of(cell)
    movement = catch.movement(cover.family, centre)
    halfway = movement.hand_at(0.5 * movement.duration)
    doubt = doubted(moved(cover.family, "post 1", tuple(halfway)), catch, centre, half)
    assert doubt.reason == "clearance"


def test_limits_and_grasp_are_part_of_the_proof(cover):
    cell, catch = held(cover)[0]
    centre, half = middle_of(cell)
    fast = StoredCatch(
        catch.anchor, 0.3 * catch.time, catch.way, catch.ramp, catch.gain, catch.body
    )
    assert doubted(cover.family, fast, centre, half).reason.endswith("speed")
    stiff = StoredCatch(
        catch.anchor, catch.time, catch.way, catch.ramp, 0.0 * catch.gain, catch.body
    )
    wide = 0.5 * (cover.family.high - cover.family.low)
    assert doubted(cover.family, stiff, centre, wide).reason == "grasp"


@pytest.mark.slow
def test_joint_ranges_are_part_of_the_proof(space):
    """The last joint's range ends where the movement does, so that deviations leave it."""
    cell, catch = held(space)[0]
    centre, half = middle_of(cell)
    arm, ends = space.family.middle.arm, catch.places(centre)[[0, -1], 3]
    ranges = (*arm.joint_range[:3], (float(ends.min()), float(ends.max())))
    middle = replace(space.family.middle, arm=replace(arm, joint_range=ranges))
    doubt = doubted(replace(space.family, middle=middle), catch, centre, half)
    assert doubt.reason == "joint range"


@pytest.mark.parametrize("rho", [0.6, 1.0, 1.7])
def test_bounds_of_the_joints_turns_hold(rho):
    rng = np.random.default_rng(3)
    for _ in range(300):
        low, high = np.sort(rng.uniform(abs(1.0 - rho) + 0.02, 1.0 + rho - 0.02, 2))
        shoulder, elbow = elbow_rates(low, high, rho)
        radius, angle = rng.uniform(low, high, 50), rng.uniform(-np.pi, np.pi, (2, 50))
        hand = radius * np.stack([np.cos(angle[0]), np.sin(angle[0])])
        step = 1e-6 * np.stack([np.cos(angle[1]), np.sin(angle[1])])
        turns = [
            joint_angles(np.stack([hand[:, k] - step[:, k], hand[:, k] + step[:, k]]), rho)
            for k in range(50)
        ]
        rates = np.abs(np.diff(turns, axis=1))[:, 0] / 2e-6
        assert (rates <= np.array([shoulder, elbow]) * (1.0 + 1e-4)).all()
        assert rates[:, 0].max() > 0.02 * shoulder  # the bound says something


def test_bounds_of_distance_hold_for_all_deviations(cover):
    """The bound is below the distance of every deviated limb to every moved body."""
    rng = np.random.default_rng(4)
    situation = cover.family.middle
    scene, tight = pack(situation), 0
    start = getattr(situation.arm, "hand", None) or situation.arm.joints
    size, count = len(start), len(situation.bodies)
    work = Work(np.zeros((count, 12)), np.zeros((size, 4)), np.zeros(size), np.zeros(size))
    for _ in range(200):
        middle, away = np.array(start) + rng.uniform(-0.4, 0.4, size), rng.uniform(0.0, 0.08, size)
        b = int(rng.integers(1, len(situation.bodies)))

        def room(place, off, body=b):
            work.middle[:], work.away[:] = place, off
            return room_of(scene.limb, scene, body, 0.3, 0.0, 1e300, work)

        bound = room(middle, away)
        exact = [room(middle + rng.uniform(-1, 1, size) * away, 0.0 * away) for _ in range(30)]
        assert bound <= min(exact) + 1e-12
        tight += bound > min(exact) - 2.0 * away.sum()
    assert tight > 150  # the bound says something


def test_the_rule_is_linear_and_leaves_the_start(cover):
    family = cover.family
    for _, catch in held(cover)[:3]:
        a, b = catch.places(family.low), catch.places(family.high)
        assert np.allclose(0.5 * (a + b), catch.places(family.centre), atol=1e-12)
        assert (a[0] == b[0]).all() and not np.allclose(a[-1], b[-1])


def test_plans_are_made_with_a_ramp_from_each_begin(cover):
    catches, reason = planned(cover.family, cover.family.centre)
    assert reason == "" and len(catches) == 2
    for catch in catches:
        assert catch.ramp[0] == 0.0 and catch.ramp[-1] == 1.0
        assert (np.diff(catch.ramp) >= 0.0).all() and (np.diff(catch.time) > 0.0).all()


def test_a_place_that_nothing_reaches_says_why(plane):
    far = moved(plane.family, "part", (9.0, 9.0))
    assert planned(far, far.centre) == ([], "unreachable")


def test_poses_follow_the_parameters(cover):
    """The derivatives that bound bodies' ways are those of their poses."""
    family, t = cover.family, 0.7
    for k in range(len(family.parameters)):
        step = np.eye(len(family.parameters))[k] * 1e-3
        for b in range(len(family.middle.bodies)):
            here = pose(family.situation(family.centre), b, t)[0]
            there = pose(family.situation(family.centre + step), b, t)[0]
            slope = family.drifts(np.array([t]))[0, k, b]
            assert np.allclose((there - here)[: slope.size], 1e-3 * slope, atol=1e-12)


def test_forward_and_places_agree(plane):
    _, catch = held(plane)[0]
    movement = catch.movement(plane.family, plane.family.centre)
    assert np.allclose(forward(movement.joints, movement.arm.upper_arm), movement.hand)


def test_a_cover_of_nothing_draws_nothing(plane):
    assert list(draws(Cover(plane.family), 5, 0)) == []
