"""An independent referee of caught plans: brute force in plain numpy, with geometry of its own.

It shares nothing with the package but the records of situations and plans.  Times are sampled
densely, the trajectory's own samples included, and again around every low of a distance.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from gcm_learn.planners import plan_to_json
from gcm_learn.situation import (
    Box,
    Capsule,
    Cylinder,
    Disc,
    Pendulum,
    Polygon,
    Sphere,
    situation_to_json,
)
from tests import referee_of_spatial_arms
from tests.referee_of_spatial_arms import of_quaternion

INSTANTS = 300  # first samples of a movement, besides the trajectory's own
LOWS = 3  # local minima of a distance that are looked at more closely
CLOSER = 3  # times, each 8 times as densely
SECTIONS = 32  # of the golden section search along a segment: to 2e-7 of its length
SWING_STEPS = 2000
GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)

LENGTH = 1e-9  # tolerance of lengths that are exact but for rounding [forearm lengths]
SPEED = 1e-6  # relative, as the contract grants
CLEARANCE = 2.5e-4  # the planner's resolution is 2e-4, the referee's sampling error far below
INTERPOLATION = 1e-3  # how far joints that are linear between samples may lead the hand astray


@dataclass(frozen=True)
class Verdict:
    """What the referee found: an empty list of complaints means that every promise is kept."""

    complaints: list[str]
    clearance: float  # as sampled, of the limb with its hand linear between samples


def judge(situation, plan, instants=INSTANTS):
    """Check all that CONTRACT.md promises of a caught plan, in the plane or in space."""
    if situation.is_spatial:
        return referee_of_spatial_arms.judge(
            situation_to_json(situation), plan_to_json(plan, situation)
        )
    arm, path = situation.arm, plan.trajectory
    complaints = [*_records(situation, plan), *_speeds(arm, path)]
    t = np.unique(np.concatenate([np.linspace(0.0, path.time[-1], instants), path.time]))
    lowest = {}
    readings = {reading: reading(arm, path, t) for reading in (by_hand, by_joints)}
    pairs = zip(*readings.values(), strict=True)
    apart = [np.linalg.norm(first - second, axis=1).max() for first, second in pairs]
    for reading, (hand, _) in readings.items():
        radius = np.linalg.norm(hand, axis=1)
        if radius.max() > arm.reach + LENGTH or radius.min() < arm.inner_reach - LENGTH:
            complaints.append(f"{reading.__name__}: the hand leaves the ring")
        if reading is by_joints and lowest[by_hand] - arm.thickness > 2.0 * max(apart):
            continue  # nowhere are the two limbs so far apart
        lowest[reading] = nearest(situation, lambda t, reading=reading: reading(arm, path, t), t)
        if lowest[reading] <= arm.thickness:
            gap = lowest[reading] - arm.thickness
            complaints.append(f"{reading.__name__}: touches, clearance {gap:g}")
    free = lowest[by_hand] - arm.thickness
    if apart[0] > INTERPOLATION:
        complaints.append(f"joints linear between samples lead the hand {apart[0]:g} astray")
    if not within_grasp(situation, plan):
        complaints.append("the hand misses the target")
    if np.isfinite(free) and not abs(plan.clearance - free) <= CLEARANCE:
        complaints.append(f"clearance is {free:g}, reported as {plan.clearance:g}")
    if not np.isfinite(free) and situation.obstacles == () and np.isfinite(plan.clearance):
        complaints.append("clearance without obstacles")
    return Verdict(complaints, free)


def _records(situation, plan):
    """What does not fit together in the plan's numbers."""
    arm, path = situation.arm, plan.trajectory
    fits = {
        "status is caught": plan.status == "caught",
        "numbers are finite": all(
            np.isfinite(a).all() for a in (path.time, path.hand, path.joints, [plan.catch_time])
        ),
        "starts at t = 0": path.time[0] == 0.0,
        "starts on the hand": np.allclose(path.hand[0], arm.hand, rtol=0.0, atol=1e-12),
        "times do not decrease": (np.diff(path.time) >= 0.0).all(),
        "ends at catch_time": path.time[-1] == plan.catch_time,
        "catch is within the horizon": plan.catch_time <= situation.horizon,
        "the catch is a target": plan.catch_body in [b.name for b in situation.targets],
        "joints reach the hand": np.abs(forward(arm, path.joints) - path.hand).max() < 1e-6,
        "joints are continuous": (np.abs(np.diff(path.joints, axis=0)) < 3.0).all(),
        "elbow keeps its side": (_side(arm) * np.sin(path.joints[:, 1]) > -1e-6).all(),
    }
    return [promise for promise, kept in fits.items() if not kept]


