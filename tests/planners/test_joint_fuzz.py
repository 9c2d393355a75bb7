"""Any situation of a spatial arm is answered in time, or refused in a line that names the field."""

from __future__ import annotations

import contextlib
import copy
import io
import json
import math
import re
import tempfile
from pathlib import Path

import pytest
from hypothesis import assume, given, settings, strategies as st

from gcm_learn import situation as records, solve
from gcm_learn.arms import Base, SpatialArm
from gcm_learn.cli import main
from gcm_learn.errors import FileFormatError
from tests import strategies
from tests.judging import judge
from tests.planners.test_fuzz import answered, numbers, solid, wild, wild_horizons
from tests.situation.scenes import MOVING, PLANAR, SOLID as IN_PLANE
from tests.situation.test_fuzz_reader import paths, spoiled_objects

QUICK = ["search", "straight", "straight-wait"]
RECALLING = ["recall", "hybrid"]
planners, every = st.sampled_from(QUICK), st.sampled_from([*QUICK, *RECALLING])


def compile_for(names):
    """Compile everything before the clock runs."""
    for smooth in (True, False):
        scene = copy.deepcopy(MOVING)
        if not smooth:
            del scene["arm"]["max_joint_acceleration"], scene["arm"]["joint_rates"]
        for planner in names:
            solve(records.situation_from_json(scene), planner)


@pytest.fixture(scope="module", autouse=True)
def _compiled():
    compile_for(QUICK)


@pytest.fixture(scope="module")
def _recalling():
    compile_for(RECALLING)


@settings(max_examples=20)
@given(strategies.spatial_situations(), planners)
def test_valid_situations_get_an_answer_that_holds(situation, planner):
    plan = answered(situation, planner)
    assert not plan.caught or judge(situation, plan) == []


# --- numbers of any magnitude ----------------------------------------------------------------


@st.composite
def wild_arms(draw):
    """Bones of very different length, ranges of nothing to a thousand turns, any limits."""
    pairs = []
    for _ in range(4):
        low = draw(st.floats(-4.0, 4.0) | numbers)
        pairs.append((low, low + draw(st.sampled_from([0.0, 1e-9]) | st.floats(0.0, 7.0) | wild)))
    shares = [draw(st.sampled_from([0.0, 1.0]) | st.floats(0.0, 1.0)) for _ in pairs]
    joints = [min(a + s * (b - a), b) for (a, b), s in zip(pairs, shares, strict=True)]
    speeds = draw(strategies.vectors(4, st.floats(0.1, 10.0) | wild))
    fastest = draw(st.none() | strategies.vectors(4, st.floats(1.0, 100.0) | wild))
    share = draw(st.sampled_from([-1.0, 0.0, 0.5, 1.0]))
    bones = strategies.vectors(3, st.floats(-1.0, 1.0) | numbers).filter(any)
    return SpatialArm(
        upper_arm=draw(strategies.bones() | bones),
        forearm=draw(strategies.bones() | bones),
        joints=tuple(joints),
        joint_range=tuple(pairs),
        max_joint_speed=speeds,
        grasp=draw(st.sampled_from([0.0, 0.05]) | wild),
        base=Base(draw(strategies.vectors(3, numbers)), draw(strategies.unit_vectors(4))),
        joint_rates=None if fastest is None else tuple(share * most for most in speeds),
        max_hand_speed=draw(st.none() | st.floats(0.5, 5.0) | wild),
        max_joint_acceleration=fastest,
        thickness=draw(st.just(0.0) | wild),
    )


@st.composite
def wild_situations(draw):
    """Situations in space whose numbers may have any magnitude."""
    arm = draw(wild_arms() | strategies.spatial_arms())
    parts = draw(st.lists(solid, min_size=1, max_size=3))
    at_shoulder = records.SolidQuadratic(arm.base.origin, (0.0,) * 3, (0.0,) * 3)
    bodies = [records.Body("obstacle" if k else "target", str(k), *p) for k, p in enumerate(parts)]
    if draw(st.booleans()):
        role = draw(st.sampled_from(["target", "obstacle"]))
        bodies.append(records.Body(role, "at the shoulder", draw(solid)[0], at_shoulder))
    return records.Situation("wild", wild_horizons(draw, bodies), arm, tuple(bodies))


