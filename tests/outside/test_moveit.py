"""Planning scenes and requests of MoveIt, at rest and in motion."""

import sys
import tarfile
from dataclasses import replace

import numpy as np
import pytest

from gcm_learn.arms import hands_along, rotation_of
from gcm_learn.errors import FileFormatError, MissingExtraError
from gcm_learn.outside import MotionBenchMaker
from gcm_learn.outside.converted import goal_is_blocked, stays_free
from gcm_learn.outside.in_motion import Belt
from gcm_learn.situation import situation_to_json
from tests.geometry import poses
from tests.refusals import refusal

READY = (0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785)
GOAL = (1e-5, 0.1, 1e-5, -2.2, 0.0, 2.3, 0.785)


def converted(*sources, **settings):
    return MotionBenchMaker(**settings).convert(sources).situations


def body(situation, name):
    return next(b for b in situation.bodies if b.name == name)


def test_a_problem_becomes_a_situation(shelf):
    first, second = converted(shelf)
    assert (first.name, second.name) == ("shelf-0001", "shelf-0002")
    assert first.horizon == 6.0 and first.arm.joints == READY == second.arm.joints
    can, board = first.obstacles
    assert (can.shape.radius, can.shape.half_length) == (0.03, 0.07)
    assert board.shape.half_extents == (0.6, 0.2, 0.02)
    half = np.sqrt(0.5)
    np.testing.assert_allclose(board.motion.orientation, (half, 0, 0, half), atol=1e-9)


def test_the_target_rests_where_the_hand_is_in_the_goal_posture(shelf):
    first = converted(shelf, within=0.2)[0]
    (target,) = first.targets
    (hand,), (axis,) = hands_along(first.arm, [GOAL])
    np.testing.assert_allclose(target.motion.position, hand, atol=1e-12)
    np.testing.assert_allclose(target.approach[0].axis, axis, atol=1e-9)
    assert target.approach[0].within == 0.2


def test_poses_of_frames_objects_and_primitives_are_joined(shelf):
    """The frame is turned by a quarter about z, so the object's y is the world's -x."""
    posts = converted(shelf)[1].obstacles
    assert [b.name for b in posts] == ["posts/1", "posts/2", "posts/3"]
    places = [b.motion.position for b in posts]
    wanted = [(0.7, 0, 0.2), (0.7, 0.2, 0.3), (0.7, -0.2, 0.3)]
    np.testing.assert_allclose(places, wanted, atol=1e-12)
    for post in posts:
        turned = rotation_of(post.motion.orientation) @ (1.0, 0.0, 0.0)
        np.testing.assert_allclose(turned, (0, 1, 0), atol=1e-12)
    assert [b.shape.kind for b in posts] == ["box", "sphere", "cylinder"]


def test_an_archive_holds_the_same(shelf, tmp_path):
    archive = tmp_path / "problems.tar.bz2"
    with tarfile.open(archive, "w:bz2") as tar:
        tar.add(shelf, "problems/shelf")
    assert converted(archive) == converted(shelf)


def test_fingers_may_touch_what_they_grasp(shelf):
    """Without it the can around which the gripper closes would block every goal."""
    scene = shelf / "scene0001.yaml"
    (hand,), _ = hands_along(converted(shelf)[0].arm, [GOAL])
    at = f"[{hand[0]}, {hand[1]}, {hand[2] - 0.06}]"
    scene.write_text(scene.read_text().replace("[0.55, 0.0, 0.45]", at))
    scene.write_text(scene.read_text().replace("[0.6, 0.0, 0.36]", "[0.6, 0.0, -0.5]"))
    result = MotionBenchMaker().convert([shelf])
    grasping = result.situations[0]
    assert grasping.arm.ignore == ((7, "Can1"),)
    assert not goal_is_blocked(grasping, GOAL)
    assert goal_is_blocked(replace(grasping, arm=replace(grasping.arm, ignore=())), GOAL)
    assert list(result.notes()) == [
        "1 of 2: the fingers may touch the object that they grasp",
        "0 of 2: the start is blocked",
        "0 of 2: the goal posture is blocked",
    ]


