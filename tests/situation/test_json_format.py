"""Files of situations: what is refused, on which line, in which words; round trips."""

import io
import json
import os
import sys

import pytest
from hypothesis import given, settings

from gcm_learn import artifacts, situation as records
from gcm_learn.arms import Arm
from gcm_learn.errors import FileFormatError, SituationError
from tests import refusals, strategies
from tests.situation.scenes import GONE, PLANAR, REFUSED, SCENES, SOLID, changed, refusal


def test_files_of_suites_are_read():
    path = artifacts.shipped("data") / "suites" / "demo.jsonl"
    lines = [json.loads(line) for line in path.read_text().splitlines()]
    assert records.read_situations(path) == [
        records.situation_from_json(line["situation"]) for line in lines
    ]


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


def test_examples_mean_what_they_say():
    situation = records.situation_from_json(PLANAR)
    motion = records.PlanarQuadratic((1.6, 1.2), (-0.4, -0.6), (0.0, -1.5))
    bodies = (records.Body("target", "ball", records.Disc(0.08), motion), situation.bodies[1])
    arm = Arm(hand=(1.1, -0.4), max_hand_speed=3.1)
    assert situation == records.Situation("ball-and-post", 1.0, arm, bodies)
    assert situation.bodies[1].motion.angle == 0.3
    assert records.situation_from_json(SOLID).bodies[0].motion.hang_distance == 8.0


NO_JSON = [
    ("", "1", "nothing in it"),
    (" \n\n ", "1", "nothing in it"),
    ("{\n 'a': 1}", "2", "Expecting property name enclosed in double quotes (column 2)"),
    ('{"format": 1', "1", "Expecting ',' delimiter (column 13)"),
    ("{}\n{}", "2", "Extra data (column 1)"),
    ('"a\nb"', "1", "Invalid control character at (column 3)"),
    ("[" * 100_000, "1", "nested too deeply"),
    ('{"a":' * 100_000, "1", "nested too deeply"),
]
NO_SITUATION = [
    ("[]", "must be an object (got a list of 0)"),
    ("NaN", "must be an object (got nan)"),
    ("null", "must be an object (got null)"),
    ("9" * 5000, "must be an object (got inf)"),
    ('{"format": 1, "format": 1}', "format: is given twice"),
    ('{"a\\n": 1, "a\\n": 1}', '"a\\n": is given twice'),
]


def test_text_that_is_not_a_situation(in_folder):
    for text, line, reason in NO_JSON:
        (in_folder / "scene.json").write_text(text)
        assert refusal("scene.json") == f"scene.json:{line}: not valid JSON: {reason}"
    for text, reason in NO_SITUATION:
        (in_folder / "scene.json").write_text(text)
        assert refusal("scene.json") == f"scene.json:1: {reason}"


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
    bad = changed(PLANAR, ("horizon",), -1) | {"name": 'x"horizon": {[,\\"'}
    text = json.dumps(bad, indent=0)
    (in_folder / "scene.json").write_text(text)
    line = text[: text.rindex('"horizon"')].count("\n") + 1
    assert refusal("scene.json") == f"scene.json:{line}: horizon: must be positive (got -1.0)"


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        (b"", "1: no situation in the file"),
        (b"\n \r\n\t\n", "1: no situation in the file"),
        (b"\n{]\n", "2: not valid JSON: Expecting property name"),
        (b"\n\n\xff\n", "3: is not UTF-8 text (invalid start byte)"),
        (b"\xff\xfe{\x00}\x00", "1: is not UTF-8 text (invalid start byte)"),
        (b"\x00", "1: not valid JSON: Expecting value (column 1)"),
    ],
)
def test_lines_that_are_not_situations(in_folder, content, expected):
    (in_folder / "scene.jsonl").write_bytes(content)
    # the words of the json module differ a little between versions of Python
    message = refusal("scene.jsonl").split(": Expecting")[0]
    assert message == f"scene.jsonl:{expected}".split(": Expecting")[0]


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
    assert [s.name for s in records.read_situations("scene.jsonl")] == ["ball-and-post", "pendulum"]


def test_line_separators_inside_strings_do_not_end_a_line(in_folder):
    scene = changed(PLANAR, ("name",), "a\u2028b\x85c")
    (in_folder / "scene.jsonl").write_text(json.dumps(scene, ensure_ascii=False), encoding="utf-8")
    assert records.read_situations("scene.jsonl")[0].name == "a\u2028b\x85c"


