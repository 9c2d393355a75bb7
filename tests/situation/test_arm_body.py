"""Bodies of arms: what is read is what was written, and what makes no sense is refused by name."""

from __future__ import annotations

import json
from copy import deepcopy
from dataclasses import replace

import pytest

from gcm_learn.arms import Chain
from gcm_learn.errors import FileFormatError, SituationError
from gcm_learn.execution import shipped_bodies
from gcm_learn.families import paper_scene
from gcm_learn.situation import arm_body_from_json, arm_body_to_json, read_arm_body, shipped_arm

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


def spoilt(*path, value, good=GOOD):
    """A good body with one value replaced, or removed where that is None."""
    made = place = deepcopy(good)
    for key in path[:-1]:
        place = place[key]
    if value is None:
        del place[path[-1]]
    else:
        place[path[-1]] = value
    return made


@pytest.mark.parametrize(
    ("made", "field"),
    [
        (spoilt("format", value="gcm-learn/body@9"), "format"),
        (spoilt("format", value="gcm-learn/body@2"), "bones"),
        (spoilt("frames", value=CHAIN["frames"][:2], good=CHAIN), "frames"),
        (spoilt("frames", value=None, good=CHAIN), "frames"),
        (spoilt("bones", value=[], good=CHAIN), "bones"),
        (spoilt("joints", value=[], good=CHAIN), "joints"),
        (spoilt("metres", value=-1.0, good=CHAIN), "metres"),
        (spoilt("gravity", 2, value="down", good=CHAIN), "gravity[2]"),
        (spoilt("frames", 1, "mass", value=-1.0, good=CHAIN), "frames[1].mass"),
        (spoilt("frames", 1, "mass", value=None, good=CHAIN), "frames[1].mass"),
        (spoilt("frames", 2, value=CHAIN["frames"][0], good=CHAIN), "frames[2].mass"),
        (spoilt("frames", 1, "centre", value=[0.0], good=CHAIN), "frames[1].centre"),
        (spoilt("frames", 1, "inertia", value=[1, 1, 1], good=CHAIN), "frames[1].inertia[0]"),
        (spoilt("frames", 1, "inertia", value=[[1] * 3], good=CHAIN), "frames[1].inertia"),
        (spoilt("frames", 1, "inertia", 0, 0, value=1.0, good=CHAIN), "frames[1].inertia"),
        (spoilt("frames", 1, "inertia", 0, 0, value=-1.0, good=CHAIN), "frames[1].inertia"),
        (spoilt("frames", 1, "inertia", 0, 2, value=0.1, good=CHAIN), "frames[1].inertia[0][2]"),
        (spoilt("frames", 1, "inertia", 1, 1, value=1e999, good=CHAIN), "frames[1].inertia[1][1]"),
        (spoilt("frames", 1, "rotor", value=1.0, good=CHAIN), "frames[1].rotor"),
        (spoilt("joints", 0, "torque", value=-1.0, good=CHAIN), "joints[0].torque"),
        (spoilt("joints", 1, "torque", value=None, good=CHAIN), "joints[1].torque"),
        (spoilt("joints", 0, "damping", value=[], good=CHAIN), "joints[0].damping"),
        (spoilt("metres", value=0.0), "metres"),
        (spoilt("gravity", value=[0.0, 0.0]), "gravity"),
        (spoilt("bones", value=GOOD["bones"][:1]), "bones"),
        (spoilt("joints", value={}), "joints"),
        (spoilt("bones", 1, "mass", value=-1.0), "bones[1].mass"),
        (spoilt("bones", 0, "inertia", value=[1.0, 1.0, 3.0]), "bones[0].inertia"),
        (spoilt("joints", 2, "torque", value=0), "joints[2].torque"),
        (spoilt("joints", 3, "torque", value=None), "joints[3].torque"),
        (spoilt("joints", 0, "damping", value=float("nan")), "joints[0].damping"),
        (spoilt("joints", 0, "gear", value=3.0), "joints[0].gear"),
        (spoilt("weight", value=3.0), "weight"),
    ],
)
def test_what_makes_no_sense_is_refused_by_name(made, field):
    with pytest.raises(SituationError) as told:
        arm_body_from_json(made)
    assert told.value.field == field
    assert "\n" not in str(told.value)


def test_a_file_is_named_with_the_line(tmp_path):
    file = tmp_path / "body.json"
    file.write_text(json.dumps(spoilt("joints", 1, "torque", value=-2.0), indent=1))
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
