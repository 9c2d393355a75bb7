"""Thinking that is charged, inexact percepts, and times with units."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import families
from gcm_learn.evaluation import Condition, after, ask
from tests.evaluation.worlds import moving, scene, slow_straight
from tests.motion.test_joint_verification import ARM, ball, situation

STILL = moving("target", (1.2, 0.5), (0.0, 0.0))


def test_a_resting_hand_may_be_touched_or_come_upon():
    rock = moving("obstacle", (1.5, 1.0), (0.0, -2.0))
    assert after(scene(STILL, rock), 0.3).horizon == pytest.approx(0.7)
    assert after(scene(STILL, rock), 0.6) == "touched"
    coming = moving("target", (1.5, 1.0), (0.0, -2.0))
    assert after(scene(coming), 0.6) == "caught"
    assert after(scene(STILL), 1.0) == after(scene(STILL), 2.0) == "late"
    assert after(scene(STILL), 0.0) == scene(STILL)


def test_an_arm_at_rest_in_space():
    still = situation()
    assert after(still, 0.3).arm.joints == still.arm.joints
    bullet = ball("bullet", "obstacle", (1.0, 0.0, -5.0), (0.0, 0.0, 20.0), 0.1)
    assert not isinstance(after(situation(obstacles=(bullet,)), 0.2), str)
    assert after(situation(obstacles=(bullet,)), 0.3) == "touched"
    coming = replace(still, bodies=(ball("t", "target", (1.9, 0.4, -5.0), (0.0, 0.0, 10.0), 0.3),))
    assert after(coming, 0.6) == "caught"


def test_joints_that_turn_turn_on():
    limited = replace(ARM, max_joint_acceleration=(99.0,) * 4, joint_rates=(0.1, 0.0, 0.0, 0.0))
    moved = after(situation(limited), 0.2)
    assert moved.arm.joint_rates == pytest.approx(limited.joint_rates)
    assert moved.arm.joints == pytest.approx(np.array(ARM.joints) + (0.02, 0.0, 0.0, 0.0))
    _, high = limited.joint_range[0]
    room = (high - limited.joints[0]) / 0.1
    assert room < 1e3
    long = replace(situation(limited), horizon=2.0 * room)
    assert after(long, 1.01 * room) == "touched", "a joint comes to the end of its range"


def test_targets_that_come_to_a_resting_hand_are_gone_where_several_are_wanted():
    still = situation()
    coming = ball("coming", "target", (1.9, 0.4, -5.0), (0.0, 0.0, 10.0), 0.3)
    both = replace(
        still, bodies=(*still.bodies, coming), catch="most", format="gcm-learn/situation@3"
    )
    left = after(both, 0.6)
    assert [target.name for target in left.targets] == [still.targets[0].name]
    sheet = ask(["straight"], both, [Condition(0.6)])
    assert sheet["outcome"].tolist() == ["caught"] and sheet["targets"].tolist() == [2]


def test_thinking_is_charged_as_the_clock_says():
    passing = moving("target", (1.2, 0.2), (4.0, 0.0))
    cases = [
        scene(STILL, name="stays"), scene(passing, name="passes"),
        scene(STILL, name="ends", horizon=0.029),
    ]  # fmt: skip
    sheet = ask([slow_straight, "straight"], cases, [Condition("own"), Condition(0.2), Condition()])
    slow = sheet.where(entrant="slow_straight", thinking="own")
    assert slow["charged"].min() >= 0.03 and slow["outcome"][2] == "late"
    straight = sheet.where(entrant="straight")
    assert straight.where(thinking="0 ms")["outcome"].tolist()[:2] == ["caught", "caught"]
    assert straight.where(thinking="200 ms")["outcome"].tolist() == ["caught", "declined", "late"]
    own = straight.where(thinking="own")
    assert own["charged"].max() < 0.2 and own["outcome"][0] == "caught"


def test_inexact_percepts_cost_catches_and_are_judged():
    drawn = [families.draw("random-planar", 31, k) for k in range(6)]
    sheet = ask(["search"], drawn, [Condition(), Condition(noise=0.04)])
    exact, seen = (sheet.where(noise=noise) for noise in (0.0, 0.04))
    assert set(seen["outcome"]) <= {"caught", "touched", "late"}
    assert 0 < seen.caught.sum() <= exact.caught.sum()
    assert all(seen["solution"][seen.caught])
    again = ask(["search"], drawn, [Condition(noise=0.04)])
    assert again["outcome"].tolist() == seen["outcome"].tolist()
