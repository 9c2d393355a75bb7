"""The referee as a program of its own: files in, complaints out, nothing of the package."""

import ast
import copy
import json
import random
import re
import subprocess
import sys
from pathlib import Path

import pytest

from gcm_learn import referee
from gcm_learn.referee import Complaint, Unreadable, judge
from gcm_learn.referee.__main__ import main
from gcm_learn.situation import read_situations
from tests.referee.answers import MADE
from tests.worlds import changed

FOLDER = Path(referee.__file__).parent
ALLOWED = {"gcm_learn", "gcm_learn.late", "gcm_learn.registration"}
"""Modules that `import gcm_learn` itself loads."""


def test_it_imports_numpy_and_nothing_else_of_the_package():
    roots = set()
    for path in FOLDER.glob("*.py"):
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            if isinstance(node, ast.Import):
                roots |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                assert node.level == 0
                roots.add(node.module)
    own = {name for name in roots if name.startswith("gcm_learn.referee")}
    others = {name.split(".")[0] for name in roots - own} - set(sys.stdlib_module_names)
    assert own and others == {"numpy"}


def test_importing_it_loads_nothing_else():
    code = "import sys, gcm_learn.referee.__main__; print('\\n'.join(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = set(done.stdout.split())
    ours = {name for name in loaded if name.split(".")[0] == "gcm_learn"}
    assert {n for n in ours if not n.startswith("gcm_learn.referee")} <= ALLOWED
    assert not {"numba", "llvmlite", "scipy", "gymnasium"} & loaded and "numpy" in loaded


@pytest.fixture
def written(tmp_path):
    """Return a function that writes situations and solutions, and gives the two paths."""

    def write(pairs):
        paths = []
        for k, name in enumerate(("situations.jsonl", "solutions.jsonl")):
            paths.append(tmp_path / name)
            lines = [json.dumps(pair[k]) for pair in pairs if pair[k] is not None]
            paths[-1].write_text("\n".join(lines) + "\n", "utf-8")
        return [str(path) for path in paths]

    return write


def pairs():
    """True answers of all kinds, each with a name of its own."""
    made = []
    for name, make in MADE.items():
        situation, solution = make()
        made.append((situation | {"name": name}, solution | {"name": name}))
    return made


def test_true_answers_hold(written, capsys):
    assert main(written(pairs())) == 0
    assert capsys.readouterr().out == f"{len(MADE)} judged, 0 broken, 0 complaints\n"


def test_a_lie_is_one_line(written, capsys):
    made = pairs()
    made[4][1]["trajectory"]["joints"][1][2] += 0.1
    assert main(written(made)) == 1
    *lines, last = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("spatial @3: trajectory.hand: is 0.") and "at 0.3 s" in lines[0]
    assert last == f"{len(MADE)} judged, 1 broken, {len(lines)} complaints"


def test_answers_fit_situations_by_name(written, capsys):
    made = pairs()
    spare = made[0][1] | {"name": "spare"}
    made[1] = (made[1][0], None)
    assert main(written([*made, (None, made[2][1]), (None, spare)])) == 1
    assert capsys.readouterr().out.splitlines() == [
        "solid: name: has no answer",
        "spatial: name: has 2 answers",
        "spare: name: is not the name of a situation",
        f"{len(MADE)} judged, 2 broken, 3 complaints",
    ]


