"""Plans followed under a limit of acceleration."""

from __future__ import annotations

import numpy as np
import pytest

from gcm_learn import seeding
from gcm_learn.errors import SituationError
from gcm_learn.families.random_planar import random_planar
from gcm_learn.planners import get_planner
from gcm_learn.planners.baselines.straight import StraightPlanner, StraightWaitPlanner
from gcm_learn.planners.retiming import Motion, retime
from gcm_learn.situation import Disc
from tests.judging import judge
from tests.planners.test_baselines import FREE, GATE, SPEED, TRAP, body, goal, scene


def accelerations(trajectory):
    """Second differences of the equal steps, which the last is not, and of the rest before."""
    hand, step = trajectory.hand[:-1], trajectory.time[1]
    np.testing.assert_allclose(np.diff(trajectory.time[:-1]), step, rtol=1e-6)
    padded = np.vstack([hand[:1], hand])
    return np.hypot(*np.diff(padded, 2, axis=0).T) / step**2


# --- the average -----------------------------------------------------------------------------


@pytest.fixture
def motion(rng):
    time = np.concatenate([[0.0], np.cumsum(rng.uniform(0.02, 0.2, 12))])
    return Motion(time, rng.uniform(-1.0, 1.0, (13, 2)))


def test_the_average_is_the_mean_over_the_window(motion):
    window, t = 0.3, np.linspace(0.0, motion.time[-1], 7)
    inside = (np.arange(20_000) + 0.5) / 20_000 * window
    for mean, now in zip(motion.averaged(window, t), t, strict=True):
        late = now - inside
        hands = [np.interp(late, motion.time, motion.hand[:, a]).mean() for a in (0, 1)]
        np.testing.assert_allclose(mean, hands, atol=1e-5)


def test_the_acceleration_is_that_of_the_average(motion):
    window, step = 0.25, 1e-4
    hand = motion.averaged(window, np.arange(0.0, motion.time[-1] + window, step))
    measured = np.hypot(*np.diff(hand, 2, axis=0).T).max() / step**2
    assert motion.acceleration(window) == pytest.approx(measured, rel=1e-3)


# --- plans -----------------------------------------------------------------------------------


@pytest.mark.parametrize("most", [20.0, 60.0, 1e12])
def test_a_straight_catch_comes_later_by_what_speeding_up_takes(most):
    """From rest to full speed takes v / a, on half the way that full speed would make."""
    plan = StraightPlanner().plan(FREE)
    slow = retime(plan, FREE, most)
    assert slow.caught and judge(FREE, slow) == []
    late = slow.catch_time - plan.catch_time
    assert late == pytest.approx(0.5 * SPEED / most, abs=1e-3)
    t = np.array([0.3, 0.9]) * min(SPEED / most, 0.1)
    if most < 1e6:
        way = np.hypot(*(slow.trajectory.hand_at(t) - FREE.arm.hand).T)
        np.testing.assert_allclose(way, 0.5 * most * t**2, atol=2e-4)


def test_a_plan_that_has_time_to_spare_is_kept_to_the_moment():
    plan = StraightWaitPlanner(shares=(1.0,)).plan(GATE)
    slow = retime(plan, GATE, 33.0)
    assert slow.caught and judge(GATE, slow) == []
    assert slow.catch_time == pytest.approx(plan.catch_time, abs=1e-3)


def test_a_way_round_is_kept_though_its_corners_are_cut():
    plan = get_planner("layered").plan(TRAP)
    slow = retime(plan, TRAP, 50.0)
    assert slow.caught and judge(TRAP, slow) == []
    assert accelerations(slow.trajectory).max() <= 50.0 * (1.0 + 1e-6)
    assert plan.catch_time < slow.catch_time < plan.catch_time + 3.0 * SPEED / 50.0


def test_every_retimed_catch_keeps_limit_and_promise():
    layered, kept, plans = get_planner("layered"), 0, 0
    for k in range(80):
        situation = random_planar(seeding.rng(93, k))
        plan = layered.plan(situation)
        if not plan.caught or plan.catch_time == 0.0:
            continue
        plans += 1
        most = (300.0, 100.0, 33.0)[k % 3]
        slow = retime(plan, situation, most)
        assert slow.status in ("caught", "unreachable") and slow.planner == "layered"
        if slow.caught:
            kept += 1
            assert judge(situation, slow) == []
            assert accelerations(slow.trajectory).max() <= most * (1.0 + 1e-6)
    assert plans > 25 and kept > 0.8 * plans


def test_what_cannot_be_met_in_time_is_said_so():
    plan = StraightPlanner().plan(FREE)
    slow = retime(plan, FREE, 0.5)  # 0.25 t^2 is less than the way of one forearm in 1.2 s
    assert slow.status == "unreachable" and slow.trajectory is None
    assert slow.message == "not with accelerations up to 0.5: no target is met in time"


def test_a_gap_that_has_closed_by_then_is_not_slipped_through():
    """The disc comes across the way just behind a hand that starts at full speed."""
    comer = body("obstacle", Disc(0.3), (1.15, 3.6), (0.0, -9.0))
    closing = scene(goal(1.3, 0.6), comer, hand=(0.9, -0.4), horizon=0.5)
    plan = StraightPlanner().plan(closing)
    assert plan.caught
    assert retime(plan, closing, 3000.0).caught
    slow = retime(plan, closing, 25.0)
    assert slow.status == "unreachable" and "touched" in slow.message


def test_what_needs_no_retiming_is_returned():
    here = scene(goal(0.9, 0.0))
    at_once = StraightPlanner().plan(here)
    assert at_once.catch_time == 0.0 and retime(at_once, here, 1.0) is at_once
    none = StraightPlanner().plan(TRAP)
    assert not none.caught and retime(none, TRAP, 1.0) is none


@pytest.mark.parametrize("most", [0.0, -1.0, np.nan, np.inf])
def test_a_limit_that_is_none_is_refused(most):
    with pytest.raises(SituationError, match="max_acceleration"):
        retime(StraightPlanner().plan(FREE), FREE, most)
