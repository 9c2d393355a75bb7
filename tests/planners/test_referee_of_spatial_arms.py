"""The referee in space: the contract's numbers, and trajectories that break one promise each."""

from __future__ import annotations

import copy
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import minimize

from tests.planners.test_referee_of_chains import ball, body, changed, still
from tests.referee_of_spatial_arms import (
    body_of,
    curve_of,
    forward,
    geometry_of,
    judge,
    lowest_room,
    signed_distance,
    swing_steps,
)

BARE = 1e-6  # what the contract grants, relative
NAO = {
    "base": {"origin": [0, 0.098, 0.43], "rotation": [0.9238795, 0, 0, 0.3826834]},
    "upper_arm": [0.105, 0.015, 0],
    "forearm": [0.1137, 0, -0.01231],
}
ARM = {
    "kind": "spatial",
    "base": {"origin": [0.3, -0.2, 0.9], "rotation": [0.5, -0.5, 0.5, 0.5]},
    "upper_arm": [1.0, 0.1, 0.0],
    "forearm": [0.9, 0.0, -0.1],
    "joints": [0.2, 0.3, -0.4, -1.5],
    "joint_range": [[-2.0, 2.0], [-1.0, 1.5], [-2.0, 2.0], [-2.6, 0.0]],
    "max_joint_speed": [5.0, 5.0, 7.0, 7.0],
    "thickness": 0.05,
    "grasp": 0.02,
}
TIME = [0.0, 0.3, 0.7]
JOINTS = [ARM["joints"], [0.9, 0.1, 0.4, -0.9], [1.2, 0.8, 0.1, -0.3]]
RATES = [[1.0, -1.0, 2.0, 0.0], [2.0, 0.5, 0.5, 2.0], [0.5, -0.5, -1.0, 1.0]]


def scene_of(smooth=False, obstacle=None, **changes):
    """A situation with a ball at the end of the movement, and its solution."""
    arm = copy.deepcopy(ARM)
    path = {"time": TIME, "joints": JOINTS}
    if smooth:
        arm |= {"max_joint_acceleration": [60.0] * 4, "joint_rates": RATES[0]}
        path["rates"] = RATES
    arm |= changes
    places = [forward(arm, q) for q in path["joints"]]
    path["elbow"], path["hand"] = ([p[k].tolist() for p in places] for k in (0, 1))
    goal = body("target", "ball", ball(0.1), still(np.add(path["hand"][-1], [0.0, 0.11, 0.0])))
    post = obstacle or body("obstacle", "post", ball(0.1), still([0.5, -1.2, 2.4]))
    situation = {"format": "gcm-learn/situation@2", "name": "made", "horizon": 0.7}
    situation |= {"arm": arm, "bodies": [goal, post]}
    knots, curve = curve_of(arm, path)
    room = lowest_room(situation, knots, curve, geometry_of(arm))[0]
    solution = {"format": "gcm-learn/solution@2", "name": "made", "status": "caught"}
    solution |= {"catch_time": 0.7, "catch_body": "ball", "clearance": room - arm["thickness"]}
    return situation, solution | {"trajectory": copy.deepcopy(path)}


def complaints(situation, solution):
    return " | ".join(judge(situation, solution).complaints)


def joints_at(path, t):
    """Joints of a solution at times t, by textbook formulas."""
    time, joints = np.array(path["time"]), np.array(path["joints"])
    if "rates" not in path:
        return np.stack([np.interp(t, time, joints[:, k]) for k in range(4)], axis=1)
    rates = np.array(path["rates"])
    k = np.clip(np.searchsorted(time, t, side="right") - 1, 0, len(time) - 2)
    h = (time[k + 1] - time[k])[:, None]
    s = (t - time[k])[:, None] / h
    first, last = (1 + 2 * s) * (1 - s) ** 2 * joints[k], s * s * (3 - 2 * s) * joints[k + 1]
    return first + last + s * (1 - s) ** 2 * h * rates[k] + s * s * (s - 1) * h * rates[k + 1]


