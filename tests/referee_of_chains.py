"""An independent referee of ``situation@3``: the exchange contract alone, JSON in, verdict out.

It shares nothing with the package.  Frames, motions and distances are its own, in plain numpy over
all instants at once.  A movement is sampled densely, and again around the smallest distances.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

GRANTED = 1e-6  # of limits, relative; of ranges, grasp, approach and overlap, absolute too
START = 1e-9  # of joints and rates at t = 0
ROUNDING = 1e-14  # of joints, relative to their size
CLEARANCE = 1e-3  # error of the reported clearance, relative to the arm's size
INSTANTS = 2000  # of a movement, to begin with
CLOSE = 0.02  # share of the arm's size: distances that are looked at more closely
CLOSER = (33, 33, 33)  # instants around a smallest distance, each time between two of the last
SWING = 1e-3  # step of a pendulum, over the time in which it changes

FIELDS = {
    "format", "name", "planner", "status", "catches", "catch_time", "catch_body", "clearance",
    "planning_ms", "message",
}  # fmt: skip
STATUSES = ("caught", "unreachable", "start_blocked")


@dataclass(frozen=True)
class Verdict:
    """What the referee found: an empty list of complaints means that every promise is kept."""

    complaints: list[str]
    clearance: float = math.nan
    """Least signed distance of links and obstacles; infinite without any."""


def judge(situation, solution, models=None):
    """Check all that the contract promises.

    Parameters
    ----------
    situation : dict
        In the format ``gcm-learn/situation@3``.
    solution : dict
        In the format ``gcm-learn/solution@3``.
    models : dict, optional
        Arm files' objects by what situations call them.
    """
    arm = arm_of(situation["arm"], models or {})
    complaints = _form(situation, solution)
    if complaints:
        return Verdict(complaints)
    start = least_at(situation, arm, np.zeros(1), arm["posture"][None])
    if solution["status"] != "caught":
        wrong = _without_catch(situation, solution, start)
        return Verdict(wrong, start[0])
    complaints = _numbers(situation, solution, arm)
    if complaints:
        return Verdict(complaints)
    path = _path_of(solution["trajectory"])
    time, joints, rates = _dense(path)
    complaints = [*_start(arm, path), *_agreement(arm, path), *_limits(arm, path)]
    complaints += _hand_speed(arm, time, joints, rates, path)
    obstacles, itself = _least(situation, arm, path, time, joints)
    complaints += _overlaps(arm, situation, solution, obstacles, itself)
    complaints += _caught(situation, solution, arm, path)
    return Verdict(complaints, obstacles)


# --- the form --------------------------------------------------------------------------------


def _form(situation, solution):
    """Fields that any solution has."""
    wanted = FIELDS | ({"trajectory"} if solution.get("status") == "caught" else set())
    if set(solution) != wanted:
        return [f"fields are {sorted(solution)}, not {sorted(wanted)}"]
    fits = {
        "format is gcm-learn/solution@3": solution["format"] == "gcm-learn/solution@3",
        "name is the situation's": solution["name"] == situation.get("name", ""),
        "status is known": solution["status"] in STATUSES,
        "catches are a list": isinstance(solution["catches"], list),
        "planning_ms is a number": isinstance(solution["planning_ms"], int | float),
        "message is a sentence": isinstance(solution["message"], str),
    }
    return [f"broken: {promise}" for promise, kept in fits.items() if not kept]


def _without_catch(situation, solution, start):
    """What is wrong of an answer without a catch, from the distances at t = 0."""
    free = min(start)
    empty = [solution[name] for name in ("catch_time", "catch_body", "clearance")]
    complaints = []
    if solution["catches"] or any(value is not None for value in empty):
        complaints.append("names a catch without being caught")
    if (solution["status"] == "start_blocked") and free > GRANTED:
        complaints.append(f"is not blocked at the start: {free:g} away")
    if (solution["status"] != "start_blocked") and free < -GRANTED:
        complaints.append(f"is blocked at the start, {-free:g} deep")
    return complaints


def _numbers(situation, solution, arm):
    """What does not fit together in a caught plan's numbers."""
    path, n = solution["trajectory"], len(arm["posture"])
    wanted = {"time", "joints", "hand"} | ({"rates"} if arm["acceleration"] is not None else set())
    if set(path) != wanted:
        return [f"the trajectory holds {sorted(path)}, not {sorted(wanted)}"]
    m = len(path["time"])
    sizes = {"time": (m,), "joints": (m, n), "rates": (m, n), "hand": (m, 3)}
    columns = {}
    for name in sorted(wanted):
        try:
            columns[name] = np.array(path[name], dtype=float)
        except ValueError:
            return [f"{name} is ragged"]
        if m == 0 or columns[name].shape != sizes[name]:
            return [f"{name} has the shape {columns[name].shape}"]
    time = columns["time"]
    fits = {
        "numbers are finite": all(np.isfinite(column).all() for column in columns.values()),
        "starts at t = 0": time[0] == 0.0,
        "times increase": bool((np.diff(time) > 0.0).all()),
        **_listed(situation, solution, time),
    }
    return [f"broken: {promise}" for promise, kept in fits.items() if not kept]


