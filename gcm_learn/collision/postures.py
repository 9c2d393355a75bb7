"""Distances of a spatial limb to moving bodies: at a posture, over a move, or at rest.

Everything is in the frame of the limb's base. A *touch* is the distance of the bones at which an
obstacle counts as touching the limb: the limb's thickness and a planner's clearance. A move is a
cubic in the joints (a straight line mostly) and is judged over all of its instants. Distances are
computed in the middle of a span. Bounds of the motion say for how much of the span they hold; if
not for all, both halves are searched.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.arms import limbs
from gcm_learn.arms.chain_limb import ChainLimb
from gcm_learn.arms.curves import line, on_curve
from gcm_learn.arms.link_gaps import near_links
from gcm_learn.collision.distance import bone_distance, point_distance
from gcm_learn.compiled import by_type, njit
from gcm_learn.scene.bodies import (
    BALL,
    LIMB,
    MARGIN,
    MARGIN_RATE,
    PART,
    REACH,
    TOP_SPEED,
    centre_at,
    drift,
    rotate,
)
from gcm_learn.scene.shapes.ball import off_bone
from gcm_learn.scene.shapes.choice import is_convex

CHUNK = 60  # obstacles that one search asks after: the bits of an integer
ITSELF = 60  # the bit of the limb itself
_HINGE = 1e-5  # share of the upper arm that is near the shoulder
_DEEPEST = 40  # halvings of a move before it counts as touching
UNLIMITED = 1 << 62
WORK = 2_000_000
"""Distances along moves that a plan or a map may compute: ten times what crowded scenes take."""
_MOST = 200_000  # checks of a move before it counts as touching: bodies may spin absurdly fast


class Desk(NamedTuple):
    """Arrays for intermediate results, made once per scene by `desk_of`."""

    poses: np.ndarray  # (bodies, 12)
    curve: np.ndarray  # (dof, 4): coefficients of a move's joints, over its share s in [0, 1]
    joints: np.ndarray  # (n,)
    spans: np.ndarray  # (_DEEPEST + 2, 2): shares of a move still to be checked
    waiting: np.ndarray  # (_DEEPEST + 2,): the obstacles that are to be checked there
    obstacles: np.ndarray  # (k,): indices of the bodies that the limb must not touch
    budget: np.ndarray  # (1,): distances along moves that may still be computed


@njit
def desk_of(scene):
    """Return the working arrays for queries about a scene."""
    rows = scene.bodies.rows
    which = np.empty(rows.shape[0], dtype=np.int64)
    count = 0
    for b in range(rows.shape[0]):
        if rows[b, PART] == LIMB:
            which[count] = b
            count += 1
    return Desk(
        np.zeros((rows.shape[0], 12)),
        np.zeros((limbs.dof(scene.limb), 4)),
        np.zeros(limbs.dof(scene.limb)),
        np.zeros((_DEEPEST + 2, 2)),
        np.zeros(_DEEPEST + 2, dtype=np.int64),
        which[:count].copy(),
        np.full(1, UNLIMITED),
    )


@njit(_nrt=False, forceinline=True)
def margin_at(bodies, b, t):
    """Distance that is kept from body b at t [s]."""
    return bodies.rows[b, MARGIN] + bodies.rows[b, MARGIN_RATE] * t


@njit(_nrt=False)
def _gap_to_links(limb, where, slack, bodies, b, t, off, enough, poses):
    """Compute `gap_to` link by link; the body's ball suffices for distances above `enough`."""
    turned, margin = centre_at(bodies, b, t, poses), margin_at(bodies, b, t)
    enough += margin
    x, y, z, reach = poses[b, 0], poses[b, 1], poses[b, 2], bodies.rows[b, REACH]
    best, room = 1e300, 1e300
    for i in range(limbs.link_count(limb)):
        if limbs.ignores(limb, i, b):
            continue
        px, py, pz, qx, qy, qz, radius = limbs.link(limb, where, i)
        slip = limbs.slack_of(limb, slack, i) + off
        gap = off_bone(x - px, y - py, z - pz, qx - px, qy - py, qz - pz) - reach - radius
        if bodies.rows[b, BALL] == 0.0 and gap - slip <= enough:
            if turned:
                rotate(bodies, b, t, poses)
                turned = False
            p, q, exact = (px, py, pz), (qx, qy, qz), enough + radius
            gap = bone_distance(bodies, poses, b, p, q, exact, exact + slip) - radius
        best, room = min(best, gap), min(room, gap - slip)
    return best - margin, room - margin


