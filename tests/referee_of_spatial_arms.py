"""An independent referee of catches in space: the exchange contract alone, JSON in, verdict out.

It shares nothing with the package.  Kinematics, motion of bodies, distances and bounds are its
own; the clearance is found by bisection with bounds of motion, so that nothing is missed between
samples.  Compiled, since it has to judge tens of thousands of plans.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit

LIMIT = 1e-6  # relative, as the contract grants, of ranges and limits
AGREEMENT = 1e-6  # of hand and elbow with the joints, as the contract says
START = 1e-9  # of joints and rates at t = 0 [rad, rad/s]
ROUNDING = 1e-15  # of sums of joints, relative to their size
HAIR = 1e-9  # of distances, relative to the arm's reach
CLEARANCE = 1e-4  # to which the clearance is found, relative to the arm's reach
REPORTED = 5e-4  # by how much the reported clearance may be off, relative to the arm's reach
SWING = 2e-3  # step of a pendulum, over the time in which it changes
MOST = 2_000_000  # instants that are looked at for one plan: more is a complaint

FIELDS = {"time", "joints", "hand", "elbow"}
SPHERE, BOX, CAPSULE, CYLINDER = 0, 1, 2, 3
SHAPES = {"sphere": SPHERE, "box": BOX, "capsule": CAPSULE, "cylinder": CYLINDER}


@dataclass(frozen=True)
class Verdict:
    """What the referee found: an empty list of complaints means that every promise is kept."""

    complaints: list[str]
    clearance: float  # at most CLEARANCE of the reach above the true one; inf without obstacles
    instants: int = 0  # looked at


def judge(situation: dict, solution: dict) -> Verdict:
    """Check all that the contract promises of a caught plan.

    Parameters
    ----------
    situation : dict
        In the format ``gcm-learn/situation@2``.
    solution : dict
        In the format ``gcm-learn/solution@2``.
    """
    complaints = _form(situation, solution)
    if complaints:
        return Verdict(complaints, math.nan)
    arm, path = situation["arm"], solution["trajectory"]
    knots, curve = curve_of(arm, path)
    geometry = geometry_of(arm)
    complaints = [*_start(arm, path), *_agreement(geometry, path), *_limits(arm, knots, curve)]
    complaints += _hand_speed(arm, knots, curve, geometry)
    found, instants = lowest_room(situation, knots, curve, geometry)
    complaints += _clearance(situation, solution, geometry, found)
    if instants >= MOST:
        complaints.append(f"clearance cannot be told after {instants} instants")
    complaints += _catch(situation, solution, geometry)
    return Verdict(complaints, found - arm.get("thickness", 0.0), instants)


# --- the numbers of a plan -------------------------------------------------------------------


def _form(situation, solution):
    """What does not fit together in the plan's numbers; nothing else is asked if anything."""
    if solution["status"] != "caught":
        return [f"status is {solution['status']}"]
    path = solution["trajectory"]
    wanted = FIELDS | ({"rates"} if _accelerates(situation["arm"]) else set())
    if set(path) != wanted:
        return [f"the trajectory holds {sorted(path)}, not {sorted(wanted)}"]
    columns = {name: np.asarray(path[name], dtype=float) for name in wanted}
    n = len(columns["time"])
    sizes = {"time": (n,), "joints": (n, 4), "rates": (n, 4), "hand": (n, 3), "elbow": (n, 3)}
    odd = [name for name, column in columns.items() if column.shape != sizes[name] or n == 0]
    if odd:
        return [f"{name} has the shape {columns[name].shape}" for name in odd]
    targets = [body["name"] for body in situation["bodies"] if body["role"] == "target"]
    numbers = [*columns.values(), np.float64(solution["catch_time"])]
    fits = {
        "format is gcm-learn/solution@2": solution["format"] == "gcm-learn/solution@2",
        "name is the situation's": solution["name"] == situation.get("name", ""),
        "numbers are finite": all(np.isfinite(column).all() for column in numbers),
        "starts at t = 0": columns["time"][0] == 0.0,
        "times increase": bool((np.diff(columns["time"]) > 0.0).all()),
        "ends at catch_time": columns["time"][-1] == solution["catch_time"],
        "catch is within the horizon": solution["catch_time"] <= situation["horizon"],
        "the catch is a target": solution["catch_body"] in targets,
    }
    return [f"broken: {promise}" for promise, kept in fits.items() if not kept]