def _listed(situation, solution, time):
    """Promises of the list of catches."""
    catches = solution["catches"]
    if not catches or any(set(entry) != {"body", "time"} for entry in catches):
        return {"catches name body and time, at least one": False}
    bodies, times = [c["body"] for c in catches], [c["time"] for c in catches]
    targets = [body["name"] for body in situation["bodies"] if body["role"] == "target"]
    if not set(bodies) <= set(targets):
        return {"catches are of targets": False}
    order = [(t, targets.index(name)) for t, name in zip(times, bodies, strict=True)]
    enough = {"any": len(catches) == 1, "all": len(catches) == len(targets), "most": True}
    return {
        "no target is caught twice": len(set(bodies)) == len(bodies),
        "catches are in order": order == sorted(order),
        "every catch is a sample": set(times) <= set(time.tolist()),
        "catches are within the horizon": times[-1] <= situation["horizon"],
        "catch_time is the last catch's": solution["catch_time"] == times[-1],
        "catch_body is the last catch's": solution["catch_body"] == bodies[-1],
        "ends at catch_time": time[-1] == solution["catch_time"],
        "as many are caught as are asked for": enough[situation.get("catch", "any")],
    }


# --- the arm ---------------------------------------------------------------------------------


def arm_of(given, models):
    """Return an arm of a situation as a dict of arrays; a spatial arm as the chain that it is."""
    if given["kind"] == "spatial":
        model, more = _chain_of(given), given
        renamed = {"posture": "joints", "rates": "joint_rates"}
        more = {name: given.get(old) for name, old in renamed.items()}
        acceleration = given.get("max_joint_acceleration")
    else:
        model = given["model"]
        model = models[model] if isinstance(model, str) else model
        more = given
        own = [joint.get("max_acceleration") for joint in model["joints"]]
        acceleration = given.get("max_acceleration", None if own[0] is None else own)
    base, posture = given.get("base", {}), np.array(more["posture"], dtype=float)
    rates = more.get("rates")
    return {
        "origin": np.array(base.get("origin", [0.0] * 3), dtype=float),
        "rotation": rotations(base.get("rotation", [1.0, 0.0, 0.0, 0.0])),
        "joints": model["joints"],
        "links": model["links"],
        "hand": model["hand"],
        "pairs": model.get("self_collision", []),
        "ignore": {tuple(pair) for pair in given.get("ignore", [])},
        "posture": posture,
        "rates": np.zeros(len(posture)) if rates is None else np.array(rates, dtype=float),
        "low": np.array([joint["range"][0] for joint in model["joints"]], dtype=float),
        "high": np.array([joint["range"][1] for joint in model["joints"]], dtype=float),
        "speed": np.array([joint["max_speed"] for joint in model["joints"]], dtype=float),
        "acceleration": None if acceleration is None else np.array(acceleration, dtype=float),
        "hand_speed": given.get("max_hand_speed"),
        "grasp": given["grasp"],
    }