def hands(arm, joints):
    return np.array([forward(arm, q)[1] for q in joints])


def fastest_hand(arm, path):
    """Largest hand speed, by differences of dense samples within the pieces."""
    most = 0.0
    for a, b in zip(path["time"][:-1], path["time"][1:], strict=True):
        t = np.linspace(a, b, 4001)
        step = np.linalg.norm(np.diff(hands(arm, joints_at(path, t)), axis=0), axis=1)
        most = max(most, step.max() / (t[1] - t[0]))
    return most


# --- the contract's numbers ------------------------------------------------------------------


@pytest.mark.parametrize(
    ("joints", "elbow", "hand"),
    [
        ((0, 0, 0, -0.0349), (0.06364, 0.182853, 0.43), (0.146794, 0.260397, 0.41769)),
        ((1.4, 0.2, -1.2, -0.6), (-0.013136, 0.135155, 0.331527), (0.048224, 0.174735, 0.243507)),
    ],
)
def test_the_contracts_arm_is_where_the_contract_says(joints, elbow, hand):
    found = forward(NAO, joints)
    assert found[0] == pytest.approx(elbow, abs=6e-7) and found[1] == pytest.approx(hand, abs=6e-7)


# --- what is as it should be -----------------------------------------------------------------


@pytest.mark.parametrize("smooth", [False, True])
def test_what_keeps_every_promise_passes(smooth):
    situation, solution = scene_of(smooth)
    assert complaints(situation, solution) == ""


def test_a_catch_at_once_has_one_sample():
    for smooth in (False, True):
        situation, solution = scene_of(smooth)
        solution["trajectory"] = {k: v[:1] for k, v in solution["trajectory"].items()}
        situation["bodies"][0]["motion"] = still(solution["trajectory"]["hand"][0])
        solution["catch_time"] = 0.0
        room = lowest_room(
            situation, *curve_of(situation["arm"], solution["trajectory"]), geometry_of(ARM)
        )[0]
        solution["clearance"] = room - ARM["thickness"]
        assert complaints(situation, solution) == ""
        situation["arm"]["thickness"] = room + 1e-6
        assert "touches" in complaints(situation, solution)


# --- one promise broken ----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("path", "to", "word"),
    [
        (("status",), "unreachable", "status"),
        (("format",), "gcm-learn/solution@1", "format"),
        (("name",), "other", "name"),
        (("catch_body",), "post", "target"),
        (("catch_body",), "nobody", "target"),
        (("catch_time",), 0.7 - 1e-9, "ends at catch_time"),
        (("catch_time",), math.nan, "finite"),
        (("clearance",), None, "clearance"),
        (("clearance",), 3.0, "clearance"),
        (("trajectory", "time", 0), 1e-12, "starts at t = 0"),
        (("trajectory", "time", 1), 0.0, "times increase"),
        (("trajectory", "time", 1), 0.7, "times increase"),
        (("trajectory", "joints", 1, 2), math.nan, "finite"),
        (("trajectory", "joints", 0, 2), -0.4 + 1e-7, "start"),
        (("trajectory", "hand", 1, 2), math.inf, "finite"),
        (("trajectory", "time"), [0.0, 0.7], "shape"),
        (("trajectory", "elbow"), [[0.0, 0.0]] * 3, "shape"),
        (("trajectory", "rates"), RATES, "trajectory holds"),
    ],
)
def test_numbers_that_do_not_fit_are_refused(path, to, word):
    situation, solution = scene_of()
    assert word in complaints(situation, changed(solution, path, to))


@pytest.mark.parametrize("name", ["time", "joints", "hand", "elbow", "rates"])
def test_a_missing_field_is_refused(name):
    situation, solution = scene_of(smooth=True)
    del solution["trajectory"][name]
    assert "trajectory holds" in complaints(situation, solution)