def _accelerates(arm):
    """Whether joints move on cubic curves."""
    return "max_joint_acceleration" in arm


def curve_of(arm, path):
    """Knots (n,) and cubic polynomials (n - 1, 4 joints, 4 powers) of local time between them.

    A plan of one sample has one polynomial, over no time.
    """
    time, joints = np.array(path["time"], dtype=float), np.array(path["joints"], dtype=float)
    if len(time) == 1:
        time, joints = np.repeat(time, 2), np.repeat(joints, 2, axis=0)
    span = np.diff(time)[:, None]
    span = np.where(span > 0.0, span, 1.0)
    slope = np.diff(joints, axis=0) / span
    curve = np.zeros((len(span), 4, 4))
    curve[:, :, 0], curve[:, :, 1] = joints[:-1], slope
    if _accelerates(arm):
        rates = np.array(path["rates"], dtype=float)
        first, last = (rates, rates) if len(rates) == 1 else (rates[:-1], rates[1:])
        if time[-1] == time[0]:
            slope = first
        curve[:, :, 1] = first
        curve[:, :, 2] = (3.0 * slope - 2.0 * first - last) / span
        curve[:, :, 3] = (first + last - 2.0 * slope) / span**2
    return time, curve


def _start(arm, path):
    """Whether the plan starts as the arm does."""
    complaints = []
    if np.abs(np.subtract(path["joints"][0], arm["joints"])).max() > START:
        complaints.append("does not start on arm.joints")
    if _accelerates(arm):
        rates = arm.get("joint_rates", [0.0] * 4)
        if np.abs(np.subtract(path["rates"][0], rates)).max() > START:
            complaints.append("does not start with arm.joint_rates")
    return complaints


def _agreement(geometry, path):
    """Whether hand and elbow follow from the joints at the samples."""
    places = _places(np.asarray(path["joints"], dtype=float), geometry)
    complaints = []
    for name, found in (("elbow", places[:, :3]), ("hand", places[:, 3:])):
        apart = np.abs(found - np.asarray(path[name], dtype=float)).max()
        if apart > AGREEMENT:
            complaints.append(f"{name} and joints disagree by {apart:g}")
    return complaints


def _limits(arm, knots, curve):
    """Ranges, rates and accelerations of the joints at every instant."""
    low, high = np.array(arm["joint_range"], dtype=float).T
    # A limit's relative slack, and what rounding may do to differences of joints and of times.
    size = np.abs(curve[:, :, 0]).max(axis=0) + np.abs(np.diff(curve[:, :, 0], axis=0)).sum(axis=0)
    span = np.where(np.diff(knots) > 0.0, np.diff(knots), 1.0)[:, None]
    complaints = []
    least, most = extremes(curve, np.diff(knots))
    low, high = low - LIMIT * np.abs(low) - 1e-12, high + LIMIT * np.abs(high) + 1e-12
    for k in np.flatnonzero((least < low).any(axis=0) | (most > high).any(axis=0)):
        complaints.append(f"joint {k} leaves its range")
    rates, bends = curve[:, :, 1:] * (1.0, 2.0, 3.0), curve[:, :, 2:] * (2.0, 6.0)
    limit = np.array(arm["max_joint_speed"], dtype=float)
    shift = knots[1:, None] / span
    slack = limit * (LIMIT + 4.0 * ROUNDING * shift) + 8.0 * ROUNDING * (size + 1.0) / span
    fastest = np.maximum(*map(np.abs, extremes(rates, np.diff(knots))))
    for k in np.flatnonzero((fastest > limit + slack).any(axis=0)):
        complaints.append(f"joint {k} is too fast")
    if _accelerates(arm):
        limit = np.array(arm["max_joint_acceleration"], dtype=float)
        slack = limit * LIMIT + 64.0 * ROUNDING * (size + 1.0) / span**2
        hardest = np.maximum(*map(np.abs, extremes(bends, np.diff(knots))))
        for k in np.flatnonzero((hardest > limit + slack).any(axis=0)):
            complaints.append(f"joint {k} accelerates too much")
    return complaints