def _chain_of(arm):
    """Return a spatial arm as an arm file's object: R_y, R_z, then R_x, R_z at the elbow."""
    zero, axes = [0.0] * 3, ([0, 1, 0], [0, 0, 1], [1, 0, 0], [0, 0, 1])
    joints = [
        {"axis": axis, "range": ends, "max_speed": fast, "origin": zero}
        for axis, ends, fast in zip(axes, arm["joint_range"], arm["max_joint_speed"], strict=True)
    ]
    joints[2]["origin"] = arm["upper_arm"]
    thick = arm.get("thickness", 0.0)
    bones = ((2, arm["upper_arm"]), (4, arm["forearm"]))
    links = [{"joint": k, "from": zero, "to": bone, "radius": thick} for k, bone in bones]
    axis = (np.array(arm["forearm"]) / np.linalg.norm(arm["forearm"])).tolist()
    return {
        "joints": joints,
        "links": links,
        "hand": {"joint": 4, "point": bones[1][1], "axis": axis},
    }


def rotations(quaternion):
    """Rotations (..., 3, 3) of quaternions (..., 4) w, x, y, z."""
    q = np.asarray(quaternion, dtype=float)
    w, x, y, z = np.moveaxis(q / np.linalg.norm(q, axis=-1, keepdims=True), -1, 0)
    rows = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ]
    return np.moveaxis(np.array(rows), (0, 1), (-2, -1))


def turns(axis, angle):
    """Rotations (..., 3, 3) about a unit axis (3,) by angles (...): the series of exp, summed."""
    x, y, z = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    angle = np.asarray(angle, dtype=float)[..., None, None]
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * (cross @ cross)


def frames_of(arm, joints):
    """Frames 0 to n along joints (k, n): rotations (n + 1, k, 3, 3), origins (n + 1, k, 3)."""
    k = len(joints)
    turn = np.broadcast_to(arm["rotation"], (k, 3, 3))
    at = np.broadcast_to(arm["origin"], (k, 3))
    all_turns, all_at, axes = [turn], [at], []
    for j, joint in enumerate(arm["joints"]):
        at = at + turn @ np.array(joint.get("origin", [0.0] * 3), dtype=float)
        turn = turn @ rotations(joint.get("rotation", [1.0, 0.0, 0.0, 0.0]))
        axis = np.array(joint["axis"], dtype=float)
        axis = axis / np.linalg.norm(axis)
        along = turn @ axis
        axes.append((at, along))
        if joint.get("type", "revolute") == "prismatic":
            at = at + joints[:, j, None] * along
        else:
            turn = turn @ turns(axis, joints[:, j])
        all_turns.append(turn)
        all_at.append(at)
    return np.array(all_turns), np.array(all_at), axes


def hand_of(arm, joints):
    """Hands (k, 3) and the axes (k, 3) along which they reach, of joints (k, n)."""
    turn, at, _ = frames_of(arm, joints)
    hand, j = arm["hand"], arm["hand"]["joint"]
    axis = np.array(hand.get("axis", [0.0, 0.0, 1.0]), dtype=float)
    point = at[j] + turn[j] @ np.array(hand["point"], dtype=float)
    return point, turn[j] @ (axis / np.linalg.norm(axis))


def links_of(arm, joints):
    """Ends (links, 2, k, 3) and radii (links,) of an arm's capsules along joints (k, n)."""
    turn, at, _ = frames_of(arm, joints)
    ends = [
        [at[k["joint"]] + turn[k["joint"]] @ np.array(k[e], dtype=float) for e in ("from", "to")]
        for k in arm["links"]
    ]
    return np.array(ends), np.array([link["radius"] for link in arm["links"]], dtype=float)


def hand_velocity(arm, joints, rates):
    """Velocities (k, 3) of the hand at joints (k, n) that move with rates (k, n)."""
    _, _, axes = frames_of(arm, joints)
    hand, _ = hand_of(arm, joints)
    velocity = np.zeros_like(hand)
    for j in range(arm["hand"]["joint"]):
        at, along = axes[j]
        prismatic = arm["joints"][j].get("type", "revolute") == "prismatic"
        way = along if prismatic else np.cross(along, hand - at)
        velocity += rates[:, j, None] * way
    return velocity


