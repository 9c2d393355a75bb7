"""Bodies of arms: what is read is what was written, and what makes no sense is refused by name."""

import json
import re
from dataclasses import replace

import pytest

from gcm_learn.arms import Chain
from gcm_learn.errors import FileFormatError, SituationError
from gcm_learn.execution import shipped_bodies
from gcm_learn.families import paper_scene
from gcm_learn.situation import arm_body_from_json, arm_body_to_json, read_arm_body, shipped_arm
from tests.situation.scenes import changed

GOOD = json.loads(shipped_bodies()["nao"].read_text("utf-8"))
LINK = {"mass": 1.0, "centre": [0.2, 0.0, 0.0]}
LINK["inertia"] = [[0.01, 0.0, 0.001], [0.0, 0.02, 0.0], [0.001, 0.0, 0.02]]
CHAIN = {
    "format": "gcm-learn/body@2", "name": "two", "metres": 0.5, "gravity": [0.0, 0.0, -9.81],
    "frames": [{"mass": 0, "centre": [0, 0, 0], "inertia": [[0] * 3] * 3}, LINK, LINK],
    "joints": [{"torque": 9.0, "armature": 0.1, "damping": 0.2}, {"torque": 0.0}],
}  # fmt: skip


@pytest.mark.parametrize("name", shipped_bodies())
def test_a_shipped_body_is_what_its_file_says(name):
    body, file = read_arm_body(shipped_bodies()[name]), shipped_bodies()[name]
    said = json.loads(file.read_text("utf-8"))
    assert body.name == said["name"] == name and body.metres == said["metres"]
    carried = "bones" if "bones" in said else "frames"
    assert [one.mass for one in getattr(body, carried)] == [one["mass"] for one in said[carried]]
    assert [motor.torque for motor in body.joints] == [motor["torque"] for motor in said["joints"]]


@pytest.mark.parametrize("good", [GOOD, CHAIN])
def test_a_written_body_is_read_again(good):
    body = arm_body_from_json(good)
    written = json.loads(json.dumps(arm_body_to_json(body)))
    assert arm_body_from_json(written) == body
    assert written["format"] == good["format"]


def spoilt(good, *path, value):
    """A good body with one value replaced, or removed where that is None."""
    return changed(good, path, *([] if value is None else [value]))


REFUSED = [
    (GOOD, "format", "gcm-learn/body@9"),
    (GOOD, "metres", 0.0),
    (GOOD, "gravity", [0.0, 0.0]),
    (GOOD, "bones", GOOD["bones"][:1]),
    (GOOD, "joints", {}),
    (GOOD, "bones[1].mass", -1.0),
    (GOOD, "bones[0].inertia", [1.0, 1.0, 3.0]),
    (GOOD, "joints[2].torque", 0),
    (GOOD, "joints[3].torque", None),
    (GOOD, "joints[0].damping", float("nan")),
    (GOOD, "joints[0].gear", 3.0),
    (GOOD, "weight", 3.0),
    (CHAIN, "frames", CHAIN["frames"][:2]),
    (CHAIN, "frames", None),
    (CHAIN, "bones", []),
    (CHAIN, "joints", []),
    (CHAIN, "metres", -1.0),
    (CHAIN, "gravity[2]", "down"),
    (CHAIN, "frames[1].mass", -1.0),
    (CHAIN, "frames[1].mass", None),
    (CHAIN, "frames[1].centre", [0.0]),
    (CHAIN, "frames[1].inertia", [[1] * 3]),
    (CHAIN, "frames[1].inertia[0][2]", 0.1),
    (CHAIN, "frames[1].inertia[1][1]", 1e999),
    (CHAIN, "frames[1].rotor", 1.0),
    (CHAIN, "joints[0].torque", -1.0),
    (CHAIN, "joints[1].torque", None),
    (CHAIN, "joints[0].damping", []),
]
ELSEWHERE = [
    (GOOD, "format", "gcm-learn/body@2", "bones"),
    (CHAIN, "frames[2]", CHAIN["frames"][0], "frames[2].mass"),
    (CHAIN, "frames[1].inertia", [1, 1, 1], "frames[1].inertia[0]"),
    (CHAIN, "frames[1].inertia[0][0]", 1.0, "frames[1].inertia"),
    (CHAIN, "frames[1].inertia[0][0]", -1.0, "frames[1].inertia"),
]
"""Changes that make another field than the changed one wrong, and its name."""


@pytest.mark.parametrize(
    ("good", "path", "value", "field"), [*((*case, case[1]) for case in REFUSED), *ELSEWHERE]
)
def test_what_makes_no_sense_is_refused_by_name(good, path, value, field):
    steps = [int(step) if step.isdigit() else step for step in re.findall(r"\w+", path)]
    with pytest.raises(SituationError) as told:
        arm_body_from_json(spoilt(good, *steps, value=value))
    assert told.value.field == field
    assert "\n" not in str(told.value)


def test_a_file_is_named_with_the_line(tmp_path):
    file = tmp_path / "body.json"
    file.write_text(json.dumps(spoilt(GOOD, "joints", 1, "torque", value=-2.0), indent=1))
    with pytest.raises(FileFormatError, match=r"body\.json:\d+: joints\[1\]\.torque: must not be"):
        read_arm_body(file)
    with pytest.raises(FileFormatError, match=r"missing\.json: cannot be read"):
        read_arm_body(tmp_path / "missing.json")


def test_a_body_fits_bones_of_its_length_only():
    arm = paper_scene("fig8-space").arm
    body = read_arm_body(shipped_bodies()["nao"])
    longer = [tuple(1.009 * x for x in arm.forearm), tuple(1.02 * x for x in arm.forearm)]
    assert body.misfit(arm) == ""
    assert body.misfit(replace(arm, forearm=longer[0])) == ""
    assert body.misfit(replace(arm, forearm=longer[1])).startswith("forearm: ")


def test_a_body_of_a_chain_fits_chains_of_as_many_joints():
    body = arm_body_from_json(CHAIN)
    assert body.misfit(chain("planar-2")) == ""
    assert body.misfit(chain("panda")) == "joints: the arm has 7, the body has 2"


def chain(name):
    """An arm that ships, every joint at the low end of its range."""
    model = shipped_arm(name)
    return Chain(model, tuple(joint.range[0] for joint in model.joints), 0.01)
