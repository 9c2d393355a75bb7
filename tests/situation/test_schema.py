"""JSON Schemas of the formats: what is read is valid, and bad documents are refused by both."""

from __future__ import annotations

import json

import jsonschema
import pytest
from hypothesis import given, settings

from gcm_learn.errors import SituationError
from gcm_learn.situation import (
    arm_from_json,
    arm_names,
    arm_to_json,
    schemas,
    shipped_arm,
    situation_from_json,
    situation_to_json,
)
from tests import strategies
from tests.situation import test_json_format as first
from tests.situation import test_third_version as third

VALIDATORS = {name: jsonschema.Draft202012Validator(schema) for name, schema in schemas().items()}
BEYOND = (
    "reach",
    "clockwise",
    "cross",
    "must be orthogonal",
    "must have length",
    "already the name",
    "required where a file holds several",
    "outside its range",
    "away from",
    "come after",
    "must be 0 ",
    "too soon",
    "half a turn",
    "move the hand",
    "is missing, but",
    "is above",
    "is no link",
    "from 0 to 2",
    "with itself",
    "not the name of",
    "without max_acceleration",
    "one entry for each",
    "cannot be read",
    "not known",
    "must be a list of 2 numbers (got 1)",
    "finite",
)
"""Reasons of refusals that no schema can tell."""


def valid(obj):
    """Whether a JSON value keeps the schema of its format."""
    return VALIDATORS[obj["format"]].is_valid(json.loads(json.dumps(obj)))


def test_schemas_are_schemas():
    assert list(VALIDATORS) == [
        "gcm-learn/situation@1",
        "gcm-learn/situation@2",
        "gcm-learn/situation@3",
        "gcm-learn/arm@1",
    ]
    for schema in schemas().values():
        jsonschema.Draft202012Validator.check_schema(schema)


@settings(max_examples=200)
@given(strategies.any_situations())
def test_written_situations_are_valid(situation):
    VALIDATORS[situation.format].validate(json.loads(json.dumps(situation_to_json(situation))))


@pytest.mark.parametrize("name", arm_names())
def test_shipped_arms_are_valid(name):
    VALIDATORS["gcm-learn/arm@1"].validate(arm_to_json(shipped_arm(name)))


REFUSED = [
    *((scene, path, value, reason) for scene, path, value, reason in first.REFUSED),
    *((third.CHAIN, path, value, reason or "joints") for path, value, reason in third.REFUSED),
    *((third.MODEL, path, value, reason) for path, value, reason in third.MODEL_REFUSED),
]
TELLABLE = [
    case
    for case in REFUSED
    if case[1] != ("format",) and not any(word in case[3] for word in BEYOND)
]


def test_most_refusals_can_be_told_by_a_schema():
    assert len(TELLABLE) > 70


@pytest.mark.parametrize(
    ("scene", "path", "value"),
    [
        pytest.param(*case[:3], id=f"{k} {'.'.join(map(str, case[1]))[:40]}")
        for k, case in enumerate(TELLABLE)
    ],
)
def test_bad_documents_are_refused_by_both(scene, path, value):
    gone = value is first.GONE or value is third.GONE
    bad = first.changed(scene, path, first.GONE if gone else value)
    assert valid(scene)
    assert not valid(bad)
    with pytest.raises(SituationError):
        (arm_from_json if scene is third.MODEL else situation_from_json)(bad)