def size_of(arm):
    """Length with which errors of the arm's distances are compared."""
    parts = [np.linalg.norm(joint.get("origin", [0.0] * 3)) for joint in arm["joints"]]
    slides = [
        np.abs(joint["range"]).max() for joint in arm["joints"] if joint.get("type") == "prismatic"
    ]
    return float(np.linalg.norm(arm["hand"]["point"]) + sum(parts) + sum(slides))


# --- the movement ----------------------------------------------------------------------------


def _path_of(trajectory):
    """Columns of a trajectory as arrays."""
    return {name: np.array(column, dtype=float) for name, column in trajectory.items()}


def polynomials(path):
    """Joints between samples as polynomials (pieces, n, 4) of the time since the sample."""
    time, joints = path["time"], path["joints"]
    if len(time) == 1:
        c = np.zeros((1, joints.shape[1], 4))
        c[0, :, 0] = joints[0]
        c[0, :, 1] = path["rates"][0] if "rates" in path else 0.0
        return c
    span = np.diff(time)[:, None]
    slope = np.diff(joints, axis=0) / span
    c = np.zeros((*slope.shape, 4))
    c[:, :, 0], c[:, :, 1] = joints[:-1], slope
    if "rates" in path:
        first, last = path["rates"][:-1], path["rates"][1:]
        c[:, :, 1], c[:, :, 2] = first, (3.0 * slope - 2.0 * first - last) / span
        c[:, :, 3] = (first + last - 2.0 * slope) / span**2
    return c


def states(path, piece, since):
    """Joints and rates (k, n) in pieces (k,), at times since their begin (k,)."""
    c, s = polynomials(path)[piece], since[:, None]
    joints = c[:, :, 0] + s * (c[:, :, 1] + s * (c[:, :, 2] + s * c[:, :, 3]))
    return joints, c[:, :, 1] + s * (2.0 * c[:, :, 2] + 3.0 * s * c[:, :, 3])


def at_times(path, times):
    """Joints and rates (k, n) at times (k,)."""
    last = max(len(path["time"]) - 2, 0)
    piece = np.clip(np.searchsorted(path["time"], times, side="right") - 1, 0, last)
    return states(path, piece, times - path["time"][piece])


def _dense(path):
    """Many instants (k,), joints and rates (k, n): both ends of every piece and what is between."""
    time = path["time"]
    if len(time) == 1:
        return time, *states(path, np.zeros(1, dtype=int), np.zeros(1))
    pieces, sinces = [], []
    for k, span in enumerate(np.diff(time)):
        count = max(4, math.ceil(INSTANTS * span / time[-1]))
        pieces.append(np.full(count + 1, k))
        sinces.append(np.linspace(0.0, span, count + 1))
    piece, since = np.concatenate(pieces), np.concatenate(sinces)
    return time[piece] + since, *states(path, piece, since)


def _start(arm, path):
    complaints = []
    if np.abs(path["joints"][0] - arm["posture"]).max() > START:
        complaints.append("does not start on arm.posture")
    if "rates" in path and np.abs(path["rates"][0] - arm["rates"]).max() > START:
        complaints.append("does not start with arm.rates")
    return complaints


def _agreement(arm, path):
    hand, _ = hand_of(arm, path["joints"])
    apart = np.linalg.norm(hand - path["hand"], axis=1)
    allowed = GRANTED * np.maximum(1.0, np.linalg.norm(hand, axis=1))
    return [] if (apart <= allowed).all() else [f"hand and joints disagree by {apart.max():g}"]