def test_a_catch_after_the_horizon_is_refused():
    situation, solution = scene_of()
    assert "horizon" in complaints(situation | {"horizon": 0.7 - 1e-9}, solution)


@pytest.mark.parametrize("name", ["hand", "elbow"])
def test_hand_and_elbow_follow_from_the_joints(name):
    situation, solution = scene_of()
    for off, wrong in ((0.9e-6, False), (1.1e-6, True)):
        value = solution["trajectory"][name][1][0] + off
        other = changed(solution, ("trajectory", name, 1, 0), value)
        assert (f"{name} and joints disagree" in complaints(situation, other)) == wrong
        assert (complaints(situation, other) == "") != wrong


def test_another_first_rate_is_refused():
    situation, solution = scene_of(smooth=True)
    other = changed(solution, ("trajectory", "rates", 0, 1), -1.0 + 1e-7)
    assert "joint_rates" in complaints(situation, other)
    del situation["arm"]["joint_rates"]  # at rest, then
    assert "joint_rates" in complaints(situation, solution)


def granted(smooth, field, value):
    """Complaints when a limit is a hair below and above `value`, as far as the contract grants."""
    results = []
    for share in (0.5, 2.0):
        situation, solution = scene_of(smooth)
        place = situation["arm"]
        for key in field[:-1]:
            place = place[key]
        place[field[-1]] = value / (1.0 + share * BARE)
        results.append(complaints(situation, solution))
    return results


def extremes(path, order):
    """Largest derivatives (4,) of the joints, by their polynomials over the pieces."""
    _, curve = curve_of({"max_joint_acceleration": 1} if "rates" in path else {}, path)
    most = np.zeros(4)
    for piece, span in zip(curve, np.diff(path["time"]), strict=True):
        for k in range(4):
            law = np.polynomial.Polynomial(piece[k]).deriv(order)
            most[k] = max(most[k], np.abs(law(np.linspace(0.0, span, 20001))).max())
    return most


@pytest.mark.parametrize("smooth", [False, True])
@pytest.mark.parametrize("joint", range(4))
def test_joint_speeds_are_kept_to_the_granted_hair(smooth, joint):
    path = scene_of(smooth)[1]["trajectory"]
    fastest = float(extremes(path, 1)[joint])
    fine, broken = granted(smooth, ("max_joint_speed", joint), fastest)
    assert fine == "" and broken == f"joint {joint} is too fast"


@pytest.mark.parametrize("joint", range(4))
def test_accelerations_are_kept_to_the_granted_hair(joint):
    hardest = float(extremes(scene_of(True)[1]["trajectory"], 2)[joint])
    fine, broken = granted(True, ("max_joint_acceleration", joint), hardest)
    assert fine == "" and broken == f"joint {joint} accelerates too much"


@pytest.mark.parametrize("smooth", [False, True])
@pytest.mark.parametrize(("joint", "side"), [(0, 1), (1, 0), (1, 1), (2, 1), (3, 0), (3, 1)])
def test_ranges_are_kept_between_samples_too(smooth, joint, side):
    path = scene_of(smooth)[1]["trajectory"]
    t = np.union1d(np.linspace(0.0, 0.7, 200_001), TIME)
    q = joints_at(path, t)[:, joint]
    end = float(q.max() if side else q.min())
    if smooth:
        assert joint not in (1, 2) or abs(end) not in np.abs(JOINTS)[:, joint]  # between samples
    situation, solution = scene_of(smooth)
    for share, fine in ((0.5, True), (2.0, False)):
        inward = -abs(end) * share * BARE if side else abs(end) * share * BARE
        situation["arm"]["joint_range"][joint][side] = end + inward
        expected = "" if fine else f"joint {joint} leaves its range"
        assert complaints(situation, solution) == expected


@pytest.mark.parametrize("smooth", [False, True])
def test_the_hands_speed_is_kept_to_the_granted_hair(smooth):
    situation, solution = scene_of(smooth)
    fastest = fastest_hand(situation["arm"], solution["trajectory"])
    fine, broken = granted(smooth, ("max_hand_speed",), fastest)
    assert fine == "" and "the hand is too fast" in broken