def test_a_robot_elsewhere_takes_its_frame_along(shelf):
    """The can is given in the frame of the first link, the board in that of the world."""
    scene = shelf / "scene0001.yaml"
    (hand,), _ = hands_along(converted(shelf)[0].arm, [GOAL])
    text = scene.read_text()
    text = text.replace("{translation: [0, 0, 0]", "{translation: [0.3, 0.1, 0.2]", 1)
    text = text.replace("id: Can1", "header: {frame_id: panda_link0}\n      id: Can1")
    text = text.replace("[0.55, 0.0, 0.45]", f"[{hand[0]}, {hand[1]}, {hand[2] - 0.06}]")
    scene.write_text(text)
    moved = converted(shelf)[0]
    assert moved.arm.base.origin == (0.3, 0.1, 0.2) and moved.arm.ignore == ((7, "Can1"),)
    shift = np.array(moved.targets[0].motion.position) - hand
    np.testing.assert_allclose(shift, (0.3, 0.1, 0.2), atol=1e-12)
    assert body(moved, "shelf").motion.position == (0.6, 0.0, 0.36)


def test_blocked_starts_and_goals_are_counted_and_kept(shelf):
    scene = shelf / "scene0002.yaml"
    scene.write_text(scene.read_text().replace("y: -0.6, z: 0.2", "y: -0.2, z: 0.45"))
    result = MotionBenchMaker().convert([shelf])
    assert len(result.situations) == 2 and "1 of 2: the start is blocked" in list(result.notes())


@pytest.mark.parametrize("seed", range(4))
def test_scenes_in_motion_are_those_of_the_file_at_one_time(seed, shelf):
    """The target is then at its original place, and the start stays free until the horizon."""
    still, moving = converted(shelf), converted(shelf, moving=seed)
    assert moving == converted(shelf, moving=seed)
    for before, after in zip(still, moving, strict=True):
        assert stays_free(after)
        assert len(before.bodies) + 2 <= len(after.bodies) <= len(before.bodies) + 4
        times = np.linspace(0.0, after.horizon, 4001)
        law = next(b for b in situation_to_json(after)["bodies"] if b["role"] == "target")
        centre, turn = poses(law, times)
        away = np.linalg.norm(centre - before.targets[0].motion.position, axis=1)
        k = int(np.argmin(away))
        assert away[k] < 2e-3 and away.max() > 0.02
        np.testing.assert_allclose(turn[k], np.eye(3), atol=5e-3)


def test_another_seed_is_another_scene_and_order_does_not_matter(shelf, tmp_path):
    assert converted(shelf, moving=1)[0] != converted(shelf, moving=2)[0]
    second = converted(shelf, moving=1)[1]
    (shelf / "scene0001.yaml").unlink()
    (shelf / "request0001.yaml").unlink()
    assert converted(shelf, moving=1) == [second]


@pytest.mark.parametrize("seed", range(5))
def test_a_belt_stays_within_its_stroke(seed, shelf):
    belt = Belt(np.random.default_rng(seed), 2.3, 6.0)
    at = converted(shelf)[0].obstacles[0].motion
    law = belt.motion(at)
    starts = [piece.start for piece in law.pieces]
    assert starts[0] == 0.0 and all(np.diff(starts) > 0.0) and starts[-1] < 6.0
    speeds = {round(float(np.linalg.norm(p.motion.velocity)), 9) for p in law.pieces}
    assert len(speeds) == 1
    middle = law.at(2.3)
    there = np.array(middle.motion.position) + (2.3 - middle.start) * np.array(
        middle.motion.velocity
    )
    np.testing.assert_allclose(there, at.position, atol=1e-8)


