"""The referee of chains: the contract's numbers, and answers that break one promise each."""

from __future__ import annotations

import copy
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import minimize

from tests.referee_of_chains import (
    arm_of,
    at_times,
    frames_of,
    hand_of,
    hand_velocity,
    judge,
    links_of,
    poses,
    room,
    segment_room,
    segments_apart,
)

HALF = math.sqrt(0.5)
ZERO = [0.0, 0.0, 0.0]
SLIDE = {
    "format": "gcm-learn/arm@1",
    "name": "slide",
    "joints": [
        {"origin": [0, 0, 0.3], "axis": [0, 0, 1], "range": [-2, 2], "max_speed": 3},
        {
            "type": "prismatic", "origin": [0.1, 0, 0], "rotation": [HALF, 0, HALF, 0],
            "axis": [0, 0, 1], "range": [0, 0.6], "max_speed": 1.5,
        },
        {
            "origin": [0, 0, 0.2], "rotation": [HALF, HALF, 0, 0],
            "axis": [0, 0, 1], "range": [-2, 2], "max_speed": 4,
        },
    ],
    "links": [
        {"joint": 0, "from": [0, 0, 0], "to": [0, 0, 0.2], "radius": 0.05},
        {"joint": 2, "from": [0, 0, 0], "to": [0, 0, 0.2], "radius": 0.04},
        {"joint": 3, "from": [0.05, 0, 0], "to": [0.3, 0, 0], "radius": 0.03},
    ],
    "hand": {"joint": 3, "point": [0.3, 0, 0], "axis": [1, 0, 0]},
    "self_collision": [[0, 2]],
}  # fmt: skip
BASE = {"origin": [1, 2, 0], "rotation": [math.cos(math.pi / 8), 0, 0, math.sin(math.pi / 8)]}
ARM = {
    "kind": "chain",
    "model": SLIDE,
    "base": BASE,
    "posture": [0.4, 0.25, -0.7],
    "grasp": 0.02,
    "max_acceleration": [60.0, 60.0, 60.0],
    "rates": [1.0, -0.2, 0.5],
}
PATH = {
    "time": [0.0, 0.3, 0.7],
    "joints": [ARM["posture"], [0.9, 0.4, 0.1], [1.1, 0.2, 0.5]],
    "rates": [ARM["rates"], [1.0, 0.3, 1.5], [0.0, -0.5, 0.3]],
}


def still(position, **more):
    """A quadratic motion that rests but for what is given."""
    motion = {"kind": "quadratic", "position": [float(x) for x in position]}
    return motion | {"velocity": ZERO, "acceleration": ZERO} | more


def body(role, name, shape, motion, **more):
    return {"role": role, "name": name, "shape": shape, "motion": motion} | more


def ball(radius):
    return {"kind": "sphere", "radius": radius}


def arms(given=ARM):
    return arm_of(given, {})


def made(smooth=True):
    """A situation with two targets, both to be caught, and an answer that keeps every promise."""
    arm, path = copy.deepcopy(ARM), copy.deepcopy(PATH)
    if not smooth:
        del arm["max_acceleration"], arm["rates"], path["rates"]
    hands, axes = hand_of(arms(arm), np.array(path["joints"]))
    path["hand"] = hands.tolist()
    approach = {"axis": axes[2].tolist(), "within": 0.0}
    bodies = [
        body("target", "second", ball(0.1), still(hands[2] + [0, 0.11, 0]), approach=approach),
        body("target", "first", ball(0.05), still(hands[1])),
        body("obstacle", "post", ball(0.1), still([2.2, 2.9, 0.3])),
    ]
    situation = {"format": "gcm-learn/situation@3", "name": "made", "horizon": 0.7, "arm": arm}
    situation |= {"catch": "all", "bodies": bodies}
    catches = [{"body": "first", "time": 0.3}, {"body": "second", "time": 0.7}]
    solution = {"format": "gcm-learn/solution@3", "name": "made", "planner": "me"}
    solution |= {"status": "caught", "catches": catches, "catch_time": 0.7}
    solution |= {"catch_body": "second", "clearance": None, "planning_ms": 1.0, "message": ""}
    solution["trajectory"] = path
    solution["clearance"] = judge(situation, solution).clearance
    return situation, solution