@njit(_nrt=False, forceinline=True)
def _gap_to_capsules(limb, where, slack, bodies, b, t, off, enough, poses):
    """Compute `gap_to` from the links whose balls are near the body's ball, mostly none."""
    turned, margin = centre_at(bodies, b, t, poses), margin_at(bodies, b, t)
    enough += margin
    far = enough + off + bodies.rows[b, REACH]
    x, y, z = poses[b, 0], poses[b, 1], poses[b, 2]
    count = near_links(limb.balls, limb.ways, x, y, z, far, limb.near)
    if count == 0:
        return 1e300, 1e300
    links = (limb.near, limb.reaches, limb.balls, limb.radii, limb.ways, limb.ignored)
    best, room = _gap_to_near(
        links, count, bodies, b, t, turned, off, enough, limbs.inverts(limb), poses
    )
    return best - margin, room - margin


@njit(_nrt=False)
def _hinged_room(bodies, b, elbow, slack, poses):
    """Least distance of body b, at rest, to the upper arm while the elbow moves by `slack`.

    A body at the shoulder, as a torso, is as near to it whatever the arm does.  Points of the bone
    move the less the nearer they are to the shoulder.  The distance to a convex body is convex
    along the bone, so beyond two of its points it is no less than the line through them.
    """
    ex, ey, ez = elbow
    near = point_distance(bodies, poses, b, _HINGE * ex, _HINGE * ey, _HINGE * ez)
    far = 2.0 * _HINGE
    slope = (point_distance(bodies, poses, b, far * ex, far * ey, far * ez) - near) / _HINGE
    between = 0.5 * _HINGE * np.sqrt(ex * ex + ey * ey + ez * ez)  # those two it may be less
    return near - slope * _HINGE + min(0.0, slope - slack) - between


@njit(_nrt=False)
def _gap_to_near(arrays, count, bodies, b, t, turned, off, enough, bones, poses):
    """Compute `gap_to` from `count` near links: by balls first, by the links' axes if need be.

    The links of a limb of two `bones` are long, and their balls settle little.  The first begins at
    the shoulder, which does not move.
    """
    near, links, balls, radii, ways, ignored = arrays
    x, y, z, reach = poses[b, 0], poses[b, 1], poses[b, 2], bodies.rows[b, REACH]
    best, room = 1e300, 1e300
    for k in range(count):
        i = near[k]
        if ignored[i, b]:
            continue
        px, py, pz, qx, qy, qz = (
            links[i, 0], links[i, 1], links[i, 2], links[i, 3], links[i, 4], links[i, 5],
        )  # fmt: skip
        slip = ways[i] + off
        gap = off_bone(x - px, y - py, z - pz, qx - px, qy - py, qz - pz) - reach - radii[i]
        if gap >= best and gap - slip >= room:
            continue
        if bodies.rows[b, BALL] == 0.0 and gap - slip <= enough:
            if turned:
                rotate(bodies, b, t, poses)
                turned = False
            if not bones and is_convex(bodies, b):
                u, v, w, ball = balls[i, 0], balls[i, 1], balls[i, 2], balls[i, 3]
                gap = max(gap, point_distance(bodies, poses, b, u, v, w) - ball)
            if gap - slip <= enough and (gap < best or gap - slip < room):
                p, q, exact = (px, py, pz), (qx, qy, qz), enough + radii[i]
                gap = bone_distance(bodies, poses, b, p, q, exact, exact + slip) - radii[i]
        left = gap - slip
        hinged = bones and i == 0 and left <= enough and is_convex(bodies, b)
        if hinged and slip > 0.0 == bodies.rows[b, TOP_SPEED]:
            left = max(left, _hinged_room(bodies, b, (qx, qy, qz), slip, poses) - radii[i])
        best, room = min(best, gap), min(room, left)
    return best, room


gap_to = by_type({None: _gap_to_links, ChainLimb: _gap_to_capsules})
"""Distance of body b at t [s] to a limb at a place, less its margin, and the same less slack.

Parameters
----------
slack : slack of the limb
off : float
    How much nearer the body may come, too.
enough : float
    Distances above this need not be exact. Neither need those that are above it without slack, and
    1e300 says no more; what is at most this without slack says so.
"""


