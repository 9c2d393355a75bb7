"""Cylinders along the z axis of the body; their sizes are the radius and half of the height."""

from __future__ import annotations

import numpy as np

from gcm_learn.compiled import njit
from gcm_learn.scene.bodies import CYLINDER, SIZE
from gcm_learn.scene.shapes.box import excess
from gcm_learn.scene.shapes.region import ShapeEntry, placed

ENTRY = ShapeEntry(CYLINDER, lambda shape: (shape.radius, shape.half_length, 0.0), is_round=True)

ARC_ERROR = 1.9e-4
"""Largest distance of a sampled arc from the true one, in radii (2.6e-4 where 256 vertices are
too few: in whole ellipses more than 50 times longer than wide)."""

_MOST_NODES = 126  # inner vertices on each half of an ellipse; with the ends, 256 in all
_PARALLEL = 1e-14  # axis in the plane: what the ellipse's curve adds is below rounding
_NORMAL = 1e-12  # axis along the normal: the ellipse is a circle to rounding


@njit(_nrt=False, forceinline=True)
def gap(bodies, b, x, y, z):
    """Signed distance of a point, negative inside, computed in the half-plane of axis and point."""
    u = np.sqrt(x * x + y * y) - bodies.rows[b, SIZE]
    w = abs(z) - bodies.rows[b, SIZE + 1]
    inside = min(max(u, w), 0.0)
    u, w = max(u, 0.0), max(w, 0.0)
    return np.sqrt(u * u + w * w) + inside


@njit(_nrt=False, forceinline=True)
def gap_of_bone(bodies, b, p, q):
    """Distance of the segment p-q, 0 when they meet."""
    return _off_cylinder(p, q, bodies.rows[b, SIZE], bodies.rows[b, SIZE + 1])


@njit(_nrt=False)
def _cylinder_slope(p, d, s, radius, half_length):
    """Half the derivative of the squared distance to a cylinder at p + s d."""
    x, y, z = p[0] + s * d[0], p[1] + s * d[1], p[2] + s * d[2]
    rad = np.sqrt(x * x + y * y)
    g = d[2] * excess(z, half_length)
    if rad > radius:
        g += (rad - radius) * (x * d[0] + y * d[1]) / rad
    return g


@njit(_nrt=False)
def _off_cylinder(p, q, radius, half_length):
    """Distance of segment p-q to a cylinder: the root of the slope of a convex function.

    Regula falsi with the Illinois rule, and bisection every third step, so that the bracket always
    shrinks. A slope of exactly 0 ends it, also inside, where the distance is flat at 0.
    """
    d = (q[0] - p[0], q[1] - p[1], q[2] - p[2])
    lo, hi = 0.0, 1.0
    g_lo = _cylinder_slope(p, d, lo, radius, half_length)
    g_hi = _cylinder_slope(p, d, hi, radius, half_length)
    if g_lo >= 0.0:
        hi = lo
    elif g_hi <= 0.0:
        lo = hi
    turn = 0
    while hi - lo > 1e-9:
        turn += 1
        m = 0.5 * (lo + hi) if turn % 3 == 0 else lo - g_lo * (hi - lo) / (g_hi - g_lo)
        g = _cylinder_slope(p, d, m, radius, half_length)
        if g == 0.0 or m <= lo or m >= hi:
            lo = hi = m
        elif g < 0.0:
            lo, g_lo, g_hi = m, g, 0.5 * g_hi
        else:
            hi, g_hi, g_lo = m, g, 0.5 * g_lo
    s = 0.5 * (lo + hi)
    x, y, z = p[0] + s * d[0], p[1] + s * d[1], p[2] + s * d[2]
    e = max(np.sqrt(x * x + y * y) - radius, 0.0)
    w = excess(z, half_length)
    return np.sqrt(e * e + w * w)


@njit(_nrt=False)
def from_nearest(bodies, b, x, y, z):
    """Vector (3) from the nearest point to a point; 0 from inside."""
    radius, length = bodies.rows[b, SIZE], bodies.rows[b, SIZE + 1]
    side = np.sqrt(x * x + y * y)
    out = max(side - radius, 0.0) / max(side, 1e-300)
    return out * x, out * y, z - min(max(z, -length), length)


@njit(_nrt=False)
def inner_radius(bodies, b):
    """Radius of the largest ball about the centre inside."""
    return min(bodies.rows[b, SIZE], bodies.rows[b, SIZE + 1])


@njit(_nrt=False)
def long_axis(bodies, b):
    """Axis (3), as long as half of the height."""
    return 0.0, 0.0, bodies.rows[b, SIZE + 1]