def _limits(arm, path):
    """Ranges, speeds and accelerations of all joints, at extremes of their polynomials."""
    c, spans = polynomials(path), np.diff(path["time"]) if len(path["time"]) > 1 else np.zeros(1)
    complaints = []
    safe = np.where(spans > 0.0, spans, 1.0)[:, None]
    rounding = ROUNDING * (1.0 + np.abs(path["joints"]).max()) / safe
    reach = {"range": [], "speed": [], "acceleration": []}
    for k, span in enumerate(spans):
        for j in range(c.shape[1]):
            law = np.polynomial.Polynomial(c[k, j])
            low, high = _extremes(law, span)
            slack = GRANTED * max(1.0, abs(arm["low"][j]), abs(arm["high"][j]))
            if low < arm["low"][j] - slack or high > arm["high"][j] + slack:
                reach["range"].append(j)
            clock = ROUNDING * path["time"][k] / safe[k, 0]  # of times that are almost equal
            fast = np.abs(_extremes(law.deriv(), span)).max()
            if fast > arm["speed"][j] * (1.0 + GRANTED + clock) + rounding[k, 0]:
                reach["speed"].append(j)
            if arm["acceleration"] is not None:
                hard = np.abs(_extremes(law.deriv(2), span)).max()
                most = arm["acceleration"][j] * (1.0 + GRANTED + 2.0 * clock)
                if hard > most + 8.0 * rounding[k, 0] / safe[k, 0]:
                    reach["acceleration"].append(j)
    words = {"range": "leaves its range", "speed": "is too fast", "acceleration": "is forced"}
    for what, joints in reach.items():
        complaints += [f"joint {j} {words[what]}" for j in sorted(set(joints))]
    return complaints


def _extremes(law, span):
    """Least and largest value of a polynomial of at most three powers over [0, span]."""
    slope = np.trim_zeros(law.deriv().coef, "b")
    with np.errstate(all="ignore"):
        roots = np.polynomial.Polynomial(slope).roots() if len(slope) > 1 else np.zeros(0)
    roots = np.real(roots[np.isreal(roots)])
    values = law(np.concatenate([[0.0, span], roots[(roots > 0.0) & (roots < span)]]))
    return float(values.min()), float(values.max())


def _hand_speed(arm, time, joints, rates, path):
    most = arm["hand_speed"]
    if most is None:
        return []
    speed = np.linalg.norm(hand_velocity(arm, joints, rates), axis=1)
    k = int(speed.argmax())
    around = _around(time, k, CLOSER[0])
    near = at_times(path, around)
    fastest = max(speed[k], np.linalg.norm(hand_velocity(arm, *near), axis=1).max())
    spans = np.diff(path["time"])
    slack = ROUNDING * size_of(arm) / spans.min() if len(spans) else 0.0
    if fastest <= most * (1.0 + GRANTED) + slack:
        return []
    return [f"the hand is too fast: {fastest:.9g} at {time[k]:.6g} s, limit {most:g}"]


def _around(time, k, count):
    """Instants between those before and after instant k."""
    return np.linspace(time[max(k - 1, 0)], time[min(k + 1, len(time) - 1)], count)


# --- the bodies ------------------------------------------------------------------------------


def poses(body, times):
    """Centres (k, 3) and rotations (k, 3, 3), body to world, at times (k,)."""
    motion = body["motion"]
    return POSES[motion["kind"]](motion, np.asarray(times, dtype=float))


def _quadratic(motion, t):
    place = [
        np.array(motion[name], dtype=float) for name in ("position", "velocity", "acceleration")
    ]
    s = t[:, None]
    spin = np.array(motion.get("spin", [0.0] * 3), dtype=float)
    turn = np.broadcast_to(rotations(motion.get("orientation", [1.0, 0, 0, 0])), (len(t), 3, 3))
    if spin.any():
        turn = turns(spin, np.linalg.norm(spin) * t) @ turn
    return place[0] + s * place[1] + 0.5 * s * s * place[2], turn


def _piecewise(motion, t):
    starts = np.array([piece["start"] for piece in motion["pieces"]], dtype=float)
    which = np.maximum(np.searchsorted(starts, t, side="right") - 1, 0)
    at, turn = np.zeros((len(t), 3)), np.zeros((len(t), 3, 3))
    for k, piece in enumerate(motion["pieces"]):
        here = which == k
        at[here], turn[here] = _quadratic(piece, t[here] - starts[k])
    return at, turn


def _sampled(motion, t):
    times = np.array(motion["times"], dtype=float)
    at = np.array(motion["positions"], dtype=float)
    unturned = [[1.0, 0.0, 0.0, 0.0]] * len(times)
    q = np.array(motion.get("orientations", unturned), dtype=float)
    if len(times) == 1:
        return np.repeat(at, len(t), axis=0), np.repeat(rotations(q), len(t), axis=0)
    k = np.clip(np.searchsorted(times, t, side="right") - 1, 0, len(times) - 2)
    s = np.clip((t - times[k]) / (times[k + 1] - times[k]), 0.0, 1.0)[:, None]
    return at[k] + s * (at[k + 1] - at[k]), rotations(_between(q[k], q[k + 1], s))