def extremes(curve, span):
    """Least and largest values (n, 4) of polynomials of up to four powers over [0, span (n,)]."""
    powers = curve.shape[2]
    c = np.concatenate([curve, np.zeros((*curve.shape[:2], 4 - powers))], axis=2)
    whole = np.broadcast_to(span[:, None], c.shape[:2])
    a, b, d = 3.0 * c[:, :, 3], 2.0 * c[:, :, 2], c[:, :, 1]
    with np.errstate(all="ignore"):
        # the roots of the derivative, by the form that does not cancel
        q = -0.5 * (b + np.copysign(np.sqrt(np.maximum(b * b - 4.0 * a * d, 0.0)), b))
        places = [np.zeros_like(whole), whole, q / a, d / q]
    values = []
    for s in places:
        s = np.clip(np.where(np.isfinite(s), s, 0.0), 0.0, whole)
        values.append(((c[:, :, 3] * s + c[:, :, 2]) * s + c[:, :, 1]) * s + c[:, :, 0])
    return np.min(values, axis=0), np.max(values, axis=0)


def _hand_speed(arm, knots, curve, geometry):
    """Whether the hand keeps its limit at every instant."""
    limit = arm.get("max_hand_speed")
    if limit is None:
        return []
    rounding = 16.0 * ROUNDING * (1.0 + np.abs(curve[:, :, 0]).max()) * geometry[18]
    slack = LIMIT * limit + rounding / np.where(np.diff(knots) > 0.0, np.diff(knots), 1.0)
    broken, fastest, at, instants = _hastiest(knots, curve, geometry, (limit + slack) ** 2, MOST)
    if broken:
        return [f"the hand is too fast: {math.sqrt(fastest):.9g} at {at:.6g} s, limit {limit:g}"]
    if instants >= MOST:
        return [f"hand speed cannot be told after {instants} instants"]
    return []


def lowest_room(situation, knots, curve, geometry):
    """Smallest distance of bones and obstacles over the movement, and how often it was asked."""
    obstacles = [body for body in situation["bodies"] if body["role"] == "obstacle"]
    if not obstacles:
        return math.inf, 0
    thickness = situation["arm"].get("thickness", 0.0)
    reach = geometry[18]
    steps = swing_steps(obstacles, knots[-1])
    rows, tables = map(
        np.array, zip(*(body_of(b, knots[-1], steps) for b in obstacles), strict=True)
    )
    touch = max(thickness - HAIR * reach, 0.0)
    hair, close = HAIR * reach, CLEARANCE * reach
    least, instants = _lowest(knots, curve, geometry, rows, tables, (touch, hair, close), MOST)
    return max(least, 0.0), instants


def _clearance(situation, solution, geometry, found):
    """Whether nothing is touched, and whether the clearance is what is reported."""
    thickness, reported = situation["arm"].get("thickness", 0.0), solution["clearance"]
    if math.isinf(found):
        return [] if reported is None else ["clearance without obstacles"]
    complaints = []
    free = found - thickness
    if found <= max(thickness - HAIR * geometry[18], 0.0):
        complaints.append(f"touches, clearance {free:g}")
    if reported is None or not abs(reported - free) <= REPORTED * geometry[18]:
        complaints.append(f"clearance is {free:g}, reported as {reported}")
    return complaints


def _catch(situation, solution, geometry):
    """Whether the hand is within grasp at the end."""
    body = next(b for b in situation["bodies"] if b["name"] == solution["catch_body"])
    end = solution["catch_time"]
    hand = _places(np.array(solution["trajectory"]["joints"][-1:], dtype=float), geometry)[0, 3:]
    away = signed_distance(body, end, hand)
    if away <= situation["arm"]["grasp"] + HAIR * max(geometry[18], np.abs(hand).max()):
        return []
    return [f"the hand misses the target: {away:.9g}, grasp {situation['arm']['grasp']:g}"]