def _speeds(arm, path):
    """Speed limits, between samples as well."""
    complaints = []
    span = np.diff(path.time)
    step = np.linalg.norm(np.diff(path.hand, axis=0), axis=1)
    if (step > arm.max_hand_speed * span * (1.0 + SPEED) + 1e-15).any():
        complaints.append("the hand is too fast")
    if arm.max_joint_speed is None or len(span) == 0:
        return complaints
    limit = np.array(arm.max_joint_speed) * (1.0 + SPEED)
    if (np.abs(np.diff(path.joints, axis=0)) > limit * span[:, None] + 1e-12).any():
        complaints.append("a joint is too fast from sample to sample")
    if (rates(arm, path) > limit).any():
        complaints.append("a joint is too fast between samples")
    return complaints


def rates(arm, path, pieces=16):
    """Largest rate of both joints (n - 1, 2) in every segment while the hand moves straight.

    By the Jacobian: with f the forearm's direction and u the upper arm's, the hand's velocity v
    is rho w1 (n u) + (w1 + w2) (n f), n the quarter turn.
    """
    span = np.diff(path.time)[:, None]
    velocity = np.diff(path.hand, axis=0) / np.where(span > 0.0, span, 1.0) * (span > 0.0)
    most = np.zeros((len(velocity), 2))
    for s in np.linspace(0.0, 1.0, pieces + 1):
        hand = path.hand[:-1] + s * np.diff(path.hand, axis=0)
        elbow = elbow_of(arm, hand)
        u, f = elbow / arm.upper_arm, hand - elbow
        bend = u[:, 0] * f[:, 1] - u[:, 1] * f[:, 0]
        moving = np.linalg.norm(velocity, axis=1) > 0.0
        with np.errstate(divide="ignore", invalid="ignore"):
            first = (velocity * f).sum(axis=1) / (arm.upper_arm * bend)
            second = -(velocity * hand).sum(axis=1) / (arm.upper_arm * bend)
        both = np.abs(np.stack([first, second], axis=1))
        most = np.maximum(most, np.where(moving[:, None], both, 0.0))
    return most


# --- the arm ---------------------------------------------------------------------------------


def _side(arm):
    """Sign of the forearm's angle relative to the upper arm."""
    return 1.0 if arm.elbow == "right" else -1.0


def forward(arm, joints):
    """Hands (n, 2) of joints (n, 2)."""
    second = joints.sum(axis=1)
    return elbow_by(arm, joints) + np.stack([np.cos(second), np.sin(second)], axis=1)


def elbow_by(arm, joints):
    """Elbows (n, 2) of joints (n, 2)."""
    return arm.upper_arm * np.stack([np.cos(joints[:, 0]), np.sin(joints[:, 0])], axis=1)


def elbow_of(arm, hand):
    """Elbows (n, 2) of hands (n, 2), by the law of cosines at the shoulder."""
    radius = np.maximum(np.linalg.norm(hand, axis=1), 1e-12)
    cosine = (radius**2 + arm.upper_arm**2 - 1.0) / (2.0 * radius * arm.upper_arm)
    bend = np.arccos(np.clip(cosine, -1.0, 1.0))
    angle = np.arctan2(hand[:, 1], hand[:, 0]) - _side(arm) * bend
    return arm.upper_arm * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def _between(t, time, values):
    return np.stack([np.interp(t, time, values[:, k]) for k in (0, 1)], axis=1)


def by_hand(arm, path, t):
    """Hand and elbow at times t (n,) when the hand is linear between samples."""
    hand = _between(t, path.time, path.hand)
    return hand, elbow_of(arm, hand)


