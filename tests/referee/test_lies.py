"""Planted lies: small edits of true answers, each of which breaks one promise."""

import copy
import math
from functools import cache

import numpy as np
import pytest

from gcm_learn.referee import Unreadable, judge
from tests.referee.answers import MADE, RATES, lifted
from tests.worlds import ball, body, changed, still


@cache
def _made(case):
    return MADE[case]()


def true(case):
    """A situation and its true answer, to be changed at will."""
    return copy.deepcopy(_made(case))


def words(situation, solution):
    """All complaints in one line."""
    return " | ".join(map(str, judge(situation, solution)))


@pytest.mark.parametrize("case", MADE)
def test_true_answers_pass(case):
    situation, solution = true(case)
    assert words(situation, solution) == ""
    assert solution["clearance"] > 0.0


def near(axis, off):
    """A function that moves one number by so much."""
    return lambda rows, k: changed(rows, (k, axis), rows[k][axis] + off)


FORM = [
    (("format",), "gcm-learn/solution@9", "format: is not"),
    (("name",), "other", "name: is not the situation's"),
    (("status",), "captured", "trajectory: is no field"),
    (("status",), "unreachable", "trajectory: is no field"),
    (("planner",), None, "planner: is not a string"),
    (("message",), "two\nlines", "message: is not a sentence"),
    (("message",), None, "message: is not a sentence"),
    (("planning_ms",), -1.0, "planning_ms: is not a number"),
    (("planning_ms",), math.nan, "planning_ms: is not a number"),
    (("planning_ms",), True, "planning_ms: is not a number"),
    (("score",), 1.0, "score: is no field"),
    (("catch_body",), None, "catch_body: is not a name"),
    (("catch_body",), ["goal"], "catch_body: is not a name"),
    (("catch_body",), "post", "catch_body: "),
    (("catch_body",), "nobody", "catch_body: "),
    (("catch_time",), None, "catch_time: is not a finite number"),
    (("catch_time",), math.inf, "catch_time: is not a finite number"),
    (("catch_time",), "soon", "catch_time: is not a finite number"),
    (("catch_time",), 0.25, "catch_time: is not"),
    (("clearance",), None, "clearance: is not a finite number"),
    (("clearance",), math.nan, "clearance: is not a finite number"),
    (("trajectory",), None, "trajectory: is not an object"),
    (("trajectory",), [0.0], "trajectory: is not an object"),
    (("trajectory", "speed"), [0.0], "trajectory.speed: is no column"),
    (("trajectory", "time"), [], "trajectory.time: has 0 samples"),
    (("trajectory", "time"), 0.0, "trajectory.time: is not a list"),
    (("trajectory", "time", 0), 1e-12, "does not start at t = 0"),
    (("trajectory", "time", 1), -1e-9, "trajectory.time: does not increase"),
    (("trajectory", "time", -1), math.nan, "trajectory.time: is not a list"),
    (("trajectory", "joints"), [[0.0]], "trajectory.joints: is not a list"),
    (("trajectory", "joints", 1, 1), math.nan, "trajectory.joints: is not a list"),
    (("trajectory", "joints", 1, 1), "0.1", "trajectory.joints: is not a list"),
    (("trajectory", "joints", 1, 1), True, "trajectory.joints: is not a list"),
    (("trajectory", "hand", 1, 0), math.inf, "trajectory.hand: is not a list"),
    (("trajectory", "hand", 1, 0), 7.0, "trajectory."),
    (("trajectory", "hand", 0, 1), -0.4, "trajectory."),
]
"""Lies about fields, which go for every kind of arm."""


@pytest.mark.parametrize("case", MADE)
@pytest.mark.parametrize(("path", "to", "word"), FORM, ids=lambda v: str(v)[:40])
def test_a_lie_about_form_is_found(case, path, to, word):
    situation, solution = true(case)
    assert word in words(situation, changed(solution, path, to))


@pytest.mark.parametrize("case", MADE)
def test_every_missing_field_is_found(case):
    situation, solution = true(case)
    for name in solution:
        less = {key: value for key, value in solution.items() if key != name}
        assert judge(situation, less), name
    for name in solution["trajectory"]:
        path = {key: value for key, value in solution["trajectory"].items() if key != name}
        assert f"trajectory.{name}: is missing" in words(situation, solution | {"trajectory": path})


def of(base, *lies):
    return [(base, *lie) for lie in lies]