def signed_distance(body, t, points):
    """Signed distances of points (..., 3) of the world to a body's solid at t, negative inside."""
    row, table = body_of(body, t, swing_steps([body], t))
    pose = pose_of(row, table, t)
    x, y, z = np.moveaxis(np.abs((np.asarray(points) - pose[:3]) @ pose[3:].reshape(3, 3)), -1, 0)
    shape, across = body["shape"], np.hypot(x, y)
    if shape["kind"] == "sphere":
        return np.hypot(across, z) - shape["radius"]
    if shape["kind"] == "capsule":
        return np.hypot(across, np.maximum(z - shape["half_length"], 0.0)) - shape["radius"]
    if shape["kind"] == "box":
        beyond = [c - half for c, half in zip((x, y, z), shape["half_extents"], strict=True)]
    else:
        beyond = [across - shape["radius"], z - shape["half_length"]]
    outside = np.sqrt(sum(np.maximum(e, 0.0) ** 2 for e in beyond))
    return np.where(outside > 0.0, outside, np.max(beyond, axis=0))


# --- the arm ---------------------------------------------------------------------------------


def geometry_of(arm):
    """Numbers of an arm (19,): origin, rotation by rows is 9 of it, bones, reach."""
    base = arm.get("base", {})
    rotation = of_quaternion(base.get("rotation", [1.0, 0.0, 0.0, 0.0]))
    upper, fore = arm["upper_arm"], arm["forearm"]
    reach = math.hypot(*upper) + math.hypot(*fore)
    return np.array([*base.get("origin", [0.0] * 3), *upper, *fore, *rotation.ravel(), reach])


def of_quaternion(quaternion):
    """Rotation (3, 3) of (w, x, y, z), as the product q e q* for every unit vector e."""
    q = np.array(quaternion, dtype=float)
    q = q / np.linalg.norm(q)
    w, v = q[0], q[1:]
    columns = [e + 2.0 * np.cross(v, np.cross(v, e) + w * e) for e in np.eye(3)]
    return np.stack(columns, axis=1)


def pose_of(row, table, t):
    """Centre and rotation by rows (12,) of a body of `body_of` at time t."""
    return np.array(_pose(row, table, t))


def limb_room(row, pose, elbow, hand, geometry):
    """Distance of both bones to a body at its pose; 0 or less where they meet."""
    place = tuple(map(float, pose)), tuple(map(float, elbow)), tuple(map(float, hand))
    return _limb_room(row, *place, geometry, (0.0, 0.0, 0.0))[1]


def hand_places(arm, joints):
    """Hands (n, 3) in the world, of joints (n, 4)."""
    return _places(np.ascontiguousarray(joints), geometry_of(arm))[:, 3:]


def forward(arm, joints):
    """Elbow and hand (3,) each in the world, of joints (4,)."""
    place = _places(np.array([joints], dtype=float), geometry_of(arm))[0]
    return place[:3], place[3:]


@njit(cache=True)
def _turned(a, b, da, db, angle, rate):
    """A vector's two parts across an axis and their rates, when it is turned about that axis."""
    c, s = math.cos(angle), math.sin(angle)
    x, y = c * a - s * b, s * a + c * b
    return x, y, c * da - s * db - rate * y, s * da + c * db + rate * x


@njit(cache=True)
def _bone(x, y, z, dx, dy, dz, q, dq):
    """A vector of the upper arm's frame and its rate, in the base's frame."""
    x, y, dx, dy = _turned(x, y, dx, dy, q[1], dq[1])
    z, x, dz, dx = _turned(z, x, dz, dx, q[0], dq[0])  # about y: from z to x
    return x, y, z, dx, dy, dz


@njit(cache=True)
def _limb(q, dq, geo):
    """Elbow and hand in the base's frame, and their velocities: twelve numbers."""
    e = _bone(geo[3], geo[4], geo[5], 0.0, 0.0, 0.0, q, dq)
    x, y, dx, dy = _turned(geo[6], geo[7], 0.0, 0.0, q[3], dq[3])
    y, z, dy, dz = _turned(y, geo[8], dy, 0.0, q[2], dq[2])
    f = _bone(x, y, z, dx, dy, dz, q, dq)
    return (
        (e[0], e[1], e[2]),
        (e[0] + f[0], e[1] + f[1], e[2] + f[2]),
        (e[3], e[4], e[5]),
        (e[3] + f[3], e[4] + f[4], e[5] + f[5]),
    )