def test_machines_read_one_object(written, capsys):
    made = pairs()
    made[0][1]["clearance"] = 9.0
    assert main([*written(made), "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert found["judged"] == len(MADE) and found["broken"] == 1
    assert [(c["name"], c["field"]) for c in found["complaints"]] == [("planar", "clearance")]


def test_models_are_found_beside_the_file_and_by_name(written, capsys, tmp_path):
    situation, solution = MADE["chain"]()
    (tmp_path / "slide.json").write_text(json.dumps(situation["arm"]["model"]), "utf-8")
    situation["arm"]["model"] = "slide.json"
    assert main(written([(situation, solution)])) == 0
    situation["arm"]["model"] = "nowhere.json"
    assert main(written([(situation, solution)])) == 2
    situation["arm"]["model"] = "octopus"
    assert main(written([(situation, solution)])) == 2
    first, second = capsys.readouterr().err.splitlines()
    assert "nowhere.json: No such file" in first
    assert second.endswith('situations.jsonl:1: arm.model: "octopus" is not a known arm')


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("{", "situations.jsonl:1: is not JSON"),
        ("[1]", "situations.jsonl:1: is not an object"),
        ('{"format": "gcm-learn/situation@7"}', '"gcm-learn/situation@7" is not a format'),
        ('{"format": "gcm-learn/situation@1", "name": "a"}', "horizon: is missing"),
        (
            '{"format": "gcm-learn/situation@1", "name": "a", "horizon": 1%s}' % ("0" * 5000),
            "arm: is missing",
        ),
        ('{"name": "a", "name": "b"}', "a field is there twice"),
        ('{"name": "a"}\n{"name": "a"}', 'name: "a" is there twice'),
    ],
)
def test_unreadable_input_is_one_line(written, capsys, text, word):
    situations, solutions = written(pairs())
    Path(situations).write_text(text, "utf-8")
    assert main([situations, solutions]) == 2
    found = capsys.readouterr()
    assert found.err.count("\n") == 1 and word in found.err
    assert main([situations + "x", solutions]) == 2
    assert "No such file" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["situations.jsonl", "SCENES.JSONL", "scenes.txt", "scenes"])
def test_it_reads_what_is_solved(written, capsys, name):
    """A byte-order mark, line breaks of Windows and blank lines; others stand in names."""
    made = pairs()
    for (situation, solution), sign in zip(made, "\u2028\u2029\x85\x0b\x0c\x1e", strict=False):
        situation["name"] = solution["name"] = f"a{sign}b{situation['name']}"
    paths = [Path(path) for path in written(made)]
    for k, path in enumerate(paths):
        lines = [json.dumps(pair[k], ensure_ascii=False) for pair in made]
        path.write_bytes(("\ufeff" + "\r\n \t\r\n".join(lines)).encode())
    moved = paths[0].rename(paths[0].with_name(name))
    assert [one.name for one in read_situations(moved)] == [one[0]["name"] for one in made]
    assert main([str(moved), str(paths[1])]) == 0
    assert capsys.readouterr().out.endswith("0 complaints\n")


def test_it_reads_one_object_in_a_file_of_any_name(tmp_path, capsys):
    situation, solution = MADE["planar"]()
    (tmp_path / "scene").write_text("\ufeff" + json.dumps(situation, indent=1), "utf-8")
    (tmp_path / "answer").write_text(json.dumps(solution, indent=1), "utf-8")
    assert main([str(tmp_path / "scene"), str(tmp_path / "answer")]) == 0


def test_a_complaint_reads_as_a_line():
    assert str(Complaint("clearance", "is off", name="a")) == "a: clearance: is off"
    assert str(Complaint("status", "is odd", 0.25, "a")) == "a: status: is odd, at 0.25 s"


ODD = [
    None,
    True,
    -1,
    0,
    1e300,
    10**400,
    float("nan"),
    "",
    "caught",
    [],
    [[]],
    {},
    [0.0],
    {"time": 0},
]


def places(given, path=()):
    """Every place in an object."""
    items = given.items() if isinstance(given, dict) else enumerate(given)
    for key, value in items:
        yield (*path, key)
        if isinstance(value, dict | list):
            yield from places(value, (*path, key))


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("case", MADE)
def test_no_answer_stops_the_referee(case):
    """Any value at any place is judged, and changes of anything but words are found."""
    situation, solution = MADE[case]()
    draw = random.Random(7)
    for path in draw.sample(every := list(places(solution)), min(12, len(every))):
        lie = copy.deepcopy(solution)
        where = lie
        for key in path[:-1]:
            where = where[key]
        true = where[path[-1]]
        for odd in ODD:
            where[path[-1]] = odd
            harmless = path[0] in ("planner", "message", "planning_ms", "name")
            harmless |= odd == true and type(odd) is not bool
            harmless |= path[0] == "clearance" and solution["format"].endswith("@3")
            assert judge(situation, lie) or harmless or "rates" in path, (path, odd)


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("case", MADE)
def test_no_situation_stops_the_referee_but_with_a_line(case):
    situation, solution = MADE[case]()
    draw = random.Random(8)
    for path in draw.sample(every := list(places(situation)), min(6, len(every))):
        for odd in ODD:
            lie = copy.deepcopy(situation)
            where = lie
            for key in path[:-1]:
                where = where[key]
            where[path[-1]] = odd
            try:
                judge(lie, solution)
            except Unreadable as error:
                assert "\n" not in str(error)


