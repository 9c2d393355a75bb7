"""Scenes given frame by frame."""

import json

import numpy as np
import pytest

from gcm_learn.arms import hands_along
from gcm_learn.errors import FileFormatError
from gcm_learn.outside import SiRrt
from gcm_learn.outside.si_rrt import KEPT, thinned
from gcm_learn.situation import arm_to_json, shipped_arm, situation_to_json
from tests.geometry import poses
from tests.outside.conftest import DATA
from tests.refusals import refusal


def converted(path, **settings):
    (situation,) = SiRrt(**settings).convert([path]).situations
    return situation


def test_a_scene_becomes_a_situation(flying):
    situation = converted(flying())
    given = json.loads((DATA / "flying.json").read_text())
    assert situation.horizon == pytest.approx(61 / 30)
    assert list(situation.arm.joints) == given["start_configuration"]
    assert [link.radius for link in situation.arm.model.links] == given["robot_capsules_radius"]
    assert situation.arm.max_joint_speed == (3.0,) * 6
    (hand,), (axis,) = hands_along(situation.arm, [given["end_configuration"]])
    (target,) = situation.targets
    np.testing.assert_allclose(target.motion.position, hand, atol=1e-12)
    np.testing.assert_allclose(target.approach[0].axis, axis, atol=1e-9)
    kinds = {body.name: body.motion.kind for body in situation.obstacles}
    assert kinds == {
        "stand": "quadratic", "slider": "sampled", "lid": "sampled", "still": "quadratic",
        "ball": "quadratic",
    }  # fmt: skip


def test_scenes_are_called_after_their_files(flying):
    names = [s.name for s in SiRrt().convert([flying(), flying()]).situations]
    assert names == ["flying", "flying-2"]


def test_few_samples_are_kept_and_they_say_the_same(flying):
    """A straight slide and its rest need two samples, a steady turn few."""
    situation = converted(flying())
    laws = {body["name"]: body for body in situation_to_json(situation)["bodies"]}
    assert len(laws["slider"]["motion"]["times"]) <= 3
    assert len(laws["lid"]["motion"]["times"]) == 2
    for body in json.loads((DATA / "flying.json").read_text())["obstacles"]:
        times = np.arange(len(body["positions"])) / 30.0
        centre, turn = poses(laws[body["name"]], times)
        rows = np.array(body["positions"])
        np.testing.assert_allclose(
            np.broadcast_to(centre, rows[:, :3].shape), rows[:, :3], atol=KEPT
        )
        x, y, z, w = rows[:, 3:].T
        first = np.stack(
            [1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)], axis=1
        )
        turned = np.broadcast_to(turn, (len(rows), 3, 3))[:, :, 0]
        np.testing.assert_allclose(turned, first, atol=4 * KEPT)


@pytest.mark.parametrize("seed", range(5))
def test_what_is_left_out_follows_from_what_is_kept(seed):
    rng = np.random.default_rng(seed)
    knots = np.cumsum(rng.integers(1, 30, 8))
    times = np.arange(knots[-1] + 1)
    places = np.stack([np.interp(times, knots, rng.normal(size=8)) for _ in range(3)], axis=1)
    turns = np.tile([1.0, 0.0, 0.0, 0.0], (len(times), 1))
    kept = thinned(places, turns)
    again = np.stack([np.interp(times, kept, places[kept, j]) for j in range(3)], axis=1)
    assert np.abs(again - places).max() <= KEPT and len(kept) <= 2 * len(knots)


def test_a_named_arm_keeps_its_radii(flying, tmp_path):
    arm = tmp_path / "mine.json"
    arm.write_text(json.dumps(arm_to_json(shipped_arm("xarm6"))))
    situation = converted(flying(), arm=str(arm))
    assert situation.arm.model.links == shipped_arm("xarm6").links
    assert situation.arm.max_joint_speed == (3.0,) * 6


def test_scenes_without_speeds_and_radii_have_those_of_the_arm(flying):
    def older(scene):
        del scene["robot_joint_max_velocity"], scene["robot_capsules_radius"]

    assert converted(flying(older)).arm.model == shipped_arm("xarm6")


def test_joints_are_found_by_name(flying):
    def swap(scene):
        for name in ("robot_joints_order", "start_configuration", "end_configuration"):
            scene[name] = scene[name][::-1]

    assert converted(flying(swap)) == converted(flying())


def changed(*path, to):
    """Return a function that changes one member of a scene."""

    def change(scene):
        for step in path[:-1]:
            scene = scene[step]
        scene[path[-1]] = to

    return change


REFUSED = [
    (("obstacles", 0, "type"), "dynamic_robot", 'obstacles[0].type: "dynamic_robot" is not under'),
    (("obstacles", 0, "dimensions"), [1, 1], "dimensions: must be a list of 3 numbers"),
    (("obstacles", 0, "dimensions"), [1, 1, 0], "dimensions: half_extents[2]: must be"),
    (("obstacles", 0, "name"), "lid", 'obstacles[2].name: "lid" is given twice'),
    (("obstacles", 0, "colour"), 1, "obstacles[0].colour: is not a known field"),
    (("obstacles", 1, "positions"), [], "obstacles[1].positions: must not be empty"),
    (("obstacles", 1, "positions", 3), [1, 2], "positions[3]: must be a list of 7 numbers"),
    (("obstacles", 1, "positions", 3, 6), 3, "positions[3][3:7]: must be a quaternion of length"),
    (("start_configuration",), [0.0] * 5, "start_configuration: must be a list of 6 numbers"),
    (("start_configuration",), [0, 9, 0, 0, 0, 0], "posture[1]: 9"),
    (("end_configuration", 2), "x", "end_configuration[2]: must be a number"),
    (("robot_joints_order", 0), "j", "robot_joints_order: must be the joints of"),
    (("robot_joint_max_velocity", 0), 0, "max_speed: must be positive"),
    (("robot_capsules_radius",), [0.1], "robot_capsules_radius: must be a list of 6 numbers"),
    (("fps",), 0, "fps: must be positive"),
    (("robots",), [], "robots: is not a known field"),
    (("start_time",), 2, "start_time: must be 0"),
]


@pytest.mark.parametrize(("path", "to", "message"), REFUSED)
def test_what_is_not_understood_is_refused_in_one_line(path, to, message, flying):
    given = flying(changed(*path, to=to))
    said = refusal(FileFormatError, converted, given)
    assert str(given) in said and message in said