@njit(cache=True)
def _world(p, geo):
    """A point of the base's frame in the world."""
    return (
        geo[0] + geo[9] * p[0] + geo[10] * p[1] + geo[11] * p[2],
        geo[1] + geo[12] * p[0] + geo[13] * p[1] + geo[14] * p[2],
        geo[2] + geo[15] * p[0] + geo[16] * p[1] + geo[17] * p[2],
    )


@njit(cache=True)
def _places(joints, geo):
    """Elbows and hands (n, 6) in the world."""
    out, still = np.empty((joints.shape[0], 6)), np.zeros(4)
    for k in range(joints.shape[0]):
        elbow, hand, _, _ = _limb(joints[k], still, geo)
        out[k, 0], out[k, 1], out[k, 2] = _world(elbow, geo)
        out[k, 3], out[k, 4], out[k, 5] = _world(hand, geo)
    return out


@njit(cache=True)
def _at(c, s, q, dq):
    """Joints and their rates at local time s of polynomials c (4, 4)."""
    for k in range(4):
        q[k] = ((c[k, 3] * s + c[k, 2]) * s + c[k, 1]) * s + c[k, 0]
        dq[k] = (3.0 * c[k, 3] * s + 2.0 * c[k, 2]) * s + c[k, 1]


@njit(cache=True)
def _bounds(c, a, b, out):
    """Bounds (3, 4) of the first three derivatives of the joints over local times [a, b]."""
    for k in range(4):
        first = (3.0 * c[k, 3] * a + 2.0 * c[k, 2]) * a + c[k, 1]
        last = (3.0 * c[k, 3] * b + 2.0 * c[k, 2]) * b + c[k, 1]
        bend = max(abs(2.0 * c[k, 2] + 6.0 * c[k, 3] * a), abs(2.0 * c[k, 2] + 6.0 * c[k, 3] * b))
        out[0, k] = max(abs(first), abs(last))
        if c[k, 3] != 0.0:
            top = -c[k, 2] / (3.0 * c[k, 3])
            if a < top < b:
                out[0, k] = max(out[0, k], abs(c[k, 1] + c[k, 2] * top))
        out[1, k], out[2, k] = bend, abs(6.0 * c[k, 3])


@njit(cache=True)
def _hastiest(knots, curve, geo, limits, patience):
    """Whether the hand's squared speed exceeds its limit in any piece (n - 1,); such a square and
    when it is, and how many instants were looked at.

    The n-th derivative of a vector that rotations turn one after the other is at most its length
    times the n-th complete Bell polynomial of the sums of the angles' derivatives. So the second
    derivative of the square is bounded, and a chord plus its bow bounds the square.
    """
    q, dq, over = np.empty(4), np.empty(4), np.empty((3, 4))
    stack = np.empty((200, 4))
    upper = math.sqrt(geo[3] ** 2 + geo[4] ** 2 + geo[5] ** 2)
    fore = math.sqrt(geo[6] ** 2 + geo[7] ** 2 + geo[8] ** 2)
    instants = 0
    for piece in range(curve.shape[0]):
        most = limits[piece]
        c, span = curve[piece], knots[piece + 1] - knots[piece]
        stack[0, 0], stack[0, 1] = 0.0, span
        for k in range(2):
            _at(c, stack[0, k], q, dq)
            v = _limb(q, dq, geo)[3]
            stack[0, 2 + k] = v[0] ** 2 + v[1] ** 2 + v[2] ** 2
        held = 1
        while held > 0:
            held -= 1
            a, b, fa, fb = stack[held, 0], stack[held, 1], stack[held, 2], stack[held, 3]
            instants += 1
            if max(fa, fb) > most or instants >= patience:
                when = knots[piece] + (a if fa > fb else b)
                return max(fa, fb) > most, max(fa, fb), when, instants
            _bounds(c, a, b, over)
            n1, n2, n3 = 0.0, 0.0, 0.0
            for part in range(2):
                size = fore if part else upper
                x, y, z = over[0, 0] + over[0, 1], over[1, 0] + over[1, 1], over[2, 0] + over[2, 1]
                if part:
                    x, y, z = over[0].sum(), over[1].sum(), over[2].sum()
                n1 += size * x
                n2 += size * (x * x + y)
                n3 += size * (x * x * x + 3.0 * x * y + z)
            if n1 * n1 <= most:
                continue
            if max(fa, fb) + (b - a) ** 2 * (n2 * n2 + n1 * n3) / 4.0 <= most:
                continue
            m = 0.5 * (a + b)
            if not a < m < b or held > 190:
                continue
            _at(c, m, q, dq)
            v = _limb(q, dq, geo)[3]
            fm = v[0] ** 2 + v[1] ** 2 + v[2] ** 2
            stack[held, 0], stack[held, 1], stack[held, 2], stack[held, 3] = m, b, fm, fb
            held += 1
            stack[held, 0], stack[held, 1], stack[held, 2], stack[held, 3] = a, m, fa, fm
            held += 1
    return False, 0.0, 0.0, instants