def _between(p, q, s):
    """Quaternions at shares s (k, 1) of the short ways from p to q (k, 4)."""
    p, q = (v / np.linalg.norm(v, axis=1, keepdims=True) for v in (p, q))
    cosine = (p * q).sum(axis=1, keepdims=True)
    q, angle = np.where(cosine < 0.0, -q, q), np.arccos(np.minimum(np.abs(cosine), 1.0))
    straight = (1.0 - s) * p + s * q
    with np.errstate(all="ignore"):
        bent = (np.sin((1.0 - s) * angle) * p + np.sin(s * angle) * q) / np.sin(angle)
    return np.where(angle < 1e-6, straight, bent)


def _pendulum(motion, t):
    """Classical Runge-Kutta steps, and one from the last step before an instant to it."""
    pull, damping = motion["gravity"] / motion["length"], motion.get("damping", 0.0)
    until = math.ceil(1.0 + t.max(initial=0.0))
    step, grid = _swing(motion["angle"], motion["rate"], pull, damping, until)
    k = np.clip((t / step).astype(int), 0, len(grid) - 1)
    angle = _swung(*grid[k].T, t - k * step, pull, damping, np.sin)[0]
    axis = np.array(motion["axis"], dtype=float)
    axis = axis / np.linalg.norm(axis)
    down = np.array(motion["down"], dtype=float)
    along = turns(axis, angle) @ (down / np.linalg.norm(down))
    side = np.broadcast_to(axis, along.shape)
    turn = np.stack([np.cross(side, along), side, along], axis=-1)
    hang = motion.get("hang", motion["length"])
    return np.array(motion["pivot"], dtype=float) + hang * along, turn


@lru_cache(maxsize=64)
def _swing(angle, rate, pull, damping, until):
    """Step, and angles and rates (k, 2) of a pendulum at equal steps until a time."""
    step = SWING / max(math.sqrt(pull), abs(rate), damping, 1e-3)
    grid = [(angle, rate)]
    for _ in range(math.ceil(until / step)):
        grid.append(_swung(*grid[-1], step, pull, damping, math.sin))
    return step, np.array(grid)


def _swung(x, v, h, pull, damping, sin):
    """Angle and rate after a step h of the classical Runge-Kutta rule."""
    a = -pull * sin(x) - damping * v
    v2 = v + 0.5 * h * a
    b = -pull * sin(x + 0.5 * h * v) - damping * v2
    v3 = v + 0.5 * h * b
    c = -pull * sin(x + 0.5 * h * v2) - damping * v3
    v4 = v + h * c
    d = -pull * sin(x + h * v3) - damping * v4
    return x + h / 6.0 * (v + 2.0 * (v2 + v3) + v4), v + h / 6.0 * (a + 2.0 * (b + c) + d)


POSES = {
    "quadratic": _quadratic,
    "piecewise": _piecewise,
    "sampled": _sampled,
    "pendulum": _pendulum,
}


# --- distances -------------------------------------------------------------------------------


def room(shape, points):
    """Signed distances (k,) of points (k, 3) of a body's frame to its solid, negative inside."""
    x, y, z = np.abs(points).T
    across, kind = np.hypot(x, y), shape["kind"]
    if kind == "sphere":
        return np.hypot(across, z) - shape["radius"]
    if kind == "capsule":
        return np.hypot(across, np.maximum(z - shape["half_length"], 0.0)) - shape["radius"]
    if kind == "box":
        beyond = np.array([x, y, z]) - np.array(shape["half_extents"], dtype=float)[:, None]
    else:
        beyond = np.array([across - shape["radius"], z - shape["half_length"]])
    outside = np.sqrt((np.maximum(beyond, 0.0) ** 2).sum(axis=0))
    return outside + np.minimum(beyond.max(axis=0), 0.0)


