"""Distances of points, of segments and of a planar limb to a body at its pose.

A planar limb lies in z = 0 of the arm's plane.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.compiled import njit
from gcm_learn.scene.bodies import BALL, HAND, PART, REACH, SIZE, centre_at, rotate
from gcm_learn.scene.shapes.ball import gap as gap_of_ball
from gcm_learn.scene.shapes.choice import gap, gap_of_bone
from gcm_learn.scene.shapes.polygon import segments_cross

_FAR = 0.15  # beyond this a body's ball is as good as the body [forearm lengths]


@njit(_nrt=False)
def segment_point2(px, py, ax, ay, bx, by):
    """Squared distance of point p to segment a-b in the plane."""
    dx, dy = bx - ax, by - ay
    wx, wy = px - ax, py - ay
    length2 = dx * dx + dy * dy
    if length2 > 0.0:
        s = min(max((wx * dx + wy * dy) / length2, 0.0), 1.0)
        wx -= s * dx
        wy -= s * dy
    return wx * wx + wy * wy


@njit(_nrt=False, forceinline=True)
def limb_point2(x, y, hx, hy, ex, ey):
    """Squared distance of the point (x, y) in the arm's plane to the limb with hand and elbow."""
    forearm = segment_point2(x, y, ex, ey, hx, hy)
    return min(forearm, segment_point2(x, y, 0.0, 0.0, ex, ey))


@njit(_nrt=False)
def segments_distance2(ax, ay, bx, by, cx, cy, dx, dy):
    """Squared distance of the plane segments a-b and c-d, 0 if they cross."""
    if segments_cross(ax, ay, bx, by, cx, cy, dx, dy):
        return 0.0
    first = min(segment_point2(cx, cy, ax, ay, bx, by), segment_point2(dx, dy, ax, ay, bx, by))
    second = min(segment_point2(ax, ay, cx, cy, dx, dy), segment_point2(bx, by, cx, cy, dx, dy))
    return min(first, second)


@njit(_nrt=False)
def limb_segment2(hx, hy, ex, ey, ax, ay, bx, by):
    """Squared distance of the limb with hand and elbow to the plane segment a-b."""
    upper_arm = segments_distance2(0.0, 0.0, ex, ey, ax, ay, bx, by)
    return min(upper_arm, segments_distance2(ex, ey, hx, hy, ax, ay, bx, by))


@njit(_nrt=False)
def segment_distance(bodies, poses, b, ax, ay, bx, by):
    """Distance of the plane segment a-b to body b at its pose; 0 when they meet."""
    if bodies.rows[b, BALL] > 0.0:  # without turning either end, which would take longer
        d2 = segment_point2(poses[b, 0], poses[b, 1], ax, ay, bx, by)
        return max(np.sqrt(d2 + poses[b, 2] * poses[b, 2]) - bodies.rows[b, SIZE], 0.0)
    return bone_distance(bodies, poses, b, (ax, ay, 0.0), (bx, by, 0.0), 1e300, 1e300)


@njit(_nrt=False)
def _limb_distance(bodies, poses, b, hx, hy, ex, ey):
    """Distance of body b to the limb, for bodies other than balls.

    The half that the ball about the body shows to be farther away is left out.
    """
    x, y, z2 = poses[b, 0], poses[b, 1], poses[b, 2] ** 2
    ball = bodies.rows[b, REACH]
    forearm = np.sqrt(segment_point2(x, y, ex, ey, hx, hy) + z2) - ball
    upper_arm = np.sqrt(segment_point2(x, y, 0.0, 0.0, ex, ey) + z2) - ball
    if forearm <= upper_arm:
        found = segment_distance(bodies, poses, b, ex, ey, hx, hy)
        if found > upper_arm:
            found = min(found, segment_distance(bodies, poses, b, 0.0, 0.0, ex, ey))
    else:
        found = segment_distance(bodies, poses, b, 0.0, 0.0, ex, ey)
        if found > forearm:
            found = min(found, segment_distance(bodies, poses, b, ex, ey, hx, hy))
    return found


@njit(_nrt=False, forceinline=True)
def arm_distance(bodies, poses, b, hx, hy, ex, ey):
    """Distance of body b to the hand if it is a target, to the whole limb if an obstacle.

    Parameters
    ----------
    poses : (n, 12) ndarray
        Row b is the body's pose.
    hx, hy, ex, ey : float
        Hand and elbow; the shoulder is the origin.
    """
    if bodies.rows[b, PART] == HAND:
        return segment_distance(bodies, poses, b, hx, hy, hx, hy)
    if bodies.rows[b, BALL] == 0.0:
        return _limb_distance(bodies, poses, b, hx, hy, ex, ey)
    x, y, z = poses[b, 0], poses[b, 1], poses[b, 2]
    return max(np.sqrt(limb_point2(x, y, hx, hy, ex, ey) + z * z) - bodies.rows[b, SIZE], 0.0)


@njit(_nrt=False)
def room_at(bodies, b, t, hx, hy, ex, ey, gap, scratch):
    """Bound `arm_distance` less `gap` at t [s] from below: by the ball while far, else exactly.

    Good for conservative advancement, where a cheap smaller step beats an exact larger one.
    """
    turned = centre_at(bodies, b, t, scratch)
    x, y = scratch[b, 0], scratch[b, 1]
    if bodies.rows[b, PART] == HAND:
        d2 = (hx - x) ** 2 + (hy - y) ** 2
    else:
        d2 = limb_point2(x, y, hx, hy, ex, ey)
    room = np.sqrt(d2 + scratch[b, 2] ** 2) - bodies.rows[b, REACH] - gap
    if room > _FAR:
        return room
    if turned:
        rotate(bodies, b, t, scratch)
    return arm_distance(bodies, scratch, b, hx, hy, ex, ey) - gap


@njit(_nrt=False, forceinline=True)
def to_body(bodies, poses, b, x, y, z):
    """Coordinates of a point in body b's frame, which is not turned for balls."""
    dx, dy, dz = x - poses[b, 0], y - poses[b, 1], z - poses[b, 2]
    if bodies.rows[b, BALL] > 0.0:  # its pose has no turn
        return dx, dy, dz
    return (
        poses[b, 3] * dx + poses[b, 6] * dy + poses[b, 9] * dz,
        poses[b, 4] * dx + poses[b, 7] * dy + poses[b, 10] * dz,
        poses[b, 5] * dx + poses[b, 8] * dy + poses[b, 11] * dz,
    )


@njit(_nrt=False)
def bone_distance(bodies, poses, b, p, q, near, far):
    """Distance of the segment p-q to body b at its pose, 0 when they meet; see `gap_of_bone`."""
    p = to_body(bodies, poses, b, p[0], p[1], p[2])
    q = to_body(bodies, poses, b, q[0], q[1], q[2])
    return gap_of_bone(bodies, b, p, q, near, far)


@njit(_nrt=False)
def _turned_distance(bodies, poses, b, x, y, z):
    """Signed distance of the point (x, y, z) to body b, whose pose has a turn."""
    x, y, z = to_body(bodies, poses, b, x, y, z)
    return gap(bodies, b, x, y, z)


@njit(_nrt=False, forceinline=True)
def point_distance(bodies, poses, b, x, y, z):
    """Signed distance of the point (x, y, z) to body b at its pose, negative inside."""
    if bodies.rows[b, BALL] > 0.0:  # most targets, for which calls would take as long again
        return gap_of_ball(bodies, b, x - poses[b, 0], y - poses[b, 1], z - poses[b, 2])
    return _turned_distance(bodies, poses, b, x, y, z)