@njit(_nrt=False)
def distance_at(scene, q, t, desk):
    """Distance of the limb at joints q (n,) to the nearest obstacle at t [s]; see `gap_to`."""
    return _nearest(scene, limbs.place(scene.limb, q), t, 1e300, desk)


@njit(_nrt=False)
def _nearest(scene, where, t, best, desk):
    """Distance of the limb at a place to the nearest obstacle at t [s], `best` at most."""
    slack = limbs.still(scene.limb)
    for k in range(desk.obstacles.size):
        found, _ = gap_to(
            scene.limb, where, slack, scene.bodies, desk.obstacles[k], t, 0.0, best, desk.poses
        )
        best = min(best, found)
    return best


@njit(_nrt=False)
def free_at(scene, q, t, touch, desk):
    """Return whether the limb at joints q (n,) is farther than `touch` from obstacles and itself.

    This is quicker than `gap_at`, which has to know how far.
    """
    where, slack = limbs.place(scene.limb, q), limbs.still(scene.limb)
    if limbs.self_gap(scene.limb, where, slack, touch)[0] <= touch:
        return False
    for k in range(desk.obstacles.size):
        b = desk.obstacles[k]
        found, _ = gap_to(scene.limb, where, slack, scene.bodies, b, t, 0.0, touch, desk.poses)
        if found <= touch:
            return False
    return True


@njit(_nrt=False)
def gap_at(scene, q, t, desk):
    """Distance as of `distance_at`, or of the limb to itself if that is less."""
    where = limbs.place(scene.limb, q)
    itself, _ = limbs.self_gap(scene.limb, where, limbs.still(scene.limb), 1e300)
    return _nearest(scene, where, t, itself, desk)


@njit(_nrt=False)
def _least_of(scene, since, until, floor, resolution, best, first, desk):
    """Compute `least_on` for at most CHUNK obstacles, from index `first` on."""
    count, when = min(desk.obstacles.size - first, CHUNK), -1.0
    desk.spans[0, 0], desk.spans[0, 1] = 0.0, 1.0
    desk.waiting[0] = (np.int64(1) << count) - 1
    if first == 0:
        desk.waiting[0] |= np.int64(1) << ITSELF
    depth, looks, span = 1, 0, until - since
    while depth > 0:
        depth -= 1
        low, high, mask = desk.spans[depth, 0], desk.spans[depth, 1], desk.waiting[depth]
        s, half, left = 0.5 * (low + high), 0.5 * (high - low), np.int64(0)
        on_curve(desk.curve, s, desk.joints)
        where, t = limbs.place(scene.limb, desk.joints), since + s * span
        slack = limbs.swept(scene.limb, desk.curve, s, half, where)
        if mask >> ITSELF & 1:
            found, room = limbs.self_gap(scene.limb, where, slack, floor)
            if found <= floor:
                return floor, t
            if room <= floor:
                left |= np.int64(1) << ITSELF
        for k in range(count):
            if mask >> k & 1:
                b = desk.obstacles[first + k]
                off = 0.5 * drift(scene.bodies, b, since + low * span, since + high * span)
                enough = max(floor, best - resolution)
                found, room = gap_to(
                    scene.limb, where, slack, scene.bodies, b, t, off, enough, desk.poses
                )
                if found < best:
                    best, when = found, t
                    if best <= floor:
                        return best, when
                if room <= max(floor, best - resolution):
                    left |= np.int64(1) << k
        looks += 1
        desk.budget[0] -= 1
        if left:
            if looks >= _MOST or desk.budget[0] < 0 or depth + 2 > _DEEPEST:
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
    for first in range(0, max(desk.obstacles.size, 1), CHUNK):
        found, t = _least_of(scene, since, until, floor, resolution, best, first, desk)
        if t >= 0.0:
            best, when = found, t
        if best <= floor:
            break
    return best, when


@njit(_nrt=False)
def move_is_free(scene, q, since, p, until, touch, desk):
    """Return whether no obstacle comes within `touch` of a limb that goes straight from q to p.

    Parameters
    ----------
    q, p : (n,) ndarray
        Joints at `since` and at `until` [s]; the same for a rest.
    """
    line(q, p, desk.curve)
    best, _ = least_on(scene, since, until, touch, 1e300, 1e300, desk)
    return best > touch