def segment_room(shape, a, b):
    """Least signed distances (k,) of segments from a to b (k, 3) to a solid, in its frame.

    Signed distances of convex solids are convex along a segment: golden sections.
    """
    if shape["kind"] in ("sphere", "capsule"):
        half = shape.get("half_length", 0.0)
        ends = np.zeros_like(a), np.zeros_like(a)
        ends[0][:, 2], ends[1][:, 2] = -half, half
        return segments_apart(a, b, *ends) - shape["radius"]
    ratio, low, high = 0.5 * (math.sqrt(5.0) - 1.0), np.zeros(len(a)), np.ones(len(a))

    def at(s):
        return room(shape, a + s[:, None] * (b - a))

    best = np.minimum(at(low), at(high))
    left, right = high - ratio * (high - low), low + ratio * (high - low)
    at_left, at_right = at(left), at(right)
    for _ in range(34):
        best = np.minimum(best, np.minimum(at_left, at_right))
        lower = at_left <= at_right
        high, low = np.where(lower, right, high), np.where(lower, low, left)
        new = np.where(lower, high - ratio * (high - low), low + ratio * (high - low))
        found = at(new)
        left, right = np.where(lower, new, right), np.where(lower, left, new)
        at_left, at_right = np.where(lower, found, at_right), np.where(lower, at_left, found)
    return best


def point_apart(p, a, b):
    """Distances (k,) of points p (k, 3) to segments from a to b (k, 3)."""
    d = b - a
    length2 = (d * d).sum(axis=1)
    s = np.clip(((p - a) * d).sum(axis=1) / np.where(length2 > 0.0, length2, 1.0), 0.0, 1.0)
    return np.linalg.norm(p - a - s[:, None] * d, axis=1)


def segments_apart(a, b, c, d):
    """Distances (k,) of segments a to b and c to d (k, 3).

    The least is at an end of either, or where both lines are nearest if that is within both.
    """
    ends = [point_apart(a, c, d), point_apart(b, c, d), point_apart(c, a, b), point_apart(d, a, b)]
    best = np.min(ends, axis=0)
    u, v, w = b - a, d - c, a - c
    uu, vv, uv = (u * u).sum(axis=1), (v * v).sum(axis=1), (u * v).sum(axis=1)
    below = uu * vv - uv * uv
    crossing = below > 1e-12 * uu * vv
    below = np.where(crossing, below, 1.0)
    uw, vw = (u * w).sum(axis=1), (v * w).sum(axis=1)
    s, t = (uv * vw - vv * uw) / below, (uu * vw - uv * uw) / below
    within = crossing & (s >= 0.0) & (s <= 1.0) & (t >= 0.0) & (t <= 1.0)
    apart = np.linalg.norm(w + s[:, None] * u - t[:, None] * v, axis=1)
    return np.where(within, np.minimum(apart, best), best)


def ball_of(shape):
    """Radius of the ball around a solid's centre that holds it."""
    if shape["kind"] == "box":
        return math.hypot(*shape["half_extents"])
    radius, half = shape["radius"], shape.get("half_length", 0.0)
    return math.hypot(radius, half) if shape["kind"] == "cylinder" else radius + half


def into(centre, turn, points):
    """Points (k, 3) of the world in frames of centres (k, 3) and rotations (k, 3, 3)."""
    return (np.swapaxes(turn, 1, 2) @ (points - centre)[:, :, None])[:, :, 0]


def _gaps_of(body, times, starts, ends, radii, worst):
    """Signed distances (m, k) of capsules to a body; those above `worst` are only bounded."""
    (m, k, _), (centre, turn) = starts.shape, poses(body, times)
    centre, turn = np.tile(centre, (m, 1)), np.tile(turn, (m, 1, 1))
    start, end, thick = starts.reshape(-1, 3), ends.reshape(-1, 3), np.repeat(radii, k)
    gap = point_apart(centre, start, end) - ball_of(body["shape"]) - thick
    if body["shape"]["kind"] != "sphere":
        middle, half = 0.5 * (start + end), 0.5 * np.linalg.norm(end - start, axis=1)
        near = np.flatnonzero(gap <= worst)
        bound = room(body["shape"], into(centre[near], turn[near], middle[near]))
        gap[near] = np.maximum(gap[near], bound - half[near] - thick[near])
        near = np.flatnonzero(gap <= worst)
        a, b = (into(centre[near], turn[near], p[near]) for p in (start, end))
        gap[near] = segment_room(body["shape"], a, b) - thick[near]
    return gap.reshape(m, k)