def complaints(situation, solution):
    return " | ".join(judge(situation, solution).complaints)


# --- the contract's numbers, and movements by other means ------------------------------------


def test_the_contracts_chain_is_where_the_contract_says():
    hand, axis = hand_of(arms(), np.array([[0.4, 0.25, -0.7]]))
    assert hand[0] == pytest.approx((1.134107, 2.330568, 0.070547), abs=6e-7)
    assert axis[0] == pytest.approx((-0.242180, -0.596964, -0.764842), abs=6e-7)


def test_a_spatial_arm_is_the_chain_that_it_is():
    nao = {
        "kind": "spatial",
        "base": {"origin": [0, 0.098, 0.43], "rotation": [0.9238795, 0, 0, 0.3826834]},
        "upper_arm": [0.105, 0.015, 0], "forearm": [0.1137, 0, -0.01231],
        "joints": [0] * 4, "joint_range": [[-3, 3]] * 4, "max_joint_speed": [8] * 4, "grasp": 0,
    }  # fmt: skip
    arm, joints = arm_of(nao, {}), np.array([[1.4, 0.2, -1.2, -0.6]])
    hand, axis = hand_of(arm, joints)
    elbow = links_of(arm, joints)[0][0, 1, 0]
    assert elbow == pytest.approx((-0.013136, 0.135155, 0.331527), abs=6e-7)
    assert hand[0] == pytest.approx((0.048224, 0.174735, 0.243507), abs=6e-7)
    assert axis[0] == pytest.approx((hand[0] - elbow) / np.linalg.norm(hand[0] - elbow))


def test_the_hands_velocity_is_its_derivative():
    arm, path = arms(), {k: np.array(v) for k, v in PATH.items()}
    t, h = np.linspace(0.01, 0.69, 90), 1e-6
    ahead, behind = (hand_of(arm, at_times(path, t + side)[0])[0] for side in (h, -h))
    found = hand_velocity(arm, *at_times(path, t))
    assert found == pytest.approx((ahead - behind) / (2.0 * h), abs=1e-5)


SHAPES = {
    "sphere": ball(0.3),
    "box": {"kind": "box", "half_extents": [0.5, 0.1, 0.3]},
    "capsule": {"kind": "capsule", "radius": 0.1, "half_length": 0.4},
    "cylinder": {"kind": "cylinder", "radius": 0.3, "half_length": 0.2},
}


@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
def test_segments_are_as_near_as_their_nearest_points(shape):
    rng = np.random.default_rng(1)
    a, b = rng.uniform(-1.0, 1.0, (2, 200, 3))
    found, s = segment_room(shape, a, b), np.linspace(0.0, 1.0, 20_001)
    for k in range(0, 200, 10):
        dense = room(shape, a[k] + s[:, None] * (b[k] - a[k])).min()
        if dense > 0.0 or shape["kind"] != "capsule":
            assert found[k] == pytest.approx(dense, abs=1e-4) and found[k] <= dense + 1e-8


def test_segments_apart_by_minimising():
    rng = np.random.default_rng(2)
    a, b, c, d = rng.uniform(-1.0, 1.0, (4, 30, 3))
    found = segments_apart(a, b, c, d)
    for k in range(30):

        def apart(x, k=k):
            return np.linalg.norm(a[k] + x[0] * (b[k] - a[k]) - c[k] - x[1] * (d[k] - c[k]))

        tries = [minimize(apart, x, bounds=[(0, 1)] * 2) for x in ([0.1, 0.9], [0.9, 0.1])]
        assert found[k] == pytest.approx(min(r.fun for r in tries), abs=1e-5)


def test_a_pendulum_swings_as_scipy_says():
    law = {
        "kind": "pendulum", "pivot": [1, 0, 2], "axis": [0, 1, 0], "down": [0, 0, -1],
        "length": 1.2, "gravity": 9.8, "angle": 1.0, "rate": -2.0, "damping": 0.3, "hang": 0.7,
    }  # fmt: skip
    t = np.linspace(0.0, 2.0, 9)
    found, turn = poses({"motion": law}, t)

    def rate(_, x):
        return [x[1], -9.8 / 1.2 * math.sin(x[0]) - 0.3 * x[1]]

    angle = solve_ivp(rate, (0, 2), [1.0, -2.0], t_eval=t, rtol=1e-11, atol=1e-11).y[0]
    along = np.stack([-np.sin(angle), 0.0 * angle, -np.cos(angle)], axis=1)
    assert found == pytest.approx(np.array([1, 0, 2]) + 0.7 * along, abs=1e-8)
    assert turn[:, :, 2] == pytest.approx(along, abs=1e-8)