REFUSED = [
    ("chain", ("arm", "model", "links", 0, "joint"), 9, "arm.model.links[0].joint"),
    ("chain", ("arm", "model", "hand", "joint"), 0, "arm.model.hand.joint"),
    ("chain", ("arm", "model", "self_collision"), [[1, 1]], "arm.model.self_collision"),
    ("chain", ("arm", "model", "joints", 1, "axis"), [0, 0, 2], "arm.model.joints[1].axis"),
    ("chain", ("arm", "model", "joints", 0, "max_acceleration"), 1.0, "arm.model.joints"),
    ("chain", ("arm", "posture"), [0.4, 0.25], "arm.posture"),
    ("chain", ("arm", "kind"), "octopus", "arm.kind"),
    ("chain", ("bodies", 0, "approach", "within"), 4.0, "bodies[0].approach.within"),
    ("chain", ("bodies", 2, "approach"), {"axis": [1, 0, 0], "within": 1}, "bodies[2].approach"),
    ("chain", ("catch",), "some", "catch"),
    ("chain", ("bodies", 1, "name"), "second", "bodies"),
    ("chain", ("bodies", 2, "motion"), {"kind": "sampled", "times": [0, 0]}, "bodies[2].motion"),
    ("solid", ("plane", "y"), [0.0, 0.6, 0.8], "plane"),
    ("solid", ("bodies", 1, "shape"), {"kind": "disc", "radius": 1}, "bodies[1].shape.kind"),
    ("planar", ("bodies", 2, "shape", "vertices"), [[0, 0], [0, 1], [1, 0]], "bodies[2].shape"),
    ("planar", ("arm", "thickness"), -0.1, "arm.thickness"),
    ("planar", ("horizon",), 0.0, "horizon"),
    ("spatial", ("plane",), {}, "plane"),
    ("spatial", ("bodies", 0, "role"), "obstacle", "bodies"),
    ("spatial", ("bodies", 1, "motion", "orientation"), [1, 1, 0, 0], "bodies[1].motion"),
]


@pytest.mark.parametrize(("case", "path", "to", "field"), REFUSED)
def test_a_wrong_situation_is_refused_with_its_field(case, path, to, field):
    situation, solution = MADE[case]()
    with pytest.raises(Unreadable, match=f"^{re.escape(field)}"):
        judge(changed(situation, path, to), solution)


def test_pieces_that_do_not_meet_are_refused():
    situation, solution = MADE["chain"]()
    flight = {"position": [5, 0, 0], "velocity": [0, 0, 0], "acceleration": [0, 0, 0]}
    pieces = [{"start": 0, **flight}, {"start": 0.2, **flight}]
    situation["bodies"][2]["motion"] = {"kind": "piecewise", "pieces": pieces}
    assert judge(situation, solution) == []
    pieces[1] = pieces[1] | {"position": [5, 0, 1e-3]}
    with pytest.raises(Unreadable, match="does not begin where"):
        judge(situation, solution)
    half = [[1, 0, 0, 0], [0, 1, 0, 0]]
    motion = {"kind": "sampled", "times": [0, 1], "positions": [[5, 0, 0]] * 2}
    situation["bodies"][2]["motion"] = motion | {"orientations": half}
    with pytest.raises(Unreadable, match="half a turn"):
        judge(situation, solution)