ARM, GOAL, POST = ("arm",), ("bodies", 0), ("bodies", 1)
FASTER = "moves too fast"
LIES = [
    # planar arms: the solution
    *of(
        "planar",
        ("solution", ("trajectory", "time", 5), 0.0694, "too fast"),
        ("solution", ("trajectory", "hand", 0, 0), 1.5 + 1e-8, "does not start on arm.hand"),
        ("solution", ("trajectory", "joints", 20, 0), 7.0, "do not lead to the hand"),
        ("solution", ("trajectory", "joints", 20, 0), -5.9, "jump"),
        ("solution", ("trajectory", "joints", 20, 1), 1.0, "elbow on the other side"),
        ("solution", ("trajectory", "hand", 30, 0), 2.3, "out of reach"),
        ("solution", ("trajectory", "hand", 30), [0.1, 0.1], "out of reach"),
        ("solution", ("trajectory", "rates"), [[0.0, 0.0]] * 60, "rates: is no column"),
        ("solution", ("catches",), [], "catches: is no field"),
        ("situation", ("horizon",), 1.0 - 1e-9, "after the horizon"),
        ("situation", (*ARM, "hand"), [1.5, 0.8 + 1e-8], "does not start on arm.hand"),
        ("situation", (*ARM, "elbow"), "right", "elbow on the other side"),
        ("situation", (*ARM, "upper_arm"), 1.2 + 1e-5, "do not lead to the hand"),
        ("situation", (*ARM, "max_hand_speed"), 2.0, "hand: is too fast"),
        ("situation", (*ARM, "max_joint_speed"), [9.0, 0.5], "joint 1 moves too fast"),
        ("situation", (*ARM, "max_joint_speed"), [0.5, 9.0], "joint 0 moves too fast"),
        ("situation", (*ARM, "thickness"), 0.6, "touch"),
        ("situation", (*ARM, "grasp"), 0.03 - 1e-6, "misses goal"),
        ("situation", (*GOAL, "motion", "position", 1), -1.05, "misses goal"),
        ("situation", (*GOAL, "motion", "velocity"), [0.0, -0.1], "misses goal"),
        ("situation", (*GOAL, "shape", "radius"), 0.08, "misses goal"),
        ("situation", (*POST, "motion", "position"), [0.9, 0.0], "and post touch"),
        ("situation", (*POST, "motion", "acceleration"), [-8.0, 0.0], "and post touch"),
        ("situation", (*POST, "shape", "radius"), 0.8, "and post touch"),
        ("situation", ("bodies", 2, "motion", "position"), [0.5, 0.9], "and bar touch"),
        ("situation", ("bodies", 2, "motion", "velocity"), [3.0, 0.0], "and bar touch"),
        ("situation", (*POST, "role"), "target", "clearance"),
    ),
    # planar arms among solids
    *of(
        "solid",
        ("situation", (*ARM, "grasp"), 0.0299, "misses goal"),
        ("situation", ("plane", "origin"), [0.3, -1.0, 0.4], "misses goal"),
        ("situation", (*GOAL, "shape", "radius"), 0.05, "misses goal"),
        ("situation", (*GOAL, "motion", "velocity"), [0.1, 0.0, 0.0], "misses goal"),
        ("situation", (*POST, "shape", "half_extents"), [1.5, 0.1, 0.1], "and post touch"),
        ("situation", (*POST, "motion", "spin"), [0.0, 0.0, 0.0], "clearance"),
        ("situation", ("bodies", 2, "motion", "position"), lifted(0.9, 0.6), "and bar touch"),
        ("situation", (*ARM, "max_hand_speed"), 2.0, "hand: is too fast"),
        ("situation", (*ARM, "max_joint_speed"), [9.0, 0.5], "joint 1 moves too fast"),
    ),
    # spatial arms
    *of(
        "spatial",
        ("solution", ("trajectory", "time", 1), 0.0, "does not increase"),
        ("solution", ("trajectory", "time", 1), 0.69, FASTER),
        ("solution", ("trajectory", "joints", 0, 2), -0.4 + 1e-7, "does not start as the arm"),
        ("solution", ("trajectory", "joints", 1, 2), 0.41, "off the place"),
        ("solution", ("trajectory", "hand", 1), near(0, 1.1e-6), "trajectory.hand: is 1.1e-06"),
        ("solution", ("trajectory", "elbow", 1), near(2, -2e-6), "trajectory.elbow: is 2e-06"),
        ("solution", ("trajectory", "elbow"), [[0.0, 0.0]] * 3, "trajectory.elbow: is not a list"),
        ("solution", ("trajectory", "rates"), RATES, "trajectory.rates: is no column"),
        ("situation", ("horizon",), 0.7 - 1e-9, "after the horizon"),
        ("situation", (*ARM, "base", "origin", 0), 0.31, "off the place"),
        ("situation", (*ARM, "base", "rotation"), [1.0, 0.0, 0.0, 0.0], "off the place"),
        ("situation", (*ARM, "forearm", 0), 0.91, "trajectory.hand: is"),
        ("situation", (*ARM, "joint_range", 3, 1), -0.31, "joint 3 leaves its range"),
        ("situation", (*ARM, "joint_range", 1, 0), 0.11, "joint 1 leaves its range"),
        ("situation", (*ARM, "max_joint_speed", 2), 2.6, "joint 2 moves too fast"),
        ("situation", (*ARM, "max_hand_speed"), 3.0, "the hand is too fast"),
        ("situation", (*ARM, "grasp"), 0.01 - 1e-7, "misses goal"),
        ("situation", (*ARM, "thickness"), 1.8, "touch"),
        ("situation", (*ARM, "max_joint_acceleration"), [60.0] * 4, "rates: is missing"),
        ("situation", (*GOAL, "motion", "velocity"), [0.0, 0.0, 0.1], "misses goal"),
        ("situation", (*GOAL, "shape"), {"kind": "box", "half_extents": [0.05] * 3}, "misses goal"),
        ("situation", (*POST, "shape", "radius"), 1.8, "and post touch"),
        ("situation", (*POST, "motion", "acceleration"), [0.0, 0.0, -20.0], "clearance"),
    ),
    *of(
        "spatial, smooth",
        ("solution", ("trajectory", "rates", 0, 1), -1.0 + 1e-7, "does not start as the arm"),
        ("solution", ("trajectory", "rates", 1, 0), 40.0, "joint 0 moves too fast"),
        ("solution", ("trajectory", "rates", 2, 3), 15.0, "joint 3 accelerates too much"),
        ("situation", (*ARM, "joint_rates"), [0.0] * 4, "does not start as the arm"),
        ("situation", (*ARM, "max_joint_acceleration", 1), 5.0, "joint 1 accelerates too much"),
        ("situation", (*ARM, "max_joint_speed", 0), 2.5, "joint 0 moves too fast"),
        ("situation", (*ARM, "joint_range", 0, 1), 1.19, "joint 0 leaves its range"),
    ),
    *of(
        "spatial @3",
        ("solution", ("trajectory", "elbow"), [[0.0] * 3] * 3, "trajectory.elbow: is no column"),
        ("solution", ("format",), "gcm-learn/solution@2", "format: is not"),
        ("solution", ("catches", 0, "body"), "post", "catch_body: is not the last"),
        ("situation", (*ARM, "grasp"), 0.01 - 3e-6, "misses goal"),
        ("situation", (*GOAL, "approach"), {"axis": [0, 0, 1], "within": 0.1}, "approaches goal"),
        ("situation", (*POST, "shape", "radius"), 1.8, "and post touch"),
    ),
    # chains
    *of(
        "chain, smooth",
        ("solution", ("catches",), [{"body": "first", "time": 0.3}], "catch"),
        ("solution", ("catches",), [], "catches: is not a list of at least one"),
        ("solution", ("catches",), {}, "catches: is not a list of at least one"),
        ("solution", ("catches", 0), {"body": "first"}, "catches: has an entry"),
        ("solution", ("catches", 0, "score"), 1, "catches: has an entry"),
        ("solution", ("catches", 0, "time"), math.nan, "without a name or a finite time"),
        ("solution", ("catches", 0, "body"), "second", "catch a target twice"),
        ("solution", ("catches", 0, "body"), "post", "post is not a target"),
        ("solution", ("catches", 0, "time"), 0.29, "are not all at samples"),
        ("solution", ("catches", 0, "time"), 0.7, "are not in order of time"),
        ("solution", ("catch_time",), 0.3, "catch_time: is not the last catch's"),
        ("solution", ("catch_body",), "first", "catch_body: is not the last catch's"),
        ("solution", ("trajectory", "time", 1), 0.7, "does not increase"),
        ("solution", ("trajectory", "joints", 0, 1), 0.2501, "does not start as the arm"),
        ("solution", ("trajectory", "joints", 1, 1), 0.41, "off the place"),
        ("solution", ("trajectory", "rates", 0, 1), 0.0, "does not start as the arm"),
        ("solution", ("trajectory", "rates", 1, 0), 9.0, "joint 0 moves too fast"),
        ("solution", ("trajectory", "elbow"), [[0.0] * 3] * 3, "elbow: is no column"),
        ("situation", ("horizon",), 0.6999, "after the horizon"),
        ("situation", ("catch",), "any", "are 2, asked for: any"),
        ("situation", (*ARM, "posture"), [0.4, 0.25, -0.71], "does not start as the arm"),
        ("situation", (*ARM, "rates"), [1.0, -0.2, 0.6], "does not start as the arm"),
        ("situation", (*ARM, "grasp"), 0.009, "misses second"),
        ("situation", (*ARM, "max_acceleration"), None, "rates: is no column"),
        ("situation", (*ARM, "max_acceleration", 2), 3.0, "joint 2 accelerates too much"),
        ("situation", (*ARM, "max_hand_speed"), 0.5, "the hand is too fast"),
        (
            "situation",
            (*ARM, "model", "joints", 0, "range"),
            [-2, 1.05],
            "joint 0 leaves its range",
        ),
        ("situation", (*ARM, "model", "joints", 1, "range"), [0.21, 0.6], "joint 1 leaves"),
        ("situation", (*ARM, "model", "joints", 1, "max_speed"), 0.5, "joint 1 moves too fast"),
        ("situation", (*ARM, "model", "joints", 2, "origin"), [0, 0, 0.21], "off the place"),
        ("situation", (*ARM, "model", "hand", "point"), [0.31, 0, 0], "off the place"),
        ("situation", (*ARM, "model", "hand", "axis"), [0, 1, 0], "approaches second"),
        ("situation", (*ARM, "model", "links", 0, "radius"), 0.5, "links 0 and 2 touch"),
        ("situation", (*GOAL, "approach", "axis"), [1.0, 0.0, 0.0], "approaches second"),
        ("situation", (*GOAL, "motion", "spin"), [0.0, 0.0, 0.2], "approaches second"),
        ("situation", (*POST, "motion", "velocity"), [1.0, 0.0, 0.0], "misses first"),
        ("situation", ("bodies", 2, "shape", "radius"), 1.2, "and post touch"),
    ),
    *of(
        "chain",
        ("solution", ("trajectory", "rates"), [[0.0] * 3] * 3, "rates: is no column"),
        ("situation", (*ARM, "max_acceleration"), [60.0] * 3, "rates: is missing"),
        ("situation", (*ARM, "model", "joints", 2, "max_speed"), 2.6, "joint 2 moves too fast"),
        ("situation", ("catch",), "most", ""),
    ),
]
"""Case, what is edited, where, to what, and a part of the complaint; the last is no lie."""


