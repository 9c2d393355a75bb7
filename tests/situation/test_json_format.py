"""Files of situations: what is refused, on which line, in which words; round trips."""

from __future__ import annotations

import io
import json
import os
import sys

import pytest
from hypothesis import given, settings

from gcm_learn import artifacts
from gcm_learn.arms import Arm
from gcm_learn.errors import FileFormatError, SituationError
from gcm_learn.situation import (
    Body,
    Disc,
    Pendulum,
    PlanarQuadratic,
    Situation,
    read_situations,
    situation_from_json,
    situation_to_json,
    write_situations,
)
from tests import strategies
from tests.situation.scenes import GONE, PLANAR, REFUSED, SCENES, SOLID, changed, refusal


def test_files_of_suites_are_read():
    path = artifacts.shipped("data") / "suites" / "demo.jsonl"
    lines = [json.loads(line) for line in path.read_text().splitlines()]
    assert read_situations(path) == [situation_from_json(line["situation"]) for line in lines]


@pytest.fixture
def in_folder(tmp_path, monkeypatch):
    """Work in an empty folder, so that files have short names."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    ("scene", "path", "expected", "value"),
    [
        pytest.param(*case[:3], case[3:], id=f"{case[0]}-{k}")
        for k, case in enumerate(REFUSED)
        if case[0] != "model"
    ],
)
def test_refused_with_line_and_field(in_folder, scene, path, expected, value):
    good = json.dumps(changed(PLANAR, ("name",), "first"))
    bad = json.dumps(changed(SCENES[scene], path, *value))
    (in_folder / "scene.jsonl").write_text(f"{good}\n\n{bad}\n", encoding="utf-8")
    assert refusal("scene.jsonl") == f"scene.jsonl:3: {expected}"


def test_solid_scene_of_these_tests_is_good():
    situation = situation_from_json(SOLID)
    assert isinstance(situation.bodies[0].motion, Pendulum)
    assert situation.bodies[0].motion.hang_distance == 8.0


def test_name_may_be_absent_where_there_is_one_situation(in_folder):
    (in_folder / "one.json").write_text(json.dumps(changed(PLANAR, ("name",), GONE)))
    assert [s.name for s in read_situations("one.json")] == [""]


def test_example_of_the_contract_means_what_it_says():
    situation = situation_from_json(PLANAR)
    assert situation == Situation(
        name="ball-and-post",
        horizon=1.0,
        arm=Arm(hand=(1.1, -0.4), max_hand_speed=3.1),
        bodies=(
            Body(
                "target", "ball", Disc(0.08), PlanarQuadratic((1.6, 1.2), (-0.4, -0.6), (0.0, -1.5))
            ),
            situation.bodies[1],
        ),
    )
    assert situation.bodies[1].motion.angle == 0.3


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", "1: not valid JSON: nothing in it"),
        (" \n\n ", "1: not valid JSON: nothing in it"),
        (
            "{\n 'a': 1}",
            "2: not valid JSON: Expecting property name enclosed in double quotes (column 2)",
        ),
        ('{"format": 1', "1: not valid JSON: Expecting ',' delimiter (column 13)"),
        ("{}\n{}", "2: not valid JSON: Extra data (column 1)"),
        ('"a\nb"', "1: not valid JSON: Invalid control character at (column 3)"),
        ("[" * 100_000, "1: not valid JSON: nested too deeply"),
        ('{"a":' * 100_000, "1: not valid JSON: nested too deeply"),
        ("[]", "1: must be an object (got a list of 0)"),
        ("NaN", "1: must be an object (got nan)"),
        ("null", "1: must be an object (got null)"),
        ("9" * 5000, "1: must be an object (got inf)"),
        ('{"format": 1, "format": 1}', "1: format: is given twice"),
        ('{"a\\n": 1, "a\\n": 1}', '1: "a\\n": is given twice'),
    ],
)
def test_text_that_is_not_a_situation(in_folder, text, expected):
    (in_folder / "scene.json").write_text(text)
    assert refusal("scene.json") == f"scene.json:{expected}"


def test_repeated_fields_are_found_where_they_are(in_folder):
    text = json.dumps(PLANAR, indent=1)
    text = text.replace('"radius": 0.08', '"radius": 0.08,\n"radius": 0.1')
    (in_folder / "scene.json").write_text(text)
    line = text[: text.index('"radius"')].count("\n") + 1
    assert refusal("scene.json") == f"scene.json:{line}: bodies[0].shape.radius: is given twice"


@pytest.mark.parametrize(
    ("path", "value", "mark", "field"),
    [
        (("horizon",), 0, '"horizon"', "horizon"),
        (("bodies", 1, "motion", "spin"), "a", '"spin"', "bodies[1].motion.spin"),
        (("bodies", 1, "shape", "vertices", 1, 0), None, "null", "bodies[1].shape.vertices[1][0]"),
        # what is missing is reported on the line of what should hold it
        (("arm", "hand"), GONE, '"arm"', "arm.hand"),
    ],
)
def test_pretty_printed_file_gives_the_line_of_the_field(in_folder, path, value, mark, field):
    text = json.dumps(changed(PLANAR, path, value), indent=4)
    (in_folder / "scene.json").write_text(text)
    line = text[: text.rindex(mark)].count("\n") + 1
    assert refusal("scene.json").startswith(f"scene.json:{line}: {field}: ")


def test_line_is_counted_past_strings_that_look_like_fields(in_folder):
    bad = {"name": 'x"horizon": {[,', **changed(PLANAR, ("horizon",), -1)}
    bad["name"] = 'x"horizon": {[,\\"'
    text = json.dumps(bad, indent=0)
    (in_folder / "scene.json").write_text(text)
    line = text[: text.rindex('"horizon"')].count("\n") + 1
    assert refusal("scene.json") == f"scene.json:{line}: horizon: must be positive (got -1.0)"


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (b"", "scene.jsonl:1: no situation in the file"),
        (b"\n \r\n\t\n", "scene.jsonl:1: no situation in the file"),
        (b"\n{]\n", "scene.jsonl:2: not valid JSON: Expecting property name"),
        (b"\n\n\xff\n", "scene.jsonl:3: is not UTF-8 text (invalid start byte)"),
        (b"\xff\xfe{\x00}\x00", "scene.jsonl:1: is not UTF-8 text (invalid start byte)"),
        (b"\x00", "scene.jsonl:1: not valid JSON: Expecting value (column 1)"),
    ],
)
def test_lines_that_are_not_situations(in_folder, content, expected):
    (in_folder / "scene.jsonl").write_bytes(content)
    message = refusal("scene.jsonl")
    # the words of the json module differ a little between versions of Python
    assert message.split(": Expecting")[0] == expected.split(": Expecting")[0]


def test_names_are_unique_in_a_file(in_folder):
    line = json.dumps(PLANAR)
    (in_folder / "scene.jsonl").write_text(f"{line}\n\n{json.dumps(SOLID)}\n{line}\n")
    expected = 'scene.jsonl:4: name: "ball-and-post" is already the name in line 1'
    assert refusal("scene.jsonl") == expected


def test_files_that_cannot_be_read(in_folder):
    (in_folder / "folder.json").mkdir()
    assert refusal("none.json") == "none.json: cannot be read (No such file or directory)"
    assert refusal("folder.json") == "folder.json: cannot be read (Is a directory)"
    assert refusal("a\0b.json") == "a\\x00b.json: cannot be read (embedded null byte)"
    assert refusal("a\nb.json") == "a\\nb.json: cannot be read (No such file or directory)"
    assert refusal("x" * 300).endswith(": cannot be read (File name too long)")


def test_byte_order_mark_and_windows_line_ends_are_accepted(in_folder):
    lines = json.dumps(PLANAR) + "\r\n" + json.dumps(SOLID) + "\r\n"
    (in_folder / "scene.jsonl").write_bytes(b"\xef\xbb\xbf" + lines.encode())
    assert [s.name for s in read_situations("scene.jsonl")] == ["ball-and-post", "pendulum"]


def test_line_separators_inside_strings_do_not_end_a_line(in_folder):
    scene = changed(PLANAR, ("name",), "a\u2028b\x85c")
    (in_folder / "scene.jsonl").write_text(json.dumps(scene, ensure_ascii=False), encoding="utf-8")
    assert read_situations("scene.jsonl")[0].name == "a\u2028b\x85c"


class TestStandardInput:
    @pytest.fixture
    def feed(self, monkeypatch):
        def feed(text):
            stream = io.TextIOWrapper(io.BytesIO(text.encode()), encoding="utf-8")
            monkeypatch.setattr(sys, "stdin", stream)

        return feed

    def test_one_object_on_many_lines(self, feed):
        feed(json.dumps(PLANAR, indent=2))
        assert read_situations("-") == [situation_from_json(PLANAR)]

    def test_one_object_without_a_name(self, feed):
        feed("\n" + json.dumps(changed(PLANAR, ("name",), GONE)) + "\n")
        assert [s.name for s in read_situations("-")] == [""]

    def test_one_per_line(self, feed):
        feed(f"\n{json.dumps(PLANAR)}\n\n{json.dumps(SOLID)}\n")
        assert [s.name for s in read_situations("-")] == ["ball-and-post", "pendulum"]

    def test_error_in_one_object_is_on_its_line(self, feed):
        text = json.dumps(changed(PLANAR, ("horizon",), -1), indent=2)
        feed(text)
        line = text[: text.index('"horizon"')].count("\n") + 1
        assert refusal("-") == f"<stdin>:{line}: horizon: must be positive (got -1.0)"

    def test_error_in_a_line_is_on_that_line(self, feed):
        feed(f"{json.dumps(PLANAR)}\n{json.dumps(changed(SOLID, ('horizon',), -1))}\n")
        assert refusal("-") == "<stdin>:2: horizon: must be positive (got -1.0)"

    def test_broken_first_line(self, feed):
        feed(f"{{]\n{json.dumps(PLANAR)}\n")
        assert refusal("-").startswith("<stdin>:1: not valid JSON: ")

    def test_nothing(self, feed):
        feed("")
        assert refusal("-") == "<stdin>:1: not valid JSON: nothing in it"

    def test_a_stream_of_text(self, monkeypatch):
        monkeypatch.setattr(sys, "stdin", io.StringIO(json.dumps(PLANAR)))
        assert read_situations("-") == [situation_from_json(PLANAR)]


def test_other_file_names_may_hold_either(in_folder):
    (in_folder / "one").write_text(json.dumps(PLANAR, indent=1))
    (in_folder / "two.txt").write_text(f"{json.dumps(PLANAR)}\n{json.dumps(SOLID)}\n")
    assert len(read_situations("one")) == 1
    assert len(read_situations(in_folder / "two.txt")) == 2


def test_errors_without_a_file_name_the_field():
    with pytest.raises(SituationError) as caught:
        situation_from_json(changed(PLANAR, ("arm", "hand"), [0, 3]))
    assert caught.value.field == "arm.hand"
    assert str(caught.value) == "arm.hand: (0.0, 3.0) is out of reach (max 2.0)"


# --- round trips -----------------------------------------------------------------------------


@given(strategies.any_situations())
def test_json_round_trip_loses_nothing(situation):
    text = json.dumps(situation_to_json(situation), allow_nan=False)
    again = situation_from_json(json.loads(text))
    assert again == situation
    assert repr(again) == repr(situation)  # also tells -0.0 from 0.0


@settings(max_examples=10)
@given(strategies.solid_situations(1), strategies.planar_situations(1))
def test_file_round_trip(tmp_path_factory, first, second):
    folder = tmp_path_factory.mktemp("round")
    write_situations(folder / "one.json", [first])
    assert read_situations(folder / "one.json") == [first]
    if first.name != second.name:
        write_situations(str(folder / "two.jsonl"), [first, second])
        assert read_situations(folder / "two.jsonl") == [first, second]


def test_optional_fields_that_are_absent_stay_absent():
    written = situation_to_json(situation_from_json(PLANAR))
    assert "plane" not in written
    assert "max_joint_speed" not in written["arm"]
    assert "hang" not in situation_to_json(situation_from_json(SOLID))["bodies"][0]["motion"]


def test_writing_refuses_what_could_not_be_read_back(in_folder):
    situation = situation_from_json(PLANAR)
    with pytest.raises(FileFormatError) as caught:
        write_situations("two.json", [situation, situation])
    expected = "two.json: a .json file holds 1 situation (got 2), a .jsonl file many"
    assert str(caught.value) == expected
    with pytest.raises(FileFormatError) as caught:
        write_situations("two.jsonl", [situation, situation])
    expected = 'two.jsonl:2: name: "ball-and-post" is already the name in line 1'
    assert str(caught.value) == expected
    assert os.listdir() == []


def test_a_failed_write_leaves_the_old_file_and_no_other(in_folder, monkeypatch):
    write_situations("scene.json", [situation_from_json(PLANAR)])

    def fail(source, target):
        raise OSError("disk full")

    monkeypatch.setattr(os, "replace", fail)
    with pytest.raises(OSError, match="disk full"):
        write_situations("scene.json", [situation_from_json(SOLID)])
    assert os.listdir() == ["scene.json"]
    assert read_situations("scene.json")[0].name == "ball-and-post"