def by_joints(arm, path, t):
    """Hand and elbow at times t (n,) when the joints are linear between samples."""
    joints = _between(t, path.time, path.joints)
    return forward(arm, joints), elbow_by(arm, joints)


# --- the bodies ------------------------------------------------------------------------------


def place(situation, body, t):
    """Centres (n, 3) and rotations (n, 3, 3) of a body in arm-plane coordinates at times t."""
    motion = body.motion
    if isinstance(motion, Pendulum):
        centre, rotation = _swing(motion, t)
    else:
        centre = _padded(motion.position) + np.outer(t, _padded(motion.velocity))
        centre = centre + np.outer(0.5 * t * t, _padded(motion.acceleration))
        if situation.plane is None:
            rotation = _turned(np.array([0.0, 0.0, 1.0]), motion.angle + motion.spin * t)
        else:
            spin = np.array(motion.spin)
            rate = np.linalg.norm(spin)
            axis = spin / rate if rate > 0.0 else np.array([0.0, 0.0, 1.0])
            rotation = _turned(axis, rate * t) @ of_quaternion(motion.orientation)
    if situation.plane is None:
        return centre, rotation
    x, y = np.array(situation.plane.x), np.array(situation.plane.y)
    frame = np.stack([x, y, np.cross(x, y)])
    return (centre - np.array(situation.plane.origin)) @ frame.T, frame @ rotation


def _padded(vector):
    return np.array([*vector, 0.0])[:3]


def _turned(axis, angles):
    """Rotations (n, 3, 3) about a unit axis: of each column, along, across and by the cross."""
    c, s = np.cos(angles)[:, None, None], np.sin(angles)[:, None, None]
    cross = np.cross(axis, np.eye(3)).T
    along = np.outer(axis, axis)
    return c * (np.eye(3) - along) + along + s * cross


def _swing(motion, t):
    """Centres and rotations of a pendulum in the world."""
    angle = swing_angles(motion, t)
    down, axis = np.array(motion.down), np.array(motion.axis)
    cord = (_turned(axis, angle) @ down)[:, :]
    side = np.broadcast_to(axis, cord.shape)
    rotation = np.stack([np.cross(side, cord), side, cord], axis=2)
    return np.array(motion.pivot) + motion.hang_distance * cord, rotation


def swing_angles(motion, t, steps=SWING_STEPS):
    """Angles (n,) of a pendulum at times t, by Runge-Kutta steps and cubics between them."""
    t = np.asarray(t, dtype=float)
    end = 2.0 ** np.ceil(np.log2(max(float(t.max()), 1e-6)))  # few different ends: few tables
    h, table = end / steps, swing_table(motion, end, steps)
    k = np.clip((t / h).astype(int), 0, steps - 1)
    s = t / h - k
    p, q = table[k], table[k + 1]
    chord = q[:, 0] - p[:, 0]
    bow = (1.0 - s) * (h * p[:, 1] - chord) + s * (chord - h * q[:, 1])
    return p[:, 0] + s * chord + s * (1.0 - s) * bow


@lru_cache(maxsize=64)
def swing_table(motion, end, steps):
    """Angle and rate (steps + 1, 2) of a pendulum between 0 and `end` [s]."""
    h, stiffness = end / steps, motion.gravity / motion.length
    x, v = motion.angle, motion.rate
    table = [(x, v)]

    def pull(x, v):
        return -stiffness * math.sin(x) - motion.damping * v

    for _ in range(steps):
        a = pull(x, v)
        b = pull(x + 0.5 * h * v, v + 0.5 * h * a)
        c = pull(x + 0.5 * h * v + 0.25 * h * h * a, v + 0.5 * h * b)
        d = pull(x + h * v + 0.5 * h * h * b, v + h * c)
        # Nystroem's form of the classical rule
        x, v = x + h * v + h * h / 6.0 * (a + b + c), v + h / 6.0 * (a + 2 * b + 2 * c + d)
        table.append((x, v))
    return np.array(table)


# --- distances -------------------------------------------------------------------------------