# --- what is as it should be -----------------------------------------------------------------


@pytest.mark.parametrize("smooth", [False, True])
def test_what_keeps_every_promise_passes(smooth):
    assert complaints(*made(smooth)) == ""


def test_a_catch_at_once_has_one_sample():
    situation, solution = made()
    solution["trajectory"] = {k: v[:1] for k, v in solution["trajectory"].items()}
    situation["bodies"][1]["motion"] = still(solution["trajectory"]["hand"][0])
    solution |= {"catches": [{"body": "first", "time": 0.0}], "catch_time": 0.0}
    solution["catch_body"], situation["catch"] = "first", "most"
    clearance = judge(situation, solution).clearance
    assert complaints(situation, solution | {"clearance": clearance}) == ""


# --- one promise broken ----------------------------------------------------------------------

CATCH = {"body": "first", "time": 0.3}
NONE = {"catches": [], "catch_time": None, "catch_body": None, "clearance": None}
LIES = [
    ("solution", ("status",), "captured", "status"),
    ("solution", ("format",), "gcm-learn/solution@2", "format"),
    ("solution", ("name",), "other", "name"),
    ("solution", ("elbow",), [], "fields"),
    ("solution", ("catches",), [CATCH], "broken"),
    ("solution", ("catches",), [], "at least one"),
    ("solution", ("catches", 0, "body"), "second", "twice"),
    ("solution", ("catches", 0, "body"), "post", "of targets"),
    ("solution", ("catches", 0, "time"), 0.29, "sample"),
    ("solution", ("catches", 0, "time"), 0.7, "order"),
    ("solution", ("catch_time",), 0.3, "catch_time"),
    ("solution", ("catch_body",), "first", "catch_body"),
    ("solution", ("clearance",), None, "clearance is null"),
    ("solution", ("clearance",), 9.0, "reported"),
    ("solution", ("trajectory", "time", 0), 1e-9, "starts at"),
    ("solution", ("trajectory", "time", 1), 0.7, "increase"),
    ("solution", ("trajectory", "joints", 0, 1), 0.2501, "arm.posture"),
    ("solution", ("trajectory", "joints", 1, 1), math.nan, "finite"),
    ("solution", ("trajectory", "joints", 1, 1), 0.41, "disagree"),
    ("solution", ("trajectory", "hand", 1, 2), 3.0, "disagree"),
    ("solution", ("trajectory", "hand"), [[1.0, 2.0]], "shape"),
    ("solution", ("trajectory", "rates", 0, 1), 0.0, "arm.rates"),
    ("solution", ("trajectory", "rates", 1, 0), 9.0, "joint 0 is too fast"),
    ("solution", ("trajectory", "elbow"), [[0.0] * 3] * 3, "trajectory holds"),
    ("situation", ("horizon",), 0.6999, "horizon"),
    ("situation", ("catch",), "any", "as many"),
    ("situation", ("arm", "grasp"), 0.009, "misses second"),
    ("situation", ("arm", "max_acceleration", 2), 3.0, "joint 2 is forced"),
    ("situation", ("arm", "max_hand_speed"), 0.5, "hand is too fast"),
    ("situation", ("arm", "model", "joints", 0, "range"), [-2, 1.05], "joint 0 leaves"),
    ("situation", ("arm", "model", "joints", 1, "max_speed"), 0.5, "joint 1 is too fast"),
    ("situation", ("arm", "model", "links", 0, "radius"), 0.5, "touches itself"),
    ("situation", ("bodies", 0, "approach", "axis"), [1.0, 0.0, 0.0], "approaches second"),
    ("situation", ("bodies", 0, "motion", "spin"), [0.0, 0.0, 0.2], "approaches second"),
    ("situation", ("bodies", 1, "motion", "velocity"), [1.0, 0.0, 0.0], "misses first"),
    ("situation", ("bodies", 2, "shape", "radius"), 1.2, "touches"),
]


