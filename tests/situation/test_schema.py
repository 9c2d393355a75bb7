"""JSON Schemas of the formats: what is read is valid, and bad documents are refused by both."""

import json

import jsonschema
import pytest
from hypothesis import given

from gcm_learn import situation as records
from gcm_learn.errors import SituationError
from tests import strategies
from tests.situation.scenes import REFUSED, SCENES, changed

VALIDATORS = {
    name: jsonschema.Draft202012Validator(schema) for name, schema in records.schemas().items()
}
BEYOND = [
    "reach", "clockwise", "cross", "must be orthogonal", "have length", "already the name",
    "required where a file holds several", "outside its range", "away from", "come after",
    "must be 0 ", "too soon", "half a turn", "move the hand", "is missing, but", "is above",
    "is no link", "from 0 to 2", "with itself", "not the name of", "are given without",
    "is too fast", "one entry for each", "cannot be read", "not known",
    "must be a list of 2 numbers (got 1)", "finite", "is given without max", "needs limits",
    " is no vertex", "must be an index", '" is for obstacles', " is too large (max",
    "no hand can", "must be a list of 1 numbers",
]  # fmt: skip
"""Reasons of refusals that no schema can tell."""


def valid(obj):
    """Whether a JSON value keeps the schema of its format."""
    return VALIDATORS[obj["format"]].is_valid(json.loads(json.dumps(obj)))


def test_schemas_are_schemas():
    named = [*(f"situation@{version}" for version in (1, 2, 3, 4)), "arm@1", "arm@2"]
    assert list(VALIDATORS) == [f"gcm-learn/{name}" for name in named]
    for schema in records.schemas().values():
        jsonschema.Draft202012Validator.check_schema(schema)


@given(strategies.any_situations())
def test_written_situations_are_valid(situation):
    VALIDATORS[situation.format].validate(
        json.loads(json.dumps(records.situation_to_json(situation)))
    )


@pytest.mark.parametrize("name", records.arm_names())
def test_shipped_arms_are_valid(name):
    VALIDATORS["gcm-learn/arm@1"].validate(records.arm_to_json(records.shipped_arm(name)))


TELLABLE = [
    case
    for case in REFUSED
    if case[1] != ["format"] and not any(word in case[2] for word in BEYOND)
]


def test_most_refusals_can_be_told_by_a_schema():
    assert len(TELLABLE) > 120


@pytest.mark.parametrize(
    ("name", "path", "value"),
    [
        pytest.param(*case[:2], case[3:], id=f"{k} {'.'.join(map(str, case[1]))[:40]}")
        for k, case in enumerate(TELLABLE)
    ],
)
def test_bad_documents_are_refused_by_both(name, path, value):
    scene = SCENES[name]
    bad = changed(scene, path, *value)
    assert valid(scene)
    assert not valid(bad)
    with pytest.raises(SituationError):
        (records.arm_from_json if name == "model" else records.situation_from_json)(bad)