# --- the bodies ------------------------------------------------------------------------------


def swing_steps(bodies, end):
    """Into how many steps pendulums cut the time from 0 to `end`."""
    fastest = 1e-3
    for motion in (body["motion"] for body in bodies):
        if motion["kind"] == "pendulum":
            fastest = max(fastest, math.sqrt(motion["gravity"] / motion["length"]))
            fastest = max(fastest, abs(motion["rate"]), motion.get("damping", 0.0))
    return int(end * fastest / SWING) + 2


def body_of(body, end, steps):
    """A body as numbers (30,) and the table (steps + 1, 2) of its swing from 0 to `end`.

    Kind, three sizes, the radius of the ball around it; then of a flight 0, position, velocity,
    acceleration, orientation by rows, spin; of a swing 1, pivot, axis, down, hang, step, fastest.
    """
    shape, motion = body["shape"], body["motion"]
    size = shape.get("half_extents", [shape.get("radius", 0.0), shape.get("half_length", 0.0), 0.0])
    ball = {"sphere": size[0], "capsule": size[0] + size[1], "box": math.hypot(*size)}
    ball = ball.get(shape["kind"], math.hypot(*size[:2]))
    table = np.zeros((steps + 1, 2))
    if motion["kind"] == "quadratic":
        turn = of_quaternion(motion.get("orientation", [1.0, 0.0, 0.0, 0.0])).ravel()
        moved = [*motion["position"], *motion["velocity"], *motion["acceleration"]]
        law = [0.0, *moved, *turn, *motion.get("spin", [0.0] * 3)]
    else:
        step, pull = max(end, 1e-9) / steps, motion["gravity"] / motion["length"]
        damping, hang = motion.get("damping", 0.0), motion.get("hang", motion["length"])
        _swing(table, step, pull, damping, motion["angle"], motion["rate"])
        fastest = np.abs(table[:, 1]).max()
        fastest += step * (pull + damping * (fastest + step * pull))
        axes = [_unit(motion["axis"]), _unit(motion["down"])]
        law = [1.0, *motion["pivot"], *axes[0], *axes[1], hang, step, fastest]
    row = np.zeros(30)
    row[: 5 + len(law)] = [SHAPES[shape["kind"]], *size, ball, *law]
    return row, table


def _unit(vector):
    return np.array(vector, dtype=float) / math.hypot(*vector)


@njit(cache=True)
def _swing(table, h, pull, damping, angle, rate):
    """Angles and rates of a pendulum at equal steps, by the classical Runge-Kutta rule."""
    x, v = angle, rate
    for k in range(table.shape[0]):
        table[k, 0], table[k, 1] = x, v
        a1 = -pull * math.sin(x) - damping * v
        x2, v2 = x + 0.5 * h * v, v + 0.5 * h * a1
        a2 = -pull * math.sin(x2) - damping * v2
        x3, v3 = x + 0.5 * h * v2, v + 0.5 * h * a2
        a3 = -pull * math.sin(x3) - damping * v3
        x4, v4 = x + h * v3, v + h * a3
        a4 = -pull * math.sin(x4) - damping * v4
        x += h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4)
        v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)


