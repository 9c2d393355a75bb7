"""Stops after catches, and movements as CSV and as messages of ROS 2."""

from __future__ import annotations

import csv
import io
from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import artifacts, motion, solve
from gcm_learn.arms import Chain
from gcm_learn.errors import FieldError, StopError
from gcm_learn.families import draw, paper_scene
from gcm_learn.situation import (
    Body,
    Situation,
    SolidQuadratic,
    Sphere,
    read_situations,
    shipped_arm,
)

REST = (0.0, 0.0, 0.0)


def panda(*others: Body) -> Situation:
    """Return a Panda that catches a thrown ball."""
    posture = (0, -0.785, 0, -2.356, 0, 1.571, 0.785)
    throw = SolidQuadratic((1.2, 0.5, 0.4), (-0.8, -0.3, 2.5), (0, 0, -4.0))
    arm = Chain(shipped_arm("panda"), joints=posture, grasp=0.05)
    return Situation("panda", 1.5, arm, (Body("target", "ball", Sphere(0.04), throw), *others))


def limited(*others: Body) -> Situation:
    """Return a spatial arm with limits of acceleration that catches behind a post."""
    scene = draw("behind-post-space", 3, 3)
    limits = tuple(8.0 * speed for speed in scene.arm.max_joint_speed)
    arm = replace(scene.arm, max_joint_acceleration=limits)
    return replace(scene, arm=arm, bodies=(*scene.bodies, *others))


def _of_suite(name: str) -> Situation:
    path = artifacts.shipped("data") / "suites" / "demo.jsonl"
    return next(s for s in read_situations(path) if s.name == name)


CASES = {
    "planar": lambda: paper_scene("fig4"),
    "planar among solids": lambda: draw("gate-solid", 0, 0),
    "a target that leaves the plane": lambda: _of_suite("demo-39"),
    "spatial": lambda: draw("behind-post-space", 3, 3),
    "spatial with accelerations": limited,
    "chain": panda,
}


@pytest.fixture(params=CASES, scope="module")
def case(request):
    """Return a situation and its catch."""
    situation = CASES[request.param]()
    plan = solve(situation)
    assert plan.caught
    return situation, plan.trajectory


def test_a_stop_goes_on_as_the_catch_ends_and_rests(case):
    situation, moves = case
    made = motion.with_stop(situation, moves)
    n = len(moves.time)
    np.testing.assert_array_equal(made.time[:n], moves.time)
    np.testing.assert_array_equal(made.joints[:n], moves.joints)
    assert made.duration > moves.duration
    step = 1e-4
    before, after = (
        moves.joints_at(moves.duration) - moves.joints_at(moves.duration - step),
        made.joints_at(moves.duration + step) - made.joints_at(moves.duration),
    )
    np.testing.assert_allclose(after, before, atol=0.2 * np.abs(before).max() + 1e-7)
    last = np.abs(made.joints_at(made.duration) - made.joints_at(made.duration - step))
    assert last.max() <= 0.1 * np.abs(before).max()


def test_stops_keep_accelerations():
    situation = limited()
    made = motion.with_stop(situation, solve(situation).trajectory)
    most = np.array(situation.arm.max_joint_acceleration)
    _, _, forces = made.states_at(np.linspace(0.0, made.duration, 4000, endpoint=False))
    assert (np.abs(forces) <= most * (1 + 1e-6)).all()
    np.testing.assert_array_equal(made.rates[-1], 0.0)


def test_an_arm_with_limits_of_jerk_gets_no_stop():
    scene = limited()
    moves = solve(scene).trajectory
    jerk = tuple(50.0 * force for force in scene.arm.max_joint_acceleration)
    arm = replace(scene.arm, max_joint_jerk=jerk)
    with pytest.raises(StopError, match="limits of jerk need a plan that ends at rest"):
        motion.with_stop(replace(scene, arm=arm, format=""), moves)


def test_what_rests_needs_no_stop():
    situation = paper_scene("fig4")
    moves = solve(situation).trajectory
    resting = motion.Movement.of_hand(
        moves.arm,
        np.append(moves.time, moves.duration + 0.1),
        np.concatenate([moves.hand, moves.hand[-1:]]),
    )
    assert motion.with_stop(situation, resting) is resting