def nearest(situation, limb, t):
    """Smallest distance of the limb to any obstacle; `limb` gives hands and elbows at times."""
    lowest = np.inf
    for body in situation.obstacles:
        lowest = min(lowest, _lowest(lambda t, b=body: limb_distances(situation, b, limb(t), t), t))
    return lowest


def _lowest(distance, t):
    """Minimum of a distance: sampled at t, then ever more closely around its lowest lows."""
    d = distance(t)
    best = d.min()
    if len(t) == 1:
        return best
    padded = np.concatenate([[np.inf], d, [np.inf]])
    lows = np.flatnonzero((padded[1:-1] <= padded[:-2]) & (padded[1:-1] <= padded[2:]))
    lows = lows[np.argsort(d[lows])][:LOWS]
    a, b = t[np.maximum(lows - 1, 0)], t[np.minimum(lows + 1, len(t) - 1)]
    for _ in range(CLOSER):
        fine = np.linspace(a, b, 17)
        values = distance(fine.ravel()).reshape(fine.shape)
        best = min(best, values.min())
        m, each = values.argmin(axis=0), np.arange(len(lows))
        a, b = fine[np.maximum(m - 1, 0), each], fine[np.minimum(m + 1, 16), each]
    return best


def limb_distances(situation, body, limb, t):
    """Distances (n,) of a body to the whole limb at times t."""
    hand, elbow = limb
    pose = place(situation, body, t)
    upper = segment_distances(body.shape, pose, np.zeros_like(elbow), elbow)
    return np.minimum(upper, segment_distances(body.shape, pose, elbow, hand))


def segment_distances(shape, pose, a, b):
    """Distances (n,) of plane segments a-b to a shape at poses; 0 where they meet."""
    p, q = _in_body(pose, a), _in_body(pose, b)
    if isinstance(shape, Polygon):
        return _segment_polygon(np.array(shape.vertices), p[:, :2], q[:, :2])
    if isinstance(shape, Disc):
        return np.maximum(_segment_point(np.zeros(2), p[:, :2], q[:, :2]) - shape.radius, 0.0)
    least = golden_minimum(lambda s: depths(shape, p + s[:, None] * (q - p)), len(p), SECTIONS)
    return np.maximum(least, 0.0)


def golden_minimum(function, n, sections):
    """Minima (n,) over [0, 1] of n convex functions, evaluated together at n places."""
    low, high = np.zeros(n), np.ones(n)
    s, u = high - GOLDEN, low + GOLDEN
    fs, fu = function(s), function(u)
    for _ in range(sections):
        left = fs < fu
        low, high = np.where(left, low, s), np.where(left, u, high)
        kept, f_kept = np.where(left, s, u), np.where(left, fs, fu)
        fresh = np.where(left, high - GOLDEN * (high - low), low + GOLDEN * (high - low))
        f_fresh = function(fresh)
        s, fs = np.where(left, fresh, kept), np.where(left, f_fresh, f_kept)
        u, fu = np.where(left, kept, fresh), np.where(left, f_kept, f_fresh)
    ends = np.minimum(function(np.zeros(n)), function(np.ones(n)))
    return np.minimum(np.minimum(fs, fu), ends)


def point_distances(shape, pose, points):
    """Distances (n,) of plane points (n, 2) to a shape at one pose; 0 inside."""
    many = _repeated(pose, len(points))
    if isinstance(shape, Disc | Polygon):
        return segment_distances(shape, many, points, points)
    return np.maximum(depths(shape, _in_body(many, points)), 0.0)


def _repeated(pose, n):
    """One pose as n poses."""
    return np.broadcast_to(pose[0], (n, 3)), np.broadcast_to(pose[1], (n, 3, 3))


def _in_body(pose, points):
    """Plane points (n, 2) in the frames of poses."""
    centre, rotation = pose
    spatial = np.concatenate([points, np.zeros((len(points), 1))], axis=1) - centre
    return np.einsum("nij,ni->nj", rotation, spatial)


