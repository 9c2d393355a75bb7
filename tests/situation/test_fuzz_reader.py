"""Whatever a file holds: situations that hold what they promise, or one line that says why not."""

import json
import re
import tempfile
from pathlib import Path

import pytest
from hypothesis import given, settings, strategies as st

from gcm_learn.errors import FileFormatError
from gcm_learn.situation import read_situations, situation_from_json, situation_to_json
from tests import strategies

ONE_LINE = re.compile(r"scene\.jsonl?:[1-9]\d*: \S.*")
PATIENCE = 5000  # ms; nothing here should take more than a few

numbers = st.one_of(
    st.floats(), st.integers(), st.sampled_from([10**309, -(10**400), 1e308, 5e-324, -0.0, 2**1024])
)
words = st.sampled_from(
    ["disc", "box", "quadratic", "pendulum", "target", "left", "\ud800", "\n", "spatial"]
)
values = st.recursive(
    st.none() | st.booleans() | numbers | words | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=5) | st.dictionaries(words | st.text(max_size=5), inner),
    max_leaves=8,
)
snippets = st.sampled_from(
    [
        "{", "}", "[", "]", ",", ":", '"', "null", "NaN", "-Infinity", "1e999", "9" * 5000, "true",
        "\\ud800", "\n", "\x00", "\u2028", "\ufeff", '"kind":"disc",', '"spin":0,', '"base":{},',
        '"joint_rates":[0,0,0,0],', "[" * 5000,
    ]
)  # fmt: skip


def paths(value, path=()):
    """List the paths of everything inside a JSON object or list."""
    steps = value.items() if isinstance(value, dict) else enumerate(value)
    found = []
    for step, inner in steps:
        found.append((*path, step))
        if isinstance(inner, (dict, list)):
            found += paths(inner, (*path, step))
    return found


@st.composite
def spoiled_objects(draw):
    """Situations as JSON objects in which one to three things are replaced."""
    scene = situation_to_json(draw(strategies.any_situations(2)))
    for _ in range(draw(st.integers(1, 3))):
        *steps, last = draw(st.sampled_from(paths(scene)))
        parent = scene
        for step in steps:
            parent = parent[step]
        parent[last] = draw(values)
    return scene


@st.composite
def spoiled_texts(draw):
    """The text of a situation with a few pieces cut out, moved or put in."""
    text = json.dumps(situation_to_json(draw(strategies.any_situations(2))))
    for _ in range(draw(st.integers(1, 3))):
        start, stop, place = (draw(st.integers(0, len(text))) for _ in range(3))
        piece = draw(st.just("") | snippets | st.just(text[start : start + 30]))
        text = text[:place] + piece + text[place + (stop % 9) :]
    return text


@pytest.fixture(scope="module")
def folder():
    with tempfile.TemporaryDirectory() as name:
        yield Path(name)


def read(folder, name, content):
    """Read `content` as a file and check what comes out."""
    (folder / name).write_bytes(content)
    try:
        situations = read_situations(folder / name)
    except FileFormatError as error:
        message = str(error).removeprefix(str(folder) + "/")
        assert ONE_LINE.fullmatch(message)
        assert message.isprintable()
        assert len(message) < 700
        return
    assert situations
    for situation in situations:
        text = json.dumps(situation_to_json(situation), allow_nan=False)
        assert situation_from_json(json.loads(text)) == situation


@settings(deadline=PATIENCE)
@given(spoiled_objects(), st.sampled_from([None, 1]))
def test_any_value_in_any_field(folder, scene, indent):
    read(folder, "scene.json", json.dumps(scene, indent=indent).encode())
    read(folder, "scene.jsonl", json.dumps(scene).encode())


@settings(deadline=PATIENCE)
@given(spoiled_texts())
def test_damaged_text(folder, text):
    content = text.encode("utf-8", "surrogatepass")
    read(folder, "scene.json", content)
    read(folder, "scene.jsonl", content)


@settings(deadline=PATIENCE)
@given(st.binary(max_size=60), st.sampled_from(["scene.json", "scene.jsonl"]))
def test_any_bytes(folder, content, name):
    read(folder, name, content)


@given(values)
def test_any_value_instead_of_a_situation(folder, value):
    read(folder, "scene.json", json.dumps(value).encode())