@pytest.mark.parametrize("made", [panda, limited])
def test_a_stop_into_an_obstacle_is_refused(made):
    """Balls on the hand's way behind the catch leave no room to brake."""
    situation = made()
    moves = solve(situation).trajectory
    free = motion.with_stop(situation, moves)
    places = free.hand_at(np.linspace(moves.duration, free.duration, 9)[1:])
    size = 0.4 * np.linalg.norm(places[0] - places[-1])
    walls = [
        Body("obstacle", f"wall {k}", Sphere(size), SolidQuadratic(tuple(place), REST, REST))
        for k, place in enumerate(places)
    ]
    with pytest.raises(StopError, match="the movement ends in motion, and no verified stop"):
        motion.with_stop(made(*walls), moves)


def test_csv_holds_the_samples(case):
    _, moves = case
    rows = list(csv.DictReader(io.StringIO(motion.to_csv(moves))))
    assert [float(row["time"]) for row in rows] == moves.time.tolist()
    names = list(rows[0])[1 : 1 + moves.joints.shape[1]]
    read = np.array([[float(row[name]) for name in names] for row in rows])
    np.testing.assert_array_equal(read, moves.joints)
    assert [float(row["hand_x"]) for row in rows] == moves.hand[:, 0].tolist()
    assert any(name.endswith("_velocity") for name in rows[0]) == (moves.rates is not None)


@pytest.mark.parametrize("rate", [None, 125.0, 900.0])
def test_rows_are_those_of_the_curve(case, rate):
    """Rates and accelerations are those of the piece that begins, at the end of the one before."""
    _, moves = case
    rows = list(csv.DictReader(io.StringIO(motion.to_csv(moves, rate=rate))))
    table = np.array([[float(value) for value in row.values()] for row in rows])
    time, n = table[:, 0], moves.joints.shape[1]
    hands = moves.hand if rate is None else moves.hand_at(time)
    np.testing.assert_allclose(table[:, -hands.shape[1] :], hands, atol=1e-12)
    if moves.rates is not None:
        states = moves.states_at(np.append(time[:-1], np.nextafter(time[-1], 0.0)))
        np.testing.assert_allclose(table[:, 1 : 1 + 3 * n], np.hstack(states), atol=1e-7)


@pytest.mark.parametrize(("rest", "rows"), [(0.0, 51), (1e-9, 51), (4e-6, 51), (1e-4, 52)])
def test_the_last_instant_is_the_last_row(rest, rows):
    moves = solve(limited()).trajectory
    time = np.array([0.0, 0.4 + rest])
    made = replace(moves, time=time, joints=moves.joints[:2], rates=moves.rates[:2])
    points = motion.to_joint_trajectory(made, rate=125.0)["points"]
    stamps = [point["time_from_start"]["nanosec"] for point in points]
    assert stamps == [*range(0, 8_000_000 * (rows - 1), 8_000_000), round(1e9 * time[-1])]


def test_messages_are_those_of_ros(case):
    yaml = pytest.importorskip("yaml")
    _, moves = case
    message = motion.to_joint_trajectory(moves)
    assert yaml.safe_load(motion.to_yaml(message)) == message
    assert motion.to_yaml(message).startswith("# A stamp of 0 means: start when received.")
    assert list(message) == ["header", "joint_names", "points"]
    assert message["header"] == {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""}
    fields = ["positions", "velocities", "accelerations", "effort", "time_from_start"]
    times = []
    for point in message["points"]:
        assert list(point) == fields
        assert len(point["positions"]) == len(message["joint_names"])
        assert len(point["velocities"]) in (0, len(message["joint_names"]))
        assert 0 <= point["time_from_start"]["nanosec"] < 10**9
        times.append(point["time_from_start"]["sec"] * 10**9 + point["time_from_start"]["nanosec"])
    assert times == sorted(set(times)) and times[-1] == round(moves.duration * 1e9)
    assert message["points"][-1]["positions"] == moves.joints[-1].tolist()


def test_seconds_and_nanoseconds_make_the_time():
    moves = replace(solve(panda()).trajectory)
    late = replace(moves, time=moves.time + np.where(moves.time > 0.0, 2.0, 0.0))
    stamp = motion.to_joint_trajectory(late)["points"][-1]["time_from_start"]
    assert stamp["sec"] == 2 and stamp["nanosec"] == round((late.duration - 2.0) * 1e9)


def test_joints_have_names():
    moves = solve(panda()).trajectory
    assert motion.to_joint_trajectory(moves)["joint_names"] == [
        j.name for j in moves.arm.model.joints
    ]
    names = [f"left_{k}" for k in range(7)]
    assert motion.to_joint_trajectory(moves, names)["joint_names"] == names
    assert motion.to_csv(moves, names).startswith("time,left_0,left_1")
    for wrong in (names[:6], ["a"] * 7):
        with pytest.raises(FieldError, match="names: must be 7 different names"):
            motion.to_joint_trajectory(moves, wrong)