def gaps(situation, arm, times, joints, worst=math.inf):
    """Return distances of links and obstacles (pairs, k), and of pairs of links (pairs, k)."""
    ends, radii = links_of(arm, joints)
    none = np.zeros((0, len(times)))
    outside, itself = [none], [none]
    for body in situation["bodies"]:
        asked = [i for i in range(len(radii)) if (i, body["name"]) not in arm["ignore"]]
        if body["role"] == "obstacle" and asked:
            links = ends[asked, 0], ends[asked, 1], radii[asked]
            outside.append(_gaps_of(body, times, *links, worst))
    for i, j in arm["pairs"]:
        itself.append((segments_apart(*ends[i], *ends[j]) - radii[i] - radii[j])[None])
    return np.concatenate(outside), np.concatenate(itself)


def least_at(situation, arm, times, joints, worst=math.inf):
    """Least distances to obstacles and to itself over some instants."""
    found = gaps(situation, arm, times, joints, worst)
    return tuple(float(gap.min(initial=math.inf)) for gap in found)


def _least(situation, arm, path, time, joints):
    """Least distances to obstacles and to itself over a movement, finer where they are small."""
    least = least_at(situation, arm, time[::24], joints[::24])
    margin = CLOSE * size_of(arm)
    worst = max(least[0], 0.0) + margin
    found = gaps(situation, arm, time, joints, worst)
    spots = set()
    for k, gap in enumerate(found):
        rows = gap[gap.min(axis=1, initial=math.inf) <= max(least[k], 0.0) + margin]
        spots |= set(rows.argmin(axis=1).tolist())
    if math.isfinite(worst):
        least = tuple(
            min(a, float(g.min(initial=math.inf))) for a, g in zip(least, found, strict=True)
        )
    for spot in sorted(spots):
        around, k = time, spot
        for count in CLOSER:
            around = _around(around, k, count)
            near = gaps(situation, arm, around, at_times(path, around)[0], worst)
            least = tuple(
                min(a, float(g.min(initial=math.inf))) for a, g in zip(least, near, strict=True)
            )
            k = int(np.concatenate(near).min(axis=0).argmin())
    return least


# --- the verdict -----------------------------------------------------------------------------


def _overlaps(arm, situation, solution, obstacles, itself):
    complaints, reported = [], solution["clearance"]
    if obstacles < -GRANTED:
        complaints.append(f"touches, clearance {obstacles:g}")
    if itself < -GRANTED:
        complaints.append(f"touches itself, {-itself:g} deep")
    if math.isinf(obstacles) != (reported is None):
        complaints.append("clearance is null exactly without obstacles")
    elif reported is not None and not abs(reported - obstacles) <= CLEARANCE * size_of(arm):
        complaints.append(f"clearance is {obstacles:g}, reported as {reported}")
    return complaints


def _caught(situation, solution, arm, path):
    """Whether hand and axis are where each catch says."""
    complaints = []
    for catch in solution["catches"]:
        body = next(b for b in situation["bodies"] if b["name"] == catch["body"])
        times = np.array([catch["time"]])
        hand, axis = hand_of(arm, at_times(path, times)[0])
        centre, turn = poses(body, times)
        away = float(room(body["shape"], (hand - centre) @ turn[0])[0])
        if away > arm["grasp"] + GRANTED * max(1.0, arm["grasp"]):
            complaints.append(f"misses {body['name']}: {away:.9g}, grasp {arm['grasp']:g}")
        if "approach" in body:
            wanted = turn[0] @ np.array(body["approach"]["axis"], dtype=float)
            cosine = float(wanted @ axis[0]) / np.linalg.norm(wanted)
            sine = np.linalg.norm(np.cross(wanted, axis[0])) / np.linalg.norm(wanted)
            angle, within = math.atan2(sine, cosine), body["approach"]["within"]
            if angle > within + GRANTED * max(1.0, within):
                complaints.append(f"approaches {body['name']} at {angle:.9g}, within {within:g}")
    return complaints