@njit(cache=True)
def _spun(v, axis, c, s):
    """A vector turned about a unit axis, by Rodrigues' formula."""
    along = (1.0 - c) * (axis[0] * v[0] + axis[1] * v[1] + axis[2] * v[2])
    return (
        c * v[0] + s * (axis[1] * v[2] - axis[2] * v[1]) + along * axis[0],
        c * v[1] + s * (axis[2] * v[0] - axis[0] * v[2]) + along * axis[1],
        c * v[2] + s * (axis[0] * v[1] - axis[1] * v[0]) + along * axis[2],
    )


@njit(cache=True)
def _pose(row, table, t):
    """Centre and rotation by rows, body to world, at time t: twelve numbers."""
    if row[5] == 0.0:
        spin = math.sqrt(row[24] ** 2 + row[25] ** 2 + row[26] ** 2)
        c, s, axis = math.cos(spin * t), math.sin(spin * t), (0.0, 0.0, 1.0)
        if spin > 0.0:
            axis = (row[24] / spin, row[25] / spin, row[26] / spin)
        x = _spun((row[15], row[18], row[21]), axis, c, s)
        y = _spun((row[16], row[19], row[22]), axis, c, s)
        z = _spun((row[17], row[20], row[23]), axis, c, s)
        px = row[6] + t * (row[9] + 0.5 * t * row[12])
        py = row[7] + t * (row[10] + 0.5 * t * row[13])
        pz = row[8] + t * (row[11] + 0.5 * t * row[14])
    else:
        k = min(max(int(t / row[16]), 0), table.shape[0] - 2)
        s = min(max(t / row[16] - k, 0.0), 1.0)
        chord = table[k + 1, 0] - table[k, 0]
        bow = (1.0 - s) * (row[16] * table[k, 1] - chord) + s * (chord - row[16] * table[k + 1, 1])
        angle = table[k, 0] + s * chord + s * (1.0 - s) * bow
        y = (row[9], row[10], row[11])
        z = _spun((row[12], row[13], row[14]), y, math.cos(angle), math.sin(angle))
        x = (y[1] * z[2] - y[2] * z[1], y[2] * z[0] - y[0] * z[2], y[0] * z[1] - y[1] * z[0])
        px, py, pz = row[6] + row[15] * z[0], row[7] + row[15] * z[1], row[8] + row[15] * z[2]
    return px, py, pz, x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]


@njit(cache=True)
def _body_way(row, t, half):
    """Bound of the way of any point of a body within `half` before or after t."""
    if row[5] == 1.0:
        return half * row[17] * (row[15] + row[4])
    vx, vy, vz = row[9] + row[12] * t, row[10] + row[13] * t, row[11] + row[14] * t
    speed = math.sqrt(vx * vx + vy * vy + vz * vz)
    speed += 0.5 * half * math.sqrt(row[12] ** 2 + row[13] ** 2 + row[14] ** 2)
    if row[0] != SPHERE:
        speed += row[4] * math.sqrt(row[24] ** 2 + row[25] ** 2 + row[26] ** 2)
    return half * speed


# --- distances -------------------------------------------------------------------------------


@njit(cache=True)
def _outward(kind, h, x, y, z):
    """Vector from the nearest point of a solid, or of the axis of a round one, to a point."""
    if kind == BOX:
        ox = x - min(max(x, -h[0]), h[0])
        oy = y - min(max(y, -h[1]), h[1])
        return ox, oy, z - min(max(z, -h[2]), h[2])
    if kind == SPHERE:
        return x, y, z
    oz = z - min(max(z, -h[1]), h[1])
    if kind == CAPSULE:
        return x, y, oz
    across = math.sqrt(x * x + y * y)
    share = 1.0 - h[0] / across if across > h[0] else 0.0
    return share * x, share * y, oz