def edited(given, path, to):
    """A copy with one value replaced; functions change a row of a column."""
    if callable(to):
        rows = given
        for key in path[:-1]:
            rows = rows[key]
        return changed(given, path[:-1], to(rows, path[-1]))
    return changed(given, path, to)


@pytest.mark.parametrize(
    ("case", "where", "path", "to", "word"),
    LIES,
    ids=[f"{case}-{'.'.join(map(str, path))}-{k}" for k, (case, _, path, _, _) in enumerate(LIES)],
)
def test_a_lie_is_found(case, where, path, to, word):
    situation, solution = true(case)
    if where == "situation":
        situation = edited(situation, path, to)
    else:
        solution = edited(solution, path, to)
    found = words(situation, solution)
    assert word in found and bool(word) == bool(found)


NONE = {"catch_time": None, "catch_body": None, "clearance": None, "message": "it says why"}
INSIDE = {  # an obstacle, and a place on the arm at t = 0
    "planar": ("post", lambda s, a: a["trajectory"]["hand"][0]),
    "solid": ("post", lambda s, a: np.array(s["plane"]["origin"])),
    "spatial": ("post", lambda s, a: a["trajectory"]["elbow"][0]),
    "spatial, smooth": ("post", lambda s, a: a["trajectory"]["elbow"][0]),
    "spatial @3": ("post", lambda s, a: a["trajectory"]["hand"][0]),
    "chain": ("post", lambda s, a: a["trajectory"]["hand"][0]),
    "chain, smooth": ("post", lambda s, a: s["arm"]["base"]["origin"]),
}


