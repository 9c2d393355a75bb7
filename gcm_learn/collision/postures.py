"""A spatial limb among moving bodies: at a posture, over a move, while it rests.

Everything is in the frame of the limb's base. A *touch* is the distance of the bones at which an
obstacle counts as touching the limb: its thickness, and what a planner keeps beyond. A move is a
cubic in the joints (a straight line mostly) and is judged over all of its instants: the limb and
every body are asked in the middle of a span, and bounds of their motion say for how much of it the
answer holds; if not for all, both halves are asked.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.arms.spatial_limb import limb_at
from gcm_learn.collision.solids import room_in_pose, solid_distance
from gcm_learn.compiled import njit
from gcm_learn.scene.bodies import (
    BOX,
    CAPSULE,
    KIND,
    LIMB,
    PART,
    REACH,
    SIZE,
    SPHERE,
    TOP_SPEED,
    centre_at,
    drift,
    rotate,
)

CHUNK = 60  # obstacles that one search asks after: the bits of an integer
_HINGE = 1e-5  # share of the upper arm that is near the shoulder
_DEEPEST = 40  # halvings of a move before it counts as touching
_MOST = 200_000  # looks at a move before it counts as touching: bodies may spin absurdly fast


class Desk(NamedTuple):
    """Room to work in, made once per scene by `desk_of`."""

    poses: np.ndarray  # (bodies, 12)
    curve: np.ndarray  # (4, 4): coefficients of a move's joints, over its share s in [0, 1]
    joints: np.ndarray  # (4,)
    spans: np.ndarray  # (_DEEPEST + 2, 2): shares of a move still to be looked at
    waiting: np.ndarray  # (_DEEPEST + 2,): the obstacles that are to be looked at there
    obstacles: np.ndarray  # (k,): indices of the bodies that the limb must not touch


@njit
def desk_of(scene):
    """A desk for a scene's questions."""
    rows = scene.bodies.rows
    which = np.empty(rows.shape[0], dtype=np.int64)
    count = 0
    for b in range(rows.shape[0]):
        if rows[b, PART] == LIMB:
            which[count] = b
            count += 1
    return Desk(
        np.zeros((rows.shape[0], 12)),
        np.zeros((4, 4)),
        np.zeros(4),
        np.zeros((_DEEPEST + 2, 2)),
        np.zeros(_DEEPEST + 2, dtype=np.int64),
        which[:count].copy(),
    )


@njit(_nrt=False, forceinline=True)
def _off_bone(px, py, pz, dx, dy, dz):
    """Distance of the point p to the segment from the origin to d."""
    length2 = dx * dx + dy * dy + dz * dz
    s = 0.0
    if length2 > 0.0:
        s = min(max((px * dx + py * dy + pz * dz) / length2, 0.0), 1.0)
    x, y, z = px - s * dx, py - s * dy, pz - s * dz
    return np.sqrt(x * x + y * y + z * z)