def feed(monkeypatch, text):
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(text.encode())))


@pytest.mark.parametrize(
    ("text", "names"),
    [
        (json.dumps(PLANAR, indent=2), ["ball-and-post"]),
        (json.dumps(changed(PLANAR, ("name",), GONE)), [""]),
        (f"\n{json.dumps(PLANAR)}\n\n{json.dumps(SOLID)}\n", ["ball-and-post", "pendulum"]),
    ],
)
def test_files_and_standard_input_hold_one_object_or_one_in_each_line(
    in_folder, monkeypatch, text, names
):
    feed(monkeypatch, text)
    (in_folder / "one").write_text(text)
    read = records.read_situations("-")
    assert [situation.name for situation in read] == names
    assert read == records.read_situations("one")


def test_refusals_of_standard_input_name_the_line(monkeypatch):
    bad = json.dumps(changed(PLANAR, ("horizon",), -1), indent=2)
    line = bad[: bad.index('"horizon"')].count("\n") + 1
    other = json.dumps(changed(SOLID, ("horizon",), -1))
    for text, expected in (
        (bad, f"{line}: horizon: must be positive (got -1.0)"),
        (f"{json.dumps(PLANAR)}\n{other}\n", "2: horizon: must be positive (got -1.0)"),
        (f"{{]\n{json.dumps(PLANAR)}\n", "1: not valid JSON: Expecting property name"),
        ("", "1: not valid JSON: nothing in it"),
    ):
        feed(monkeypatch, text)
        assert refusal("-").startswith(f"<stdin>:{expected}")


def test_standard_input_may_be_a_stream_of_text(monkeypatch):
    monkeypatch.setattr(sys, "stdin", io.StringIO(json.dumps(PLANAR)))
    assert records.read_situations("-") == [records.situation_from_json(PLANAR)]


def test_errors_without_a_file_name_the_field():
    with pytest.raises(SituationError) as caught:
        records.situation_from_json(changed(PLANAR, ("arm", "hand"), [0, 3]))
    assert caught.value.field == "arm.hand"
    assert str(caught.value) == "arm.hand: (0.0, 3.0) is out of reach (max 2.0)"


@given(strategies.any_situations())
def test_json_round_trip_loses_nothing(situation):
    text = json.dumps(records.situation_to_json(situation), allow_nan=False)
    again = records.situation_from_json(json.loads(text))
    assert again == situation
    assert repr(again) == repr(situation)  # also tells -0.0 from 0.0


@settings(max_examples=10)
@given(strategies.solid_situations(1), strategies.planar_situations(1))
def test_file_round_trip(tmp_path_factory, first, second):
    folder = tmp_path_factory.mktemp("round")
    records.write_situations(folder / "one.json", [first])
    assert records.read_situations(folder / "one.json") == [first]
    if first.name != second.name:
        records.write_situations(str(folder / "two.jsonl"), [first, second])
        assert records.read_situations(folder / "two.jsonl") == [first, second]


def test_optional_fields_that_are_absent_stay_absent():
    written = records.situation_to_json(records.situation_from_json(PLANAR))
    assert "plane" not in written
    assert "max_joint_speed" not in written["arm"]
    assert (
        "hang"
        not in records.situation_to_json(records.situation_from_json(SOLID))["bodies"][0]["motion"]
    )


def test_writing_refuses_what_could_not_be_read_back(in_folder):
    two = [records.situation_from_json(PLANAR)] * 2
    for name, reason in (
        ("two.json", ": a .json file holds 1 situation (got 2), a .jsonl file many"),
        ("two.jsonl", ':2: name: "ball-and-post" is already the name in line 1'),
    ):
        said = refusals.refusal(FileFormatError, records.write_situations, name, two)
        assert said == name + reason
    assert os.listdir() == []


def test_a_failed_write_leaves_the_old_file_and_no_other(in_folder, monkeypatch):
    records.write_situations("scene.json", [records.situation_from_json(PLANAR)])

    def fail(source, target):
        raise OSError("disk full")

    monkeypatch.setattr(os, "replace", fail)
    with pytest.raises(OSError, match="disk full"):
        records.write_situations("scene.json", [records.situation_from_json(SOLID)])
    assert os.listdir() == ["scene.json"]
    assert records.read_situations("scene.json")[0].name == "ball-and-post"
