"""Files of situations: what is refused, on which line, in which words; round trips."""

from __future__ import annotations

import copy
import io
import json
import os
import sys

import pytest
from hypothesis import given, settings

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

PLANAR = {
    "format": "gcm-learn/situation@1",
    "name": "ball-and-post",
    "horizon": 1.0,
    "arm": {"hand": [1.1, -0.4], "max_hand_speed": 3.1},
    "bodies": [
        {
            "role": "target",
            "name": "ball",
            "shape": {"kind": "disc", "radius": 0.08},
            "motion": {
                "kind": "quadratic",
                "position": [1.6, 1.2],
                "velocity": [-0.4, -0.6],
                "acceleration": [0, -1.5],
            },
        },
        {
            "role": "obstacle",
            "name": "post",
            "shape": {
                "kind": "polygon",
                "vertices": [[-0.1, -0.1], [0.1, -0.1], [0.1, 0.1], [-0.1, 0.1]],
            },
            "motion": {
                "kind": "quadratic",
                "position": [1.3, 0.5],
                "velocity": [0, 0],
                "acceleration": [0, 0],
                "angle": 0.3,
                "spin": 2.0,
            },
        },
    ],
}
SOLID = {
    "format": "gcm-learn/situation@1",
    "name": "pendulum",
    "horizon": 2,
    "arm": {"hand": [1, 0], "max_hand_speed": 3},
    "plane": {"origin": [0, 0, 1], "x": [1, 0, 0], "y": [0, 0, 1]},
    "bodies": [
        {
            "role": "target",
            "name": "ball",
            "shape": {"kind": "sphere", "radius": 0.2},
            "motion": {
                "kind": "pendulum",
                "pivot": [0, 0, 9],
                "axis": [1, 0, 0],
                "down": [0, 0, -1],
                "length": 8,
                "gravity": 70,
                "angle": 0.5,
                "rate": 0,
            },
        },
        {
            "role": "obstacle",
            "name": "box",
            "shape": {"kind": "box", "half_extents": [1, 2, 3]},
            "motion": {
                "kind": "quadratic",
                "position": [5, 5, 5],
                "velocity": [0, 0, 0],
                "acceleration": [0, 0, 0],
            },
        },
    ],
}
FORMATS = " or ".join(f'"gcm-learn/situation@{version}"' for version in (1, 2, 3))
GONE = object()
HUGE = 10**400


def changed(scene, path, value):
    """Return a copy of `scene` with one field replaced, added or (GONE) taken away."""
    result = copy.deepcopy(scene)
    *steps, last = path
    parent = result
    for step in steps:
        parent = parent[step]
    if value is GONE:
        del parent[last]
    else:
        parent[last] = value
    return result


def refusal(path):
    """Return the one line with which a file is refused."""
    with pytest.raises(FileFormatError) as caught:
        read_situations(path)
    message = str(caught.value)
    assert len(message.splitlines()) == 1
    return message