def nothing(solution, status):
    """The solution without its catch."""
    solution = {key: value for key, value in solution.items() if key != "trajectory"}
    listed = {"catches": []} if "catches" in solution else {}
    return solution | NONE | listed | {"status": status}


@pytest.mark.parametrize("case", MADE)
def test_a_start_is_blocked_exactly_where_something_touches(case):
    situation, solution = true(case)
    name, place = INSIDE[case]
    touching = copy.deepcopy(situation)
    post = next(b for b in touching["bodies"] if b["name"] == name)
    post["motion"]["position"] = [float(x) for x in place(situation, solution)]
    free, blocked = nothing(solution, "unreachable"), nothing(solution, "start_blocked")
    assert words(situation, free) == "" and words(touching, blocked) == ""
    assert "status: is start_blocked, " in words(situation, blocked)
    assert "but the start is blocked" in words(touching, free)


def test_a_start_is_blocked_by_the_arm_itself():
    situation, solution = true("chain")
    situation["arm"]["model"]["links"][0]["radius"] = 0.5
    assert words(situation, nothing(solution, "start_blocked")) == ""
    assert "the start is blocked" in words(situation, nothing(solution, "unreachable"))


@pytest.mark.parametrize("case", MADE)
@pytest.mark.parametrize(
    ("field", "to"),
    [
        ("catch_time", 0.3),
        ("catch_body", "goal"),
        ("clearance", 0.1),
        ("catches", [{"body": "goal", "time": 0.3}]),
        ("trajectory", {"time": [0.0]}),
        ("message", ""),
        ("status", "given up"),
    ],
)
def test_an_answer_without_a_catch_claims_none(case, field, to):
    situation, solution = true(case)
    assert f"{field}: " in words(situation, nothing(solution, "unreachable") | {field: to})


