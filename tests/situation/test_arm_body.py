"""Bodies of arms: what is read is what was written, and what makes no sense is refused by name."""

from __future__ import annotations

import json
from copy import deepcopy
from dataclasses import replace

import pytest

from gcm_learn.errors import FileFormatError, SituationError
from gcm_learn.execution import shipped_bodies
from gcm_learn.families import paper_scene
from gcm_learn.situation import arm_body_from_json, read_arm_body

GOOD = json.loads(shipped_bodies()["nao"].read_text("utf-8"))


@pytest.mark.parametrize("name", shipped_bodies())
def test_a_shipped_body_is_what_its_file_says(name):
    body, file = read_arm_body(shipped_bodies()[name]), shipped_bodies()[name]
    said = json.loads(file.read_text("utf-8"))
    assert body.name == said["name"] == name and body.metres == said["metres"]
    assert [bone.mass for bone in body.bones] == [bone["mass"] for bone in said["bones"]]
    assert [motor.torque for motor in body.joints] == [motor["torque"] for motor in said["joints"]]


def spoilt(*path, value):
    """The good body with one value replaced, or removed where that is None."""
    made = place = deepcopy(GOOD)
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
        (spoilt("format", value="gcm-learn/body@2"), "format"),
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
    with pytest.raises(FileFormatError, match=r"body\.json:\d+: joints\[1\]\.torque: must be pos"):
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