@settings(max_examples=20)
@given(wild_situations(), planners)
def test_wild_situations_get_an_answer(situation, planner):
    answered(situation, planner)


@pytest.mark.slow
@settings(max_examples=1000)
@given(wild_situations(), every)
def test_many_wild_situations_get_an_answer(_recalling, situation, planner):
    answered(situation, planner)


@pytest.mark.slow
@settings(max_examples=1000)
@given(strategies.spatial_situations(), every)
def test_many_valid_situations_get_an_answer_that_holds(_recalling, situation, planner):
    plan = answered(situation, planner)
    assert not plan.caught or judge(situation, plan) == []


# --- by the command line ---------------------------------------------------------------------


def commanded(scene, planner):
    """Exit code, what the command wrote to its file (None if there is none), and its complaint."""
    with tempfile.TemporaryDirectory() as folder:
        path, out = Path(folder, "scene.jsonl"), Path(folder, "out.jsonl")
        path.write_text(json.dumps(scene) + "\n")
        printed, complaint = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(printed), contextlib.redirect_stderr(complaint):
            code = main(["solve", str(path), "--planner", planner, "--out", str(out)])
        written = out.read_text() if out.exists() else None
        assert [p.name for p in Path(folder).iterdir() if p not in (path, out)] == []
        return code, written, complaint.getvalue().replace(f"{folder}/", "")


@settings(max_examples=20)
@given(spoiled_objects() | wild_situations().map(records.situation_to_json), planners)
def test_the_command_answers_or_refuses_in_one_line(scene, planner):
    assume(scene.get("format") != "gcm-learn/situation@1")
    code, written, complaint = commanded(scene, planner)
    assert code in (0, 2)
    if code == 2:
        assert written is None
        assert re.fullmatch(r"scene\.jsonl:1: \S[^\n]*\n", complaint)
    else:
        assert json.loads(written)["status"] in ("caught", "unreachable", "start_blocked")
        assert "Traceback" not in complaint


WRONG = [math.nan, math.inf, -math.inf, None, True, "a word", [], {}, [math.nan] * 4, 1e999, -1]


def spelt(path):
    """A path as messages spell it: ``arm.joint_range[2][1]``."""
    return "".join(f"[{s}]" if isinstance(s, int) else f".{s}" for s in path).lstrip(".")


def named(message, path):
    """Whether a message names a field, or what it is in, or, of axes and limits, another side."""
    return any(f" {spelt(path[:k])}" in message for k in range(1, len(path) + 1))


@pytest.mark.parametrize("path", paths(MOVING), ids=spelt)
def test_whatever_is_wrong_with_a_field_is_said_of_that_field(path, tmp_path):
    file = tmp_path / "scene.jsonl"
    for value in [*WRONG, "gone"]:
        scene = copy.deepcopy(MOVING)
        place = scene
        for step in path[:-1]:
            place = place[step]
        if value == "gone":
            del place[path[-1]]
        else:
            place[path[-1]] = value
        file.write_text(json.dumps(scene) + "\n")
        try:
            records.read_situations(file)
        except FileFormatError as error:
            message = str(error).removeprefix(f"{file}:1:")
            assert "\n" not in message and message != str(error)
            assert named(message, path), message
            continue
        good = isinstance(value, int | str) and not isinstance(value, bool)
        assert good or value in ([], {}), (value, "was read")


@pytest.mark.parametrize(
    ("change", "field"),
    [
        ({"plane": IN_PLANE["plane"]}, "plane"),
        ({"bodies": PLANAR["bodies"]}, "bodies[0].shape.kind"),
        ({"arm": PLANAR["arm"]}, "arm.kind"),
        ({"arm": MOVING["arm"] | {"kind": "rail"}}, "arm.kind"),
        ({"format": "gcm-learn/situation@1"}, "arm.kind"),
        ({"horizon": 0.0}, "horizon"),
        ({"horizon": 1e9}, "horizon"),
        ({"extra": 1}, "extra"),
    ],
)
def test_what_belongs_to_other_arms_is_refused(change, field):
    code, written, complaint = commanded(MOVING | change, "straight")
    assert code == 2 and written is None
    assert complaint.startswith(f"scene.jsonl:1: {field}: ")
    assert complaint.count("\n") == 1