def depths(shape, points):
    """Signed distances (n,) of points (n, 3) in the body's frame to the surface of a solid."""
    x, y, z = np.abs(points).T
    across = np.hypot(x, y)
    if isinstance(shape, Sphere):
        return np.hypot(across, z) - shape.radius
    if isinstance(shape, Capsule):
        return np.hypot(across, np.maximum(z - shape.half_length, 0.0)) - shape.radius
    if isinstance(shape, Cylinder):
        beyond = [across - shape.radius, z - shape.half_length]
    elif isinstance(shape, Box):
        beyond = [c - half for c, half in zip((x, y, z), shape.half_extents, strict=True)]
    else:
        raise TypeError(shape)
    outside = np.sqrt(sum(np.maximum(e, 0.0) ** 2 for e in beyond))
    return np.where(outside > 0.0, outside, np.max(beyond, axis=0))


def _segment_point(point, a, b):
    """Distances (n,) of a point (2,) or points (n, 2) to segments a-b."""
    d = b - a
    length2 = (d * d).sum(axis=-1)
    share = ((point - a) * d).sum(axis=-1) / np.where(length2 > 0.0, length2, 1.0)
    share = np.clip(share, 0.0, 1.0)
    return np.linalg.norm(point - a - share[..., None] * d, axis=-1)


def _segment_polygon(vertices, a, b):
    """Distances (n,) of segments a-b to a filled polygon (m, 2), in its frame."""
    best = np.full(len(a), np.inf)
    for p, q in zip(np.roll(vertices, 1, axis=0), vertices, strict=True):
        ends = np.minimum(
            _segment_point(a, *np.broadcast_arrays(p, q)),
            _segment_point(b, *np.broadcast_arrays(p, q)),
        )
        edge = np.minimum(_segment_point(p, a, b), _segment_point(q, a, b))
        crossing = (_turn(a, b, p) * _turn(a, b, q) < 0.0) & (_turn(p, q, a) * _turn(p, q, b) < 0.0)
        best = np.minimum(best, np.where(crossing, 0.0, np.minimum(ends, edge)))
    return np.where(windings(vertices, a) != 0, 0.0, best)


def _turn(a, b, c):
    """Twice the area of triangles a, b, c."""
    u, v = b - a, c - a
    return u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]


def windings(vertices, points):
    """How often (n,) a polygon (m, 2) winds round points (n, 2), by the sum of angles."""
    total = np.zeros(len(points))
    for p, q in zip(np.roll(vertices, 1, axis=0), vertices, strict=True):
        u, v = p - points, q - points
        total += np.arctan2(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0], (u * v).sum(axis=1))
    return np.rint(total / (2.0 * np.pi)).astype(int)


# --- the catch -------------------------------------------------------------------------------


def within_grasp(situation, plan, slack=1e-7):
    """Whether the hand is within grasp of the target's region in the plane at the end."""
    t = np.array([plan.trajectory.time[-1]])
    body = next(b for b in situation.bodies if b.name == plan.catch_body)
    pose, hand = place(situation, body, t), plan.trajectory.hand[-1]
    grasp = situation.arm.grasp
    if situation.plane is None:
        return segment_distances(body.shape, pose, hand[None], hand[None])[0] <= grasp + slack
    return deepest(body.shape, pose, hand, grasp, slack) <= slack


def deepest(shape, pose, hand, grasp, enough):
    """Smallest signed distance to a solid's surface within `grasp` of the hand, in the plane.

    One that is at most `enough` will do.

    It is convex, and so is its minimum over every chord of that disc as a function of the chord:
    golden section along the chords, ever closer chords around the best.
    """
    low, high = -grasp, grasp
    for _ in range(12):
        x = np.linspace(low, high, 33)
        half = np.sqrt(np.maximum(grasp**2 - x**2, 0.0))

        def depth(share, x=x, half=half):
            points = hand + np.stack([x, (2.0 * share - 1.0) * half], axis=1)
            return depths(shape, _in_body(_repeated(pose, 33), points))

        least = golden_minimum(depth, 33, 60)
        best = int(least.argmin())
        if least[best] <= enough:
            break
        low, high = x[max(best - 1, 0)], x[min(best + 1, 32)]
    return least[best]