@pytest.mark.parametrize("case", MADE)
def test_a_wrong_clearance_is_a_lie_where_it_is_promised(case):
    """In version 3 it is information."""
    situation, solution = true(case)
    promised = not situation["format"].endswith("@3")
    assert ("clearance: is 9, found" in words(situation, solution | {"clearance": 9.0})) == promised


@pytest.mark.parametrize("case", MADE)
def test_clearance_is_null_exactly_without_obstacles(case):
    situation, solution = true(case)
    situation["bodies"] = [b for b in situation["bodies"] if b["role"] == "target"]
    assert "clearance: is given without obstacles" in words(situation, solution)
    assert words(situation, solution | {"clearance": None}) == ""


def test_ignored_pairs_do_not_count():
    situation, solution = true("chain")
    knob = body("obstacle", "knob", ball(0.1), still(situation["arm"]["base"]["origin"]))
    situation["bodies"].append(knob)
    assert "link 0 and knob touch" in words(situation, solution)
    situation["arm"]["ignore"] = [[0, "knob"]]
    assert "touch" not in words(situation, solution)
    situation["arm"]["ignore"] = [[1, "knob"]]
    assert "link 0 and knob touch" in words(situation, solution)


def test_a_name_in_ignore_stands_for_all_links_of_that_name():
    situation, solution = true("chain")
    model = situation["arm"]["model"]
    knob = body("obstacle", "knob", ball(0.1), still(situation["arm"]["base"]["origin"]))
    situation["bodies"].append(knob)
    situation["arm"]["ignore"] = [["mast", "knob"]]
    model["links"][0]["name"] = "mast"
    with pytest.raises(Unreadable, match=r"arm\.model\.links\[0\]\.name: is unknown"):
        words(situation, solution)
    model["format"] = "gcm-learn/arm@2"
    assert "touch" not in words(situation, solution)
    for link in ("most", 3):
        situation["arm"]["ignore"] = [[0, "knob"], [link, "knob"]]
        with pytest.raises(Unreadable, match=rf"arm\.ignore\[1\]: {link} is not a link"):
            words(situation, solution)
    model["format"] = "gcm-learn/arm@3"
    with pytest.raises(Unreadable, match=r"arm\.model\.format"):
        words(situation, solution)


@pytest.mark.parametrize(("off", "fine"), [(0.999e-5, True), (1.001e-5, False)])
@pytest.mark.parametrize("case", ["spatial", "chain"])
def test_a_start_nearly_in_its_range_is_the_bound(case, off, fine):
    """The true answer begins on the bound, though the file asks for a posture beyond it."""
    situation, solution = true(case)
    arm = situation["arm"]
    chain = case == "chain"
    key = "posture" if chain else "joints"
    ranges = [joint["range"] for joint in arm["model"]["joints"]] if chain else arm["joint_range"]
    start = arm[key][0]
    ways = [row[0] for row in solution["trajectory"]["joints"]]
    side = 0 if min(ways) >= start - 1e-9 else 1
    assert side == 0 or max(ways) <= start + 1e-9
    ranges[0][side] = start
    arm[key][0] = start + (2 * side - 1) * off * max(1.0, abs(start))
    assert (words(situation, solution) == "") == fine


def test_there_are_many_lies_for_every_kind():
    count = {case: sum(lie[0] == case for lie in LIES) for case in MADE}
    assert sum(count.values()) > 100 and min(count.values()) >= 4