def changed(given, path, to):
    """A copy of an object with one value replaced or added."""
    given = copy.deepcopy(given)
    place = given
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = to
    return given


@pytest.mark.parametrize(("where", "path", "to", "word"), LIES)
def test_a_lie_is_found(where, path, to, word):
    situation, solution = made()
    if where == "situation":
        situation = changed(situation, path, to)
    else:
        solution = changed(solution, path, to)
    assert word in complaints(situation, solution)


def test_rates_are_for_limits_of_acceleration():
    situation, solution = made(smooth=False)
    lie = changed(solution, ("trajectory", "rates"), PATH["rates"])
    assert "trajectory holds" in complaints(situation, lie)
    situation, solution = made()
    del solution["trajectory"]["rates"]
    assert "trajectory holds" in complaints(situation, solution)


def motions(place, t):
    """Motions that are at a place at t only, under every law."""
    place, way = np.array(place), np.array([0.5, -3.0, 2.0])
    start = place - t * way
    flight = still(start, velocity=way.tolist())
    pieces = [{"start": 0.0} | still(start, velocity=way.tolist())]
    pieces.append({"start": t} | still(place, velocity=(-way).tolist()))
    samples = [start.tolist(), place.tolist(), start.tolist()]
    swing = {"kind": "pendulum", "axis": [0, 1, 0], "down": [0, 0, -1], "length": 0.5, "rate": 8.0}
    swing |= {"gravity": 9.8, "angle": -1.0, "pivot": ZERO}
    centre, _ = poses({"motion": swing}, np.array([t]))
    return {
        "quadratic": flight,
        "piecewise": {
            "kind": "piecewise",
            "pieces": [{k: v for k, v in piece.items() if k != "kind"} for piece in pieces],
        },
        "sampled": {"kind": "sampled", "times": [0.0, t, 2.0 * t], "positions": samples},
        "pendulum": swing | {"pivot": (place - centre[0]).tolist()},
    }


@pytest.mark.parametrize("law", ["quadratic", "piecewise", "sampled", "pendulum"])
@pytest.mark.parametrize("kind", SHAPES)
def test_an_obstacle_between_samples_is_found(kind, law):
    """It is small, crosses a link at one moment, and counts only where it is not ignored."""
    situation, solution = made()
    path = {k: np.array(v) for k, v in solution["trajectory"].items()}
    t, small = 0.4321, {"half_extents": [0.02] * 3, "radius": 0.015, "half_length": 0.01}
    ends, _ = links_of(arms(), at_times(path, np.array([t]))[0])
    shape = {"kind": kind} | {k: small[k] for k in SHAPES[kind] if k != "kind"}
    motion = motions(ends[2, :, 0].mean(axis=0), t)[law]
    situation["bodies"].append(body("obstacle", "fly", shape, motion))
    found = judge(situation, solution)
    assert any("touches" in word for word in found.complaints) and found.clearance < -0.02
    situation["arm"]["ignore"] = [[k, "fly"] for k in range(3)]
    assert complaints(situation, solution) == ""


@pytest.mark.parametrize(
    ("path", "to", "blocked"),
    [
        ((), None, False),
        (("bodies", 2, "motion", "position"), [1.0, 2.0, 0.0], True),
        (("arm", "model", "links", 0, "radius"), 0.5, True),
    ],
)
def test_a_start_is_blocked_exactly_where_something_overlaps(path, to, blocked):
    situation, solution = made()
    del solution["trajectory"]
    situation = changed(situation, path, to) if path else situation
    for status, word in (
        ("unreachable", "is blocked at the start" if blocked else ""),
        ("start_blocked", "" if blocked else "is not blocked"),
    ):
        found = complaints(situation, solution | NONE | {"status": status})
        assert word in found and (found != "") == (word != "")
    assert "names a catch" in complaints(situation, solution | {"status": "unreachable"})


def test_frames_turn_and_slide():
    turn, at, _ = frames_of(arms(), np.array([[0.4, 0.25, -0.7], [0.4, 0.35, -0.7]]))
    assert np.linalg.norm(at[2, 1] - at[2, 0]) == pytest.approx(0.1)
    assert turn[3, 0] == pytest.approx(turn[3, 1])
    assert np.swapaxes(turn, 2, 3) @ turn == pytest.approx(np.broadcast_to(np.eye(3), turn.shape))