@njit(cache=True)
def _nearest(kind, h, p, d, w0, w1):
    """Least room of a segment p + s d, s in [0, 1], in the body's frame, less w0 + s (w1 - w0).

    The room is convex in s, so its slope changes sign once: bisection. For round solids it is
    signed, for the others 0 inside.

    Returns
    -------
    bound : float
        The least difference.
    room : float
        The room of the point where it is.
    """
    low, high = 0.0, 1.0
    s = 0.0
    for k in range(36):
        s = float(k) if k < 2 else 0.5 * (low + high)  # both ends first
        x, y, z = _outward(kind, h, p[0] + s * d[0], p[1] + s * d[1], p[2] + s * d[2])
        length = math.sqrt(x * x + y * y + z * z)
        slope = w0 - w1
        if length > 0.0:
            slope += (x * d[0] + y * d[1] + z * d[2]) / length
        if k == 0:
            if slope >= 0.0:
                break
        elif k == 1:
            if slope <= 0.0:
                break
        elif slope > 0.0:
            high = s
        else:
            low = s
    x, y, z = _outward(kind, h, p[0] + s * d[0], p[1] + s * d[1], p[2] + s * d[2])
    room = math.sqrt(x * x + y * y + z * z)
    if kind == SPHERE or kind == CAPSULE:
        room -= h[0]
    return room - w0 - s * (w1 - w0), room


@njit(cache=True)
def _to_body(pose, p):
    """A point of the world in a body's frame."""
    x, y, z = p[0] - pose[0], p[1] - pose[1], p[2] - pose[2]
    return (
        pose[3] * x + pose[6] * y + pose[9] * z,
        pose[4] * x + pose[7] * y + pose[10] * z,
        pose[5] * x + pose[8] * y + pose[11] * z,
    )


@njit(cache=True)
def _limb_room(row, pose, elbow, hand, geo, ways):
    """Least room of both bones less the ways of shoulder (none), elbow, hand and body."""
    kind, size = int(row[0]), (row[1], row[2], row[3])
    a = _to_body(pose, (geo[0], geo[1], geo[2]))
    b, c = _to_body(pose, elbow), _to_body(pose, hand)
    upper = (b[0] - a[0], b[1] - a[1], b[2] - a[2])
    fore = (c[0] - b[0], c[1] - b[1], c[2] - b[2])
    first, room = _nearest(kind, size, a, upper, 0.0, ways[0])
    second, other = _nearest(kind, size, b, fore, ways[0], ways[1])
    return min(first, second) - ways[2], min(room, other)


@njit(cache=True)
def _lowest(knots, curve, geo, rows, tables, gaps, patience):
    """Least room of limb and obstacles over a movement, by bisection, and the instants asked.

    `gaps`: the room at which something is touched, the way that is as good as none, and how much
    too large the result may be where nothing is touched. Half a span from its middle no point of
    the limb comes farther than its speed bound allows, nor any point of the body.
    """
    touch, hair, close = gaps
    q, dq, over = np.empty(4), np.empty(4), np.empty((3, 4))
    stack = np.empty((200, 2))
    upper = math.sqrt(geo[3] ** 2 + geo[4] ** 2 + geo[5] ** 2)
    fore = math.sqrt(geo[6] ** 2 + geo[7] ** 2 + geo[8] ** 2)
    best, instants = 1e300, 0
    for piece in range(curve.shape[0]):
        c = curve[piece]
        for b in range(rows.shape[0]):
            stack[0, 0], stack[0, 1] = 0.0, knots[piece + 1] - knots[piece]
            held = 1
            while held > 0:
                held -= 1
                start, end = stack[held, 0], stack[held, 1]
                m, half = 0.5 * (start + end), 0.5 * (end - start)
                _at(c, m, q, dq)
                elbow, hand, _, _ = _limb(q, dq, geo)
                _bounds(c, start, end, over)
                first = math.sqrt(over[0, 0] ** 2 + over[0, 1] ** 2)
                second = math.sqrt(over[0, 2] ** 2 + over[0, 3] ** 2)
                t = knots[piece] + m
                body = _body_way(rows[b], t, half)
                ways = (half * first * upper, half * (first * (upper + fore) + second * fore), body)
                pose = _pose(rows[b], tables[b], t)
                bound, room = _limb_room(
                    rows[b], pose, _world(elbow, geo), _world(hand, geo), geo, ways
                )
                best = min(best, room)
                instants += 1
                if best <= touch or instants >= patience:
                    return best, instants
                if bound >= best - close and bound > touch:
                    continue
                if ways[1] + body <= hair or not start < m < end or held > 190:
                    continue
                stack[held, 0], stack[held, 1] = m, end
                held += 1
                stack[held, 0], stack[held, 1] = start, m
                held += 1
    return best, instants