@njit(_nrt=False)
def body_distance(bodies, b, t, limb, upper_slack, fore_slack, enough, poses):
    """Distance of body b at t [s] to a limb (elbow, hand: six numbers).

    Parameters
    ----------
    upper_slack, fore_slack : float
        How much nearer the bones may come in the span that is asked about.
    enough : float
        Distances above this, slack taken off, need not be exact: the ball that holds the body
        bounds them.

    Returns
    -------
    distance : float
        Of the nearer bone.
    room : float
        The smaller distance with the bone's slack taken off.
    """
    turned = centre_at(bodies, b, t, poses)
    x, y, z, reach = poses[b, 0], poses[b, 1], poses[b, 2], bodies.rows[b, REACH]
    ex, ey, ez, hx, hy, hz = limb
    upper = _off_bone(x, y, z, ex, ey, ez) - reach
    fore = _off_bone(x - ex, y - ey, z - ez, hx - ex, hy - ey, hz - ez) - reach
    if bodies.rows[b, KIND] != SPHERE:
        near_upper, near_fore = upper - upper_slack <= enough, fore - fore_slack <= enough
        if turned and (near_upper or near_fore):
            rotate(bodies, b, t, poses)
        first = upper < fore  # the other bone needs not be asked after if its ball is farther
        if near_upper and first:
            upper = solid_distance(bodies, poses, b, (0.0, 0.0, 0.0), (ex, ey, ez))
        if near_fore and (not first or fore < upper or fore - fore_slack < upper - upper_slack):
            fore = solid_distance(bodies, poses, b, (ex, ey, ez), (hx, hy, hz))
        if near_upper and not first and (upper < fore or upper - upper_slack < fore - fore_slack):
            upper = solid_distance(bodies, poses, b, (0.0, 0.0, 0.0), (ex, ey, ez))
    upper, fore = max(upper, 0.0), max(fore, 0.0)
    room = upper - upper_slack
    if room <= enough and upper_slack > 0.0 and bodies.rows[b, TOP_SPEED] == 0.0:
        room = max(room, _hinged_room(bodies, b, (ex, ey, ez), upper_slack, poses))
    return min(upper, fore), min(room, fore - fore_slack)


@njit(_nrt=False)
def _hinged_room(bodies, b, elbow, slack, poses):
    """Least distance of body b, at rest, to the upper arm while the elbow moves by `slack`.

    A body at the shoulder, as a torso, is as near to it whatever the arm does.  Points of the bone
    move the less the nearer they are to the shoulder, and the distance to a convex body is convex
    along the bone, so beyond two of its points it is no less than the line through them.
    """
    ex, ey, ez = elbow
    near = room_in_pose(bodies, b, _HINGE * ex, _HINGE * ey, _HINGE * ez, poses)
    far = 2.0 * _HINGE
    slope = (room_in_pose(bodies, b, far * ex, far * ey, far * ez, poses) - near) / _HINGE
    between = 0.5 * _HINGE * np.sqrt(ex * ex + ey * ey + ez * ez)  # those two it may be less
    return near - slope * _HINGE + min(0.0, slope - slack) - between


@njit(_nrt=False)
def distance_at(scene, q, t, desk):
    """Distance of the limb at joints q (4,) to the nearest obstacle at t [s]; 0 when they meet."""
    best, limb = 1e300, limb_at(scene.limb, q)
    for k in range(desk.obstacles.size):
        found, _ = body_distance(
            scene.bodies, desk.obstacles[k], t, limb, 0.0, 0.0, best, desk.poses
        )
        best = min(best, found)
    return best


@njit(_nrt=False)
def line(q, p, curve):
    """Write the straight move from joints q to p (4,) into `curve` (4, 4)."""
    for j in range(4):
        curve[j, 0], curve[j, 1], curve[j, 2], curve[j, 3] = q[j], p[j] - q[j], 0.0, 0.0


@njit(_nrt=False)
def hermite(q, v, p, w, span, curve):
    """Write the cubic from q with rates v to p with rates w (4,) in `span` [s] into `curve`."""
    for j in range(4):
        a, b, way = v[j] * span, w[j] * span, p[j] - q[j]
        curve[j, 0], curve[j, 1] = q[j], a
        curve[j, 2], curve[j, 3] = 3.0 * way - 2.0 * a - b, a + b - 2.0 * way


@njit(_nrt=False)
def on_curve(curve, s, q):
    """Write the joints at share s of a move into q (4,)."""
    for j in range(4):
        q[j] = curve[j, 0] + s * (curve[j, 1] + s * (curve[j, 2] + s * curve[j, 3]))


@njit(_nrt=False)
def part(curve, since, until, out):
    """Write the part of a move between two shares of it into `out` (4, 4), as a move."""
    width = until - since
    for j in range(4):
        b, c, d = curve[j, 1], curve[j, 2], curve[j, 3]
        out[j, 0] = curve[j, 0] + since * (b + since * (c + since * d))
        out[j, 1] = width * (b + since * (2.0 * c + since * 3.0 * d))
        out[j, 2] = width * width * (c + 3.0 * since * d)
        out[j, 3] = width * width * width * d