@pytest.mark.parametrize("off", [-1e-7, 1e-7])
def test_the_grasp_is_signed_and_exact(off):
    situation, solution = scene_of()
    motion = situation["bodies"][0]["motion"]
    hand = np.array(solution["trajectory"]["hand"][-1])
    motion["position"] = (hand + [0.12 + off, 0.0, 0.0]).tolist()
    assert ("misses" in complaints(situation, solution)) == (off > 0.0)
    motion["position"] = hand.tolist()  # in the middle of it
    assert complaints(situation, solution) == ""


@pytest.mark.parametrize("smooth", [False, True])
@pytest.mark.parametrize("off", [-1e-6, 1e-6])
def test_thickness_is_kept_between_samples(smooth, off):
    """A ball that the elbow passes nearest in the middle of a piece."""
    path = scene_of(smooth)[1]["trajectory"]
    shoulder = np.array(ARM["base"]["origin"])
    middle = forward(ARM, joints_at(path, np.array([0.21]))[0])[0]
    centre = middle + 0.3 * (middle - shoulder) / np.linalg.norm(middle - shoulder)
    post = body("obstacle", "post", ball(0.1), still(centre))
    situation, solution = scene_of(smooth, post)
    found = minimize(
        lambda x: distance_of_limb(situation, path, min(max(x[0], 0.0), 0.7)), [0.21],
        method="Nelder-Mead", options={"xatol": 1e-9, "fatol": 1e-12},
    )  # fmt: skip
    room = min(
        float(found.fun),
        *(distance_of_limb(situation, path, at) for at in np.linspace(0.0, 0.7, 50)),
    )
    situation["arm"]["thickness"] = room + off
    solution["clearance"] = -off
    assert ("touches" in complaints(situation, solution)) == (off > 0.0)


def distance_of_limb(situation, path, t):
    """Distance of the limb to the post at t: by ever closer points of both bones."""
    arm, post = situation["arm"], situation["bodies"][1]
    elbow, hand = forward(arm, joints_at(path, np.array([t]))[0])
    shoulder = np.array(arm.get("base", {}).get("origin", [0.0] * 3))
    least = np.inf
    for a, b in ((shoulder, elbow), (elbow, hand)):
        low, high = 0.0, 1.0
        for _ in range(4):
            s = np.linspace(low, high, 101)
            rooms = signed_distance(post, t, a + s[:, None] * (b - a))
            k = int(np.argmin(rooms))
            low, high = s[max(k - 1, 0)], s[min(k + 1, 100)]
        least = min(least, rooms[k])
    return max(float(least), 0.0)


def test_a_bullet_between_samples_is_seen():
    """It crosses the forearm within a thousandth of a second, half way between two samples."""
    _, solution = scene_of()
    moment = 0.5123
    elbow, hand = forward(ARM, joints_at(solution["trajectory"], np.array([moment]))[0])
    spot = 0.4 * elbow + 0.6 * hand
    across = np.cross(hand - elbow, [0.3, 0.5, 0.7])
    velocity = 900.0 * across / np.linalg.norm(across)
    motion = still(spot - moment * velocity, velocity=velocity.tolist())
    bullet = body("obstacle", "bullet", ball(1e-3), motion)
    situation, solution = scene_of(obstacle=bullet, thickness=0.0)
    assert "touches" in complaints(situation, solution)
    motion["position"] = (spot + 0.3 * (hand - elbow) * 3.0 - moment * velocity).tolist()
    situation, solution = scene_of(obstacle=bullet, thickness=0.0)
    assert complaints(situation, solution) == ""


# --- distances and motion by other means -----------------------------------------------------