@pytest.fixture
def in_folder(tmp_path, monkeypatch):
    """Work in an empty folder, so that files have short names."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


B0, B1 = ("bodies", 0), ("bodies", 1)
REFUSED_PLANAR = [
    # missing fields
    (
        ("format",),
        GONE,
        f"format: is missing (must be {FORMATS})",
    ),
    (("name",), GONE, "name: is missing (required where a file holds several)"),
    (("horizon",), GONE, "horizon: is missing"),
    (("arm",), GONE, "arm: is missing"),
    (("bodies",), GONE, "bodies: is missing"),
    (("arm", "hand"), GONE, "arm.hand: is missing"),
    (("arm", "max_hand_speed"), GONE, "arm.max_hand_speed: is missing"),
    ((*B1, "role"), GONE, "bodies[1].role: is missing"),
    ((*B1, "name"), GONE, "bodies[1].name: is missing"),
    ((*B1, "shape"), GONE, "bodies[1].shape: is missing"),
    ((*B1, "motion"), GONE, "bodies[1].motion: is missing"),
    (
        (*B1, "shape", "kind"),
        GONE,
        "bodies[1].shape.kind: is missing (known: disc, polygon, sphere, box, capsule, cylinder)",
    ),
    ((*B1, "shape", "vertices"), GONE, "bodies[1].shape.vertices: is missing"),
    ((*B0, "shape", "radius"), GONE, "bodies[0].shape.radius: is missing"),
    (
        (*B1, "motion", "kind"),
        GONE,
        "bodies[1].motion.kind: is missing (known: quadratic, pendulum)",
    ),
    ((*B1, "motion", "position"), GONE, "bodies[1].motion.position: is missing"),
    ((*B1, "motion", "velocity"), GONE, "bodies[1].motion.velocity: is missing"),
    ((*B1, "motion", "acceleration"), GONE, "bodies[1].motion.acceleration: is missing"),
    # unknown fields
    (
        ("colour",),
        1,
        "colour: is not a known field (known: arm, bodies, format, horizon, name, plane)",
    ),
    (
        ("arm", "reach"),
        2,
        "arm.reach: is not a known field (known: elbow, grasp, hand, max_hand_speed,"
        " max_joint_speed, thickness, upper_arm)",
    ),
    (
        (*B0, "shape", "half_length"),
        1,
        "bodies[0].shape.half_length: is not a known field (known: kind, radius)",
    ),
    (
        (*B0, "mass"),
        1,
        "bodies[0].mass: is not a known field (known: motion, name, role, shape)",
    ),
    (
        (*B0, "motion", "orientation"),
        [1, 0, 0, 0],
        "bodies[0].motion.orientation: is not a known field"
        " (known: acceleration, angle, kind, position, spin, velocity)",
    ),
    (
        ("two\nlines",),
        1,
        '"two\\nlines": is not a known field (known: arm, bodies, format, horizon, name, plane)',
    ),
    (
        ("x" * 1000,),
        1,
        '"' + "x" * 40 + '...": is not a known field'
        " (known: arm, bodies, format, horizon, name, plane)",
    ),
    # wrong types
    (
        ("format",),
        1,
        f"format: must be {FORMATS} (got 1)",
    ),
    (
        ("format",),
        "gcm-learn/situation@4",
        f'format: must be {FORMATS} (got "gcm-learn/situation@4")',
    ),
    (
        ("arm", "kind"),
        "spatial",
        "arm.kind: is not a known field (known: elbow, grasp, hand, max_hand_speed,"
        " max_joint_speed, thickness, upper_arm)",
    ),
    (("name",), 5, "name: must be a string (got 5)"),
    (("name",), None, "name: must not be null (leave the field out)"),
    (("horizon",), "1", 'horizon: must be a number (got "1")'),
    (("horizon",), True, "horizon: must be a number (got true)"),
    (("arm",), [1], "arm: must be an object (got a list of 1)"),
    (("arm", "hand"), 1.0, "arm.hand: must be a list of 2 numbers (got 1.0)"),
    (("arm", "hand"), [1, "0"], 'arm.hand[1]: must be a number (got "0")'),
    (("arm", "hand"), [1], "arm.hand: must be a list of 2 numbers (got 1)"),
    (("arm", "elbow"), "Left", 'arm.elbow: must be "left" or "right" (got "Left")'),
    (
        ("arm", "max_joint_speed"),
        None,
        "arm.max_joint_speed: must not be null (leave the field out)",
    ),
    (
        ("arm", "max_joint_speed"),
        [1],
        "arm.max_joint_speed: must be a list of 2 numbers (got 1)",
    ),
    (("bodies",), {}, "bodies: must be a list of bodies (got an object)"),
    (("bodies", 1), "post", 'bodies[1]: must be an object (got "post")'),
    ((*B1, "role"), "goal", 'bodies[1].role: must be "target" or "obstacle" (got "goal")'),
    ((*B1, "role"), [1], 'bodies[1].role: must be "target" or "obstacle" (got a list of 1)'),
    ((*B1, "name"), 1, "bodies[1].name: must be a string (got 1)"),
    ((*B1, "shape"), "disc", 'bodies[1].shape: must be an object (got "disc")'),
    (
        (*B1, "shape", "kind"),
        "star",
        "bodies[1].shape.kind: must be one of"
        ' disc, polygon, sphere, box, capsule, cylinder (got "star")',
    ),
    (
        (*B1, "motion", "kind"),
        ["quadratic"],
        "bodies[1].motion.kind: must be one of quadratic, pendulum (got a list of 1)",
    ),
    (
        (*B1, "motion", "kind"),
        "pendulum",
        'bodies[1].motion.kind: "pendulum" needs a 3D shape',
    ),
    ((*B1, "motion", "angle"), [0], "bodies[1].motion.angle: must be a number (got a list of 1)"),
    (("plane",), None, "plane: must not be null (leave the field out)"),
    # NaN, infinity, absurd sizes
    (("horizon",), float("nan"), "horizon: must be finite (got nan)"),
    (("horizon",), float("inf"), "horizon: must be finite (got inf)"),
    ((*B1, "motion", "spin"), float("-inf"), "bodies[1].motion.spin: must be finite (got -inf)"),
    (
        (*B1, "shape", "vertices", 2, 1),
        float("nan"),
        "bodies[1].shape.vertices[2][1]: must be finite (got nan)",
    ),
    (
        (*B0, "motion", "position", 0),
        HUGE,
        "bodies[0].motion.position[0]: must be finite (got inf)",
    ),
    (("horizon",), 1e60, "horizon: is too large (1e+60, max 1e+50)"),
    # a hand out of reach
    (("arm", "hand"), [2.4, 0], "arm.hand: (2.4, 0.0) is out of reach (max 2.0)"),
    (("arm", "upper_arm"), 0.05, "arm.hand: (1.1, -0.4) is out of reach (max 1.05)"),
    (("arm", "upper_arm"), 2.5, "arm.hand: (1.1, -0.4) is out of reach (min 1.5)"),
    # sizes, horizon and limits
    (("horizon",), 0, "horizon: must be positive (got 0.0)"),
    (("arm", "upper_arm"), -1, "arm.upper_arm: must be positive (got -1.0)"),
    (("arm", "max_hand_speed"), 0, "arm.max_hand_speed: must be positive (got 0.0)"),
    (("arm", "max_joint_speed"), [1, 0], "arm.max_joint_speed[1]: must be positive (got 0.0)"),
    (("arm", "thickness"), -0.1, "arm.thickness: must not be negative (got -0.1)"),
    (("arm", "grasp"), -0.1, "arm.grasp: must not be negative (got -0.1)"),
    ((*B0, "shape", "radius"), 0, "bodies[0].shape.radius: must be positive (got 0.0)"),
    # polygons
    (
        (*B1, "shape", "vertices"),
        [[0, 0], [0, 1], [1, 0]],
        "bodies[1].shape.vertices: the points run clockwise, not counter-clockwise",
    ),
    (
        (*B1, "shape", "vertices"),
        [[0, 0], [1, 1], [1, 0], [0, 1]],
        "bodies[1].shape.vertices: edges 0 and 2 of 4 cross or touch",
    ),
    (
        (*B1, "shape", "vertices"),
        [[0, 0], [1, 0]],
        "bodies[1].shape.vertices: must have at least 3 points (got 2)",
    ),
    # names, targets, dimensions
    ((*B1, "name"), "ball", 'bodies[1].name: "ball" is already the name of bodies[0]'),
    (("bodies",), [], "bodies: no target among 0 bodies"),
    ((*B0, "role"), "obstacle", "bodies: no target among 2 bodies"),
    (
        (*B0, "motion", "position"),
        [1, 2, 3],
        "bodies[0].motion.position: must be a list of 2 numbers (got 3)",
    ),
    (
        ("plane",),
        SOLID["plane"],
        'bodies[0].shape.kind: "disc" is planar, but the situation has a plane',
    ),
    (
        ("bodies", 0),
        SOLID["bodies"][0],
        'bodies[0].shape.kind: "sphere" is 3D, but the situation has no plane',
    ),
]
REFUSED_SOLID = [
    (
        ("plane",),
        GONE,
        'bodies[0].shape.kind: "sphere" is 3D, but the situation has no plane',
    ),
    (("plane",), [], "plane: must be an object (got a list of 0)"),
    (("plane", "x"), GONE, "plane.x: is missing"),
    (("plane", "z"), [0, 1, 0], "plane.z: is not a known field (known: origin, x, y)"),
    (("plane", "x"), [1, 1, 0], "plane.x: must have length 1 (got 1.41421356)"),
    (
        ("plane", "y"),
        [0.6, 0, 0.8],
        "plane.y: must be orthogonal to x (dot product 0.6)",
    ),
    (("plane", "origin"), [0, 0], "plane.origin: must be a list of 3 numbers (got 2)"),
    (
        ("bodies", 1),
        PLANAR["bodies"][1],
        'bodies[1].shape.kind: "polygon" is planar, but the situation has a plane',
    ),
    (
        (*B0, "motion", "down"),
        [0, 0.6, -0.7],
        "bodies[0].motion.down: must have length 1 (got 0.921954446)",
    ),
    (
        (*B0, "motion", "down"),
        [1, 0, 0],
        "bodies[0].motion.down: must be orthogonal to axis (dot product 1)",
    ),
    ((*B0, "motion", "length"), 0, "bodies[0].motion.length: must be positive (got 0.0)"),
    (
        (*B0, "motion", "hang"),
        None,
        "bodies[0].motion.hang: must not be null (leave the field out)",
    ),
    ((*B0, "motion", "rate"), GONE, "bodies[0].motion.rate: is missing"),
    (
        (*B0, "motion", "velocity"),
        [0, 0, 0],
        "bodies[0].motion.velocity: is not a known field (known: angle, axis, damping, down,"
        " gravity, hang, kind, length, pivot, rate)",
    ),
    (
        (*B1, "motion", "orientation"),
        [1, 1, 0, 0],
        "bodies[1].motion.orientation: must have length 1 (got 1.41421356)",
    ),
    (
        (*B1, "motion", "angle"),
        0.3,
        "bodies[1].motion.angle: is not a known field"
        " (known: acceleration, kind, orientation, position, spin, velocity)",
    ),
    (
        (*B1, "shape", "half_extents"),
        [1, -1, 1],
        "bodies[1].shape.half_extents[1]: must be positive (got -1.0)",
    ),
]
REFUSED = [(PLANAR, *case) for case in REFUSED_PLANAR] + [(SOLID, *c) for c in REFUSED_SOLID]


@pytest.mark.parametrize(
    ("scene", "path", "value", "expected"),
    [pytest.param(*case, id=str(k)) for k, case in enumerate(REFUSED)],
)
def test_refused_with_line_and_field(in_folder, scene, path, value, expected):
    good = json.dumps(changed(PLANAR, ("name",), "first"))
    bad = json.dumps(changed(scene, path, value))
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
                "target",
                "ball",
                Disc(0.08),
                PlanarQuadratic((1.6, 1.2), (-0.4, -0.6), (0.0, -1.5)),
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
        ((*B1, "motion", "spin"), "a", '"spin"', "bodies[1].motion.spin"),
        ((*B1, "shape", "vertices", 1, 0), None, "null", "bodies[1].shape.vertices[1][0]"),
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
        (
            b"\n{]\n",
            "scene.jsonl:2: not valid JSON: Expecting property name",
        ),
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
    assert refusal("none.json") == "none.json:1: cannot be read (No such file or directory)"
    assert refusal("folder.json") == "folder.json:1: cannot be read (Is a directory)"
    assert refusal("a\0b.json") == "a\\x00b.json:1: cannot be read (embedded null byte)"
    assert refusal("a\nb.json") == "a\\nb.json:1: cannot be read (No such file or directory)"
    assert refusal("x" * 300).endswith(":1: cannot be read (File name too long)")


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