@njit(_nrt=False)
def cut(bodies, poses, b, made):
    """Cut a cylinder with the plane z = 0: a disc, or the polygon of an ellipse or a strip.

    Let u run along the axis' shadow on the plane and w across it, both from the point below the
    centre. Let lean and rise be the axis' components along u and z. A point of the plane lies
    ``lean u - rise z`` along the axis and ``hypot(w, rise u + lean z)`` off it.
    """
    radius, half = bodies.rows[b, SIZE], bodies.rows[b, SIZE + 1]
    x, y, z = poses[b, 0], poses[b, 1], poses[b, 2]
    ax, ay, rise = poses[b, 5], poses[b, 8], poses[b, 11]
    if rise < 0.0:  # the cylinder looks the same from its other end
        ax, ay, rise = -ax, -ay, -rise
    lean = np.hypot(ax, ay)
    if lean <= _NORMAL:
        made.discs[0, 0], made.discs[0, 1], made.discs[0, 2] = x, y, radius
        return 1 if abs(z) <= half else 0, 0
    low = (rise * z - half) / lean
    high = (rise * z + half) / lean
    shift = lean * z
    if rise > _PARALLEL:
        low = max(low, (-radius - shift) / rise)
        high = min(high, (radius - shift) / rise)
    elif abs(shift) > radius:
        return 0, 0
    if low > high:
        return 0, 0
    chain, corners = made.spare, made.corners
    count = _half_outline(chain, corners, radius, rise, shift, low, high)
    last = 2 * count - 1
    for k in range(count):
        u, w = chain[k, 0], chain[k, 1]
        corners[k, 0], corners[k, 1] = (ax * u + ay * w) / lean, (ay * u - ax * w) / lean
        corners[last - k, 0] = (ax * u - ay * w) / lean
        corners[last - k, 1] = (ay * u + ax * w) / lean
    return 0, placed(corners, 2 * count, x, y)


@njit(_nrt=False)
def _half_outline(chain, spare, radius, rise, shift, low, high):
    """Vertices (u, w), u rising from `low` to `high`, on w^2 + (rise u + shift)^2 = radius^2.

    Written into `chain`; returns their number.
    """
    start = min(max((rise * low + shift) / radius, -1.0), 1.0)
    stop = min(max((rise * high + shift) / radius, -1.0), 1.0)
    nodes = _arc_nodes(spare, np.arccos(-start), np.arccos(-stop), rise)
    chain[0, 0] = low
    count = 1
    for k in range(nodes):
        u = (-radius * np.cos(spare[k, 0]) - shift) / rise
        if chain[count - 1, 0] < u < high:
            chain[count, 0] = u
            count += 1
    chain[count, 0] = high
    for k in range(count + 1):
        # the two factors of radius^2 - (rise u + shift)^2; in this order of sums, a plane that all
        # but touches the cylinder does not roughen the outline
        climb = rise * chain[k, 0]
        below, above = (radius + shift) + climb, (radius - shift) - climb
        chain[k, 1] = np.sqrt(max(below, 0.0) * max(above, 0.0))
    return count + 1


@njit(_nrt=False)
def _arc_nodes(nodes, start, stop, rise):
    """Write angles between `start` and `stop` in [0, pi] at which an ellipse gets vertices.

    The half axes are 1 (angle pi/2) and 1/rise (angles 0 and pi). Nodes are laid from both ends
    towards the middle, where the ellipse bends least, and spread out if they are too many.
    Written into the first column; returns their number.
    """
    middle = 0.5 * np.pi
    step = np.sqrt(8.0 * ARC_ERROR)
    while True:
        first = _march(nodes, 0, start, min(stop, middle), rise, step)
        if start < middle < stop:
            nodes[first, 0] = middle
            first += 1
        last = _march(nodes, first, np.pi - stop, min(np.pi - start, middle), rise, step)
        if last <= _MOST_NODES:
            break
        step *= 1.01
    for k in range((last - first + 1) // 2):  # the second march came from the other end
        a, b = first + k, last - 1 - k
        nodes[a, 0], nodes[b, 0] = np.pi - nodes[b, 0], np.pi - nodes[a, 0]
    return last


@njit(_nrt=False)
def _march(nodes, first, start, stop, rise, step):
    """Write angles after `start` and before `stop` <= pi/2, so that every chord misses as much.

    A chord over the angle d misses d^2 / (8 s) where s is the ellipse's speed per angle over
    its value at pi/2. Since s grows from `start` on, the value at the chord's start is safe.
    Written from row `first` on; returns the next free row.
    """
    count = first
    angle = start
    while count < first + 2 * _MOST_NODES:
        speed = np.hypot(np.sin(angle), rise * np.cos(angle))
        angle += step * np.sqrt(speed)
        if angle >= stop:
            break
        nodes[count, 0] = angle
        count += 1
    return count