SHAPES = [
    ball(0.3),
    {"kind": "box", "half_extents": [0.5, 0.1, 0.3]},
    {"kind": "capsule", "radius": 0.1, "half_length": 0.4},
    {"kind": "cylinder", "radius": 0.3, "half_length": 0.2},
]
SWING = {
    "kind": "pendulum", "pivot": [0.5, 0.2, 2.0], "axis": [0.0, 1.0, 0.0], "down": [0.0, 0.0, -1.0],
    "length": 1.1, "gravity": 9.81, "angle": 1.2, "rate": -2.0, "damping": 0.3, "hang": 0.9,
}  # fmt: skip


def law(rng, kind):
    """A random law of motion about the arm."""
    if kind == "pendulum":
        axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        return SWING | {
            "pivot": rng.normal(size=3).tolist(), "axis": axes[0].tolist(),
            "down": axes[1].tolist(), "angle": rng.uniform(-2, 2), "rate": rng.normal(0, 3),
            "hang": rng.uniform(0.0, 2.0),
        }  # fmt: skip
    turn = rng.normal(size=4)
    motion = still(rng.normal(size=3) * 1.5, orientation=(turn / np.linalg.norm(turn)).tolist())
    for name, most in (("velocity", 2.0), ("acceleration", 3.0), ("spin", 4.0)):
        motion[name] = rng.normal(0.0, most, 3).tolist()
    return motion


@pytest.mark.parametrize("kind", ["quadratic", "pendulum"])
@pytest.mark.parametrize("shape", SHAPES, ids=lambda shape: shape["kind"])
def test_the_clearance_is_that_of_dense_samples(shape, kind, rng):
    for k in range(4):
        post = body("obstacle", "post", shape, law(rng, kind))
        situation, solution = scene_of(bool(k % 2), post)
        path = solution["trajectory"]
        knots, curve = curve_of(situation["arm"], path)
        situation["arm"]["thickness"] = 0.0
        found, _ = lowest_room(situation, knots, curve, geometry_of(situation["arm"]))
        t = np.linspace(0.0, 0.7, 150)
        least = min(distance_of_limb(situation, path, at) for at in t)
        assert found <= least + 2e-4
        assert least <= found + 0.02 or found == 0.0  # what the samples may miss


def test_pendulums_swing_as_scipy_says():
    def change(_, x):
        return [x[1], -9.81 / 1.1 * math.sin(x[0]) - 0.3 * x[1]]

    post = body("obstacle", "bob", ball(0.1), SWING)
    steps = swing_steps([post], 3.0)
    _, table = body_of(post, 3.0, steps)
    t = np.linspace(0.0, 3.0, steps + 1)
    found = solve_ivp(change, (0.0, 3.0), [1.2, -2.0], t_eval=t, rtol=1e-12, atol=1e-12)
    assert table == pytest.approx(found.y.T, abs=1e-9)
    at = 1.234
    angle = float(np.interp(at, t, found.y[0]))
    bob = np.array(SWING["pivot"]) + 0.9 * np.array([-math.sin(angle), 0.0, -math.cos(angle)])
    assert signed_distance(post, at, bob) == pytest.approx(-0.1, abs=1e-5)


def test_bodies_turn_about_the_worlds_axes():
    """A long box along x, first turned a quarter about z, then spinning a quarter about x."""
    half = math.sqrt(0.5)
    motion = still([1.0, 0.0, 0.0], orientation=[half, 0.0, 0.0, half])
    motion |= {"spin": [0.5 * math.pi, 0.0, 0.0], "velocity": [1.0, 0.0, 0.0]}
    box = body("obstacle", "box", {"kind": "box", "half_extents": [0.5, 0.1, 0.2]}, motion)
    assert signed_distance(box, 0.0, [1.0, 0.6, 0.0]) == pytest.approx(0.1)
    assert signed_distance(box, 1.0, [2.0, 0.0, 0.6]) == pytest.approx(0.1)
    assert signed_distance(box, 1.0, [2.0, 0.05, 0.0]) == pytest.approx(-0.1)