@njit(_nrt=False, forceinline=True)
def _turn(curve, j, s, half):
    """Bound how far joint j turns from share s to s - half or s + half, at its fastest."""
    rate = abs(curve[j, 1] + s * (2.0 * curve[j, 2] + s * 3.0 * curve[j, 3]))
    bend = abs(2.0 * curve[j, 2] + 6.0 * s * curve[j, 3])
    return half * (rate + half * (bend + half * 3.0 * abs(curve[j, 3])))


@njit(_nrt=False)
def bone_ways(limb, curve, s, half, place):
    """Bound how far points of upper arm and forearm travel from share s of a move to s +- half.

    Joints 1 and 2 turn about orthogonal axes, and so do 3 and 4, so rates add as the sides of a
    right angle; turned about the shoulder, a point moves no more than the hand or the elbow.
    `place` has elbow and hand at s.
    """
    shoulder = np.hypot(_turn(curve, 0, s, half), _turn(curve, 1, s, half))
    bend = np.hypot(_turn(curve, 2, s, half), _turn(curve, 3, s, half)) * limb.length
    _, _, _, x, y, z = place
    farthest = min(np.sqrt(x * x + y * y + z * z) + bend, limb.rho + limb.length)
    upper = shoulder * limb.rho
    return upper, max(upper, shoulder * farthest + bend)


@njit(_nrt=False)
def _least_of(scene, since, until, floor, resolution, best, first, desk):
    """`least_on` for the obstacles from the `first` to the CHUNK after it."""
    count, when = min(desk.obstacles.size - first, CHUNK), -1.0
    desk.spans[0, 0], desk.spans[0, 1] = 0.0, 1.0
    desk.waiting[0] = (np.int64(1) << count) - 1
    depth, looks, span = 1, 0, until - since
    while depth > 0:
        depth -= 1
        low, high, mask = desk.spans[depth, 0], desk.spans[depth, 1], desk.waiting[depth]
        s, half, left = 0.5 * (low + high), 0.5 * (high - low), np.int64(0)
        on_curve(desk.curve, s, desk.joints)
        place, t = limb_at(scene.limb, desk.joints), since + s * span
        upper, fore = bone_ways(scene.limb, desk.curve, s, half, place)
        for k in range(count):
            if mask >> k & 1:
                b = desk.obstacles[first + k]
                off = 0.5 * drift(scene.bodies, b, since + low * span, since + high * span)
                enough = max(floor, best - resolution)
                found, room = body_distance(
                    scene.bodies, b, t, place, upper + off, fore + off, enough, desk.poses
                )
                if found < best:
                    best, when = found, t
                    if best <= floor:
                        return best, when
                if room <= max(floor, best - resolution):
                    left |= np.int64(1) << k
        looks += 1
        if left:
            if looks >= _MOST or depth + 2 > _DEEPEST:
                return floor, t
            desk.spans[depth, 0], desk.spans[depth, 1], desk.waiting[depth] = s, high, left
            desk.spans[depth + 1, 0], desk.spans[depth + 1, 1] = low, s
            desk.waiting[depth + 1] = left
            depth += 2
    return best, when


@njit(_nrt=False)
def least_on(scene, since, until, floor, resolution, best, desk):
    """Least distance of the limb to obstacles over the move that is in ``desk.curve``.

    Parameters
    ----------
    since, until : float
        When the move begins and ends [s].
    floor : float
        Distance at which the search stops: the limb is touched.
    resolution : float
        The answer is at most this above the true one.
    best : float
        Distances above this do not count.

    Returns
    -------
    distance : float
        `best` if nothing comes nearer.
    when : float
        [s]; -1 if nothing comes nearer.
    """
    when = -1.0
    for first in range(0, desk.obstacles.size, CHUNK):
        found, t = _least_of(scene, since, until, floor, resolution, best, first, desk)
        if t >= 0.0:
            best, when = found, t
        if best <= floor:
            break
    return best, when