EXTRA = "joint_constraints:\n      - {joint_name: e, position: 0}"
REFUSED = [
    ("scene0001", "type: cylinder", "type: cone", 'primitives[0].type: "cone" is not understood'),
    ("scene0002", "{type: 1,", "{type: 4,", 'primitives[0].type: "cone" is not understood'),
    ("scene0002", "meshes: []", "meshes: [{vertices: []}]", "mesh_poses: has 0 entries for 1"),
    ("scene0002", "planes: []", "planes: [{coef: [0, 0, 1, 0]}]", "[0].planes: planes are not"),
    ("scene0002", "data: []", "data: [1, 2]", "world.octomap: octomaps are not understood"),
    ("scene0002", "operation: 0", "operation: 1", "operation: must be 0"),
    ("scene0002", "0, frame_id: bench", "0, frame_id: cup", 'the pose of "cup" is not known'),
    ("scene0002", "attached_collision_objects: []", "attached_collision_objects: [{}]", "holds"),
    ("scene0001", "dimensions: [0.14, 0.03]", "dimensions: [0.14]", "a list of 2 numbers (got 1)"),
    ("scene0001", "dimensions: [0.14, 0.03]", "dimensions: [0.14, 0]", "must be positive"),
    ("scene0001", "id: Can1", "id: shelf", 'collision_objects[1].id: "shelf" is given twice'),
    ("scene0001", "id: Can1", "idd: Can1", "collision_objects[0].id: is missing"),
    ("scene0001", "id: Can1", "colour: red\n      id: Can1", "colour: is not a known field"),
    ("scene0001", "[0, 0, 0.0, 1]", "[0, 0, 0.5, 1]", "must be a quaternion of length 1"),
    ("scene0001", "[0.55, 0.0, 0.45]", "[0.55, .nan, 0.45]", "position[1]: must be finite"),
    ("scene0001", "[0.55, 0.0, 0.45]", "[0.55, here, 0.45]", "position[1]: must be a number"),
    ("scene0001", "_name: panda", "_name: ur9", 'robot_model_name: "ur9" is not the name of'),
    ("scene0001", "world:", "world: [", "scene0001.yaml:"),
    ("request0001", "panda_joint7, ", "panda_joint8, ", 'no value for joint "joint7"'),
    ("request0001", "{joint_name: panda_joint7", "{joint_name: panda_joint8", "joint7"),
    ("request0001", "joint_constraints:", EXTRA,
     '"e" is no joint of the arm "panda"'),
    ("request0001", "-2.356, 0,", "2.356, 0,", "posture[3]: 2.356 is outside its range"),
    ("request0002", "position_constraints: []\n    ori", "position_constraints: [{}]\n    ori",
     "position_constraints: only joint_constraints are understood"),
    ("request0002", 'joint_constraints: [], pos', 'joint_constraints: [{}], pos',
     "path_constraints: is not understood"),
    ("request0002", "reference_", "other_", "other_trajectories: is not a known field"),
]  # fmt: skip


@pytest.mark.parametrize(("file", "old", "new", "message"), REFUSED)
def test_what_is_not_understood_is_refused_in_one_line(file, old, new, message, shelf):
    path = shelf / f"{file}.yaml"
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, new, 1))
    result = MotionBenchMaker().convert([shelf])
    (reason,) = map(str, result.left_out)
    assert str(path) in reason and message in reason and "\n" not in reason
    assert len(result.situations) == 1


def test_scenes_and_requests_come_in_pairs(shelf):
    (shelf / "request0002.yaml").unlink()
    (reason,) = map(str, MotionBenchMaker().convert([shelf]).left_out)
    assert "scene0002.yaml: there is no request of that" in reason
    (shelf / "scene0002.yaml").unlink()
    result = MotionBenchMaker().convert([shelf, shelf])
    assert "there is another problem" in str(result.left_out[0]) and len(result.situations) == 1


def test_sources_that_are_none_are_refused(shelf, tmp_path):
    for source in (tmp_path / "missing", tmp_path / "empty", shelf / "scene0001.yaml"):
        if source.name == "empty":
            source.mkdir()
        with pytest.raises(FileFormatError, match=source.name):
            converted(source)


def test_a_missing_library_is_named(shelf, monkeypatch):
    monkeypatch.setitem(sys.modules, "yaml", None)
    said = refusal(MissingExtraError, converted, shelf)
    assert "needs pyyaml: pip install 'gcm_learn[outside]'" in said