@njit(_nrt=False)
def move_is_free(scene, q, since, p, until, touch, desk):
    """Whether no obstacle comes within `touch` of the limb, which goes straight from q to p.

    Parameters
    ----------
    q, p : (4,) ndarray
        Joints at `since` and at `until` [s]; the same for a rest.
    """
    line(q, p, desk.curve)
    best, _ = least_on(scene, since, until, touch, 1e300, 1e300, desk)
    return best > touch


@njit(_nrt=False)
def _shortest_radius(bodies, b):
    """Radius of the largest ball about its centre that a solid holds."""
    kind, size = bodies.rows[b, KIND], bodies.rows[b, SIZE]
    if kind == BOX:
        return min(size, bodies.rows[b, SIZE + 1], bodies.rows[b, SIZE + 2])
    if kind == SPHERE or kind == CAPSULE:
        return size
    return min(size, bodies.rows[b, SIZE + 1])


@njit(_nrt=False)
def state_at(scene, place, t, touch, desk):
    """Whether a resting limb is free at t [s], and for how long that surely stays so.

    Parameters
    ----------
    place : tuple of 6 floats
        Elbow and hand.
    """
    ex, ey, ez, hx, hy, hz = place
    blocked, apart, together = False, 1e300, 0.0
    for k in range(desk.obstacles.size):
        b = desk.obstacles[k]
        speed = scene.bodies.rows[b, TOP_SPEED]
        far = touch + speed * min(apart, 1e200)
        found, _ = body_distance(scene.bodies, b, t, place, 0.0, 0.0, far, desk.poses)
        if found > touch:
            if speed > 0.0:
                apart = min(apart, (found - touch) / speed)
            continue
        blocked = True
        x, y, z = desk.poses[b, 0], desk.poses[b, 1], desk.poses[b, 2]
        away = min(
            _off_bone(x, y, z, ex, ey, ez),
            _off_bone(x - ex, y - ey, z - ez, hx - ex, hy - ey, hz - ez),
        )
        inside = max(_shortest_radius(scene.bodies, b) + touch - away, touch - found)
        if inside > 0.0:
            together = max(together, inside / speed if speed > 0.0 else 1e300)
    return not blocked, together if blocked else apart


@njit(_nrt=False)
def free_until(scene, q, since, until, touch, shortest, desk):
    """Until when a limb may rest at joints q (4,), from `since` on.

    Conservative advancement, with steps of at least `shortest` [s].

    Returns
    -------
    float
        `until` if it is not touched before [s]; `since` if it is touched then.
    """
    place, t, safe = limb_at(scene.limb, q), since, since
    while t < until:
        free, stays = state_at(scene, place, t, touch, desk)
        if not free:
            return safe
        safe = t + stays
        t += max(stays, shortest)
    return until


@njit(_nrt=False)
def free_spans(scene, q, since, until, touch, shortest, desk, out):
    """Spans of time in which a limb may rest at joints q (4,), into `out` (k, 2).

    Spans shorter than `shortest` [s] may be missed, and those beyond what `out` holds are left
    out; the ends of a span are inside it.

    Returns
    -------
    count : int
    """
    place, t, count, begun = limb_at(scene.limb, q), since, 0, False
    safe = since
    while t <= until and count < out.shape[0]:
        free, stays = state_at(scene, place, t, touch, desk)
        if free:
            if not begun:
                begun, out[count, 0] = True, t
            safe = t + stays
        elif begun:
            begun, out[count, 1] = False, min(safe, t)
            count += 1
        if t >= until:
            break
        t = min(t + max(stays, shortest), until)
    if begun:
        out[count, 1] = until
        count += 1
    return count
