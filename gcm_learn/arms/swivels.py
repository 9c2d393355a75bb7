"""Closed-form inverse of the spatial arm: hands, swivels of the elbow, and their joints.

For a hand there is a circle of elbows, and a *swivel* says where on it the elbow is: the angle
about the line from shoulder to hand.  It counts from the stereographic reference of Elias and Wen
(arXiv 2307.13122).  It is undefined for hands on one half-line, in the direction of the limb's
`pole`.  Any such reference is undefined somewhere, and the usual one is on a whole line.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.arms.curves import turn_of
from gcm_learn.compiled import njit

BRANCHES = 4  # most ways in which four joints can hold elbow and hand where they are
SLACK = 1e-7  # of angles at the ends of their ranges, where they are put back [rad]
ROUNDING = 1e-9  # share of the reach by which a solution may miss its hand
CLAMPED = 2e-7  # and its elbow, which at the rims is the root of a rounding error
STRAIGHT = 1e-7  # share of the upper arm within which elbow, shoulder and hand are in one line
UPPER, FORE, POLE, ZERO, RHO, LENGTH = 0, 3, 6, 9, 12, 13
"""Places in `ChainLimb.solved`.

Upper arm and forearm (3), each in its own bone's frame; the direction (3) of hands for which
swivels are undefined; a direction (3) across, near which swivels are 0; the bones' lengths.
"""


@njit(_nrt=False)
def bones_at(bones, q):
    """Elbow and hand, six numbers, of upper arm and forearm (6,) at joints (4,)."""
    ux, uy, uz = bones[UPPER], bones[UPPER + 1], bones[UPPER + 2]
    fx, fy, fz = bones[FORE], bones[FORE + 1], bones[FORE + 2]
    c1, s1, c2, s2 = np.cos(q[0]), np.sin(q[0]), np.cos(q[1]), np.sin(q[1])
    c3, s3, c4, s4 = np.cos(q[2]), np.sin(q[2]), np.cos(q[3]), np.sin(q[3])
    side = s4 * fx + c4 * fy
    x, y = ux + c4 * fx - s4 * fy, uy + c3 * side - s3 * fz
    z = uz + s3 * side + c3 * fz
    ahead, there = c2 * ux - s2 * uy, c2 * x - s2 * y
    return (
        c1 * ahead + s1 * uz, s2 * ux + c2 * uy, c1 * uz - s1 * ahead,
        c1 * there + s1 * z, s2 * x + c2 * y, c1 * z - s1 * there,
    )  # fmt: skip


@njit(_nrt=False, forceinline=True)
def limb_at(limb, q):
    """Elbow and hand, six numbers, of joints (4,)."""
    return bones_at(limb.solved, q)


@njit(_nrt=False)
def place_bones(solved, q, reaches, balls):
    """Write both bones, the hand with its axis, and the bones' midpoints; see `place`."""
    ex, ey, ez, x, y, z = bones_at(solved, q)
    ux, uy, uz, far = x - ex, y - ey, z - ez, 1.0 / solved[LENGTH]
    reaches[0, 0], reaches[0, 1], reaches[0, 2] = 0.0, 0.0, 0.0
    reaches[0, 3], reaches[0, 4], reaches[0, 5] = ex, ey, ez
    reaches[1, 0], reaches[1, 1], reaches[1, 2] = ex, ey, ez
    reaches[1, 3], reaches[1, 4], reaches[1, 5] = x, y, z
    reaches[2, 0], reaches[2, 1], reaches[2, 2] = x, y, z
    reaches[2, 3], reaches[2, 4], reaches[2, 5] = far * ux, far * uy, far * uz
    balls[0, 0], balls[0, 1], balls[0, 2] = 0.5 * ex, 0.5 * ey, 0.5 * ez
    balls[1, 0], balls[1, 1], balls[1, 2] = 0.5 * (ex + x), 0.5 * (ey + y), 0.5 * (ez + z)


@njit(_nrt=False)
def sweep_bones(solved, hand, curve, s, half, ways):
    """Write how far points of upper arm and forearm travel into `ways` (2,); see `swept`.

    Joints 1 and 2 turn about orthogonal axes, and so do 3 and 4. So rates add as the sides of a
    right angle. Turned about the shoulder, a point moves no more than the hand or the elbow.
    """
    shoulder = np.hypot(turn_of(curve, 0, s, half), turn_of(curve, 1, s, half))
    bend = np.hypot(turn_of(curve, 2, s, half), turn_of(curve, 3, s, half)) * solved[LENGTH]
    x, y, z = hand
    farthest = min(np.sqrt(x * x + y * y + z * z) + bend, solved[RHO] + solved[LENGTH])
    ways[0] = shoulder * solved[RHO]
    ways[1] = max(ways[0], shoulder * farthest + bend)


@njit(_nrt=False)
def speed_of_bones(solved, rates):
    """Bound of the hand's speed; joints 1 and 2 turn about orthogonal axes, as do 3 and 4."""
    turn, bend = np.hypot(rates[0], rates[1]), np.hypot(rates[2], rates[3])
    return turn * (solved[RHO] + solved[LENGTH]) + bend * solved[LENGTH]


@njit(_nrt=False)
def travel_of_bones(solved, q, p):
    """Bound how far points of both bones travel on the line from q to p (4,); see `sweep_bones`."""
    shoulder = np.hypot(p[0] - q[0], p[1] - q[1])
    bend = np.hypot(p[2] - q[2], p[3] - q[3]) * solved[LENGTH]
    _, _, _, x, y, z = bones_at(solved, q)
    there = np.sqrt(x * x + y * y + z * z)
    _, _, _, x, y, z = bones_at(solved, p)
    there += np.sqrt(x * x + y * y + z * z)
    farthest = min(0.5 * (there + bend), solved[RHO] + solved[LENGTH])
    return max(shoulder * solved[RHO], shoulder * farthest + bend)


@njit(_nrt=False)
def swivel_axes(limb, x, y, z):
    """Return a hand's distance and direction, and two axes that measure swivels: ten numbers."""
    s = limb.solved
    ox, oy, oz = s[ZERO], s[ZERO + 1], s[ZERO + 2]
    r = np.sqrt(x * x + y * y + z * z)
    if r < 1e-12 * s[RHO]:  # the direction is undefined at the shoulder: take that of the zero
        nx, ny, nz = ox, oy, oz
    else:
        nx, ny, nz = x / r, y / r, z / r
    dx, dy, dz = nx - s[POLE], ny - s[POLE + 1], nz - s[POLE + 2]
    kx, ky, kz = dy * oz - dz * oy, dz * ox - dx * oz, dx * oy - dy * ox
    ax, ay, az = ky * nz - kz * ny, kz * nx - kx * nz, kx * ny - ky * nx
    size = np.sqrt(ax * ax + ay * ay + az * az)
    if size < 1e-12:  # on the half-line: any reference will do
        ax, ay, az, size = ox, oy, oz, 1.0
    ax, ay, az = ax / size, ay / size, az / size
    return r, nx, ny, nz, ax, ay, az, ny * az - nz * ay, nz * ax - nx * az, nx * ay - ny * ax


@njit(_nrt=False)
def swivel_of(limb, ex, ey, ez, hx, hy, hz):
    """Return an elbow's swivel in (-pi, pi] [rad]; arbitrary if the elbow's circle is a point."""
    _, _, _, _, ax, ay, az, bx, by, bz = swivel_axes(limb, hx, hy, hz)
    return np.arctan2(ex * bx + ey * by + ez * bz, ex * ax + ey * ay + ez * az)


@njit(_nrt=False)
def elbow_at(limb, hx, hy, hz, swivel):
    """Elbow of a hand and a swivel; of hands out of reach, as if they were on the rim."""
    r, nx, ny, nz, ax, ay, az, bx, by, bz = swivel_axes(limb, hx, hy, hz)
    rho, length = limb.solved[RHO], limb.solved[LENGTH]
    along = rho
    if r > 0.0:
        along = 0.5 * (r + (rho - length) * (rho + length) / r)
    along = min(max(along, -rho), rho)
    radius = np.sqrt((rho - along) * (rho + along))
    if radius < STRAIGHT * rho:  # a root of rounding errors, which has no direction
        radius, along = 0.0, np.copysign(rho, along)
    c, s = radius * np.cos(swivel), radius * np.sin(swivel)
    return (
        along * nx + c * ax + s * bx, along * ny + c * ay + s * by, along * nz + c * az + s * bz
    )  # fmt: skip


@njit(_nrt=False)
def in_range(angle, low, high, near):
    """Return whether an angle, up to whole turns, is in a range, and its value nearest `near`."""
    turn = 2.0 * np.pi
    least, most = np.ceil((low - SLACK - angle) / turn), np.floor((high + SLACK - angle) / turn)
    turns = min(max(np.round((near - angle) / turn), least), most)
    return least <= most, min(max(angle + turn * turns, low), high)


@njit(_nrt=False)
def joints_of_limb(limb, ex, ey, ez, hx, hy, hz, near, out):
    """All joints within their ranges that put elbow and hand where they are, into `out` (4, 4).

    Two axes may fall into one line: the upper arm along y, or the forearm along the upper arm's x.
    One of the two joints is then free and stays `near`.  Of angles some turns apart the one nearest
    to `near` (4,) is taken.

    Returns
    -------
    count : int
        Rows of `out` that are solutions, each confirmed by the forward kinematics.
    """
    u, f, count = limb.solved[UPPER:FORE], limb.solved[FORE:POLE], 0
    tiny = 1e-12 * (limb.solved[RHO] + limb.solved[LENGTH])
    swings, rolls = np.hypot(u[0], u[1]) > tiny, np.hypot(f[0], f[1]) > tiny
    wide = np.sqrt(max(ex * ex + ez * ez - u[2] * u[2], 0.0)) if swings else 0.0
    for side in (wide, -wide):
        # R_z(q2) u has the elbow's y, and with `side` along x its distance from the y axis
        q1, q2 = near[0], near[1]
        if np.hypot(ex, ez) > tiny:
            q1 = np.arctan2(ex, ez) - np.arctan2(side, u[2])
        if swings:
            q2 = np.arctan2(ey, side) - np.arctan2(u[1], u[0])
        # the forearm in the frame of the upper arm
        c, s = np.cos(q1), np.sin(q1)
        x, y, z = c * (hx - ex) - s * (hz - ez), hy - ey, s * (hx - ex) + c * (hz - ez)
        c, s = np.cos(q2), np.sin(q2)
        x, y = c * x + s * y, c * y - s * x
        deep = np.sqrt(max(y * y + z * z - f[2] * f[2], 0.0)) if rolls else 0.0
        for bend in (deep, -deep):
            # R_z(q4) f has its x, and with `bend` along y its distance from the x axis
            q3, q4 = near[2], near[3]
            if np.hypot(y, z) > tiny:
                q3 = np.arctan2(z, y) - np.arctan2(f[2], bend)
            if rolls:
                q4 = np.arctan2(bend, x) - np.arctan2(f[1], f[0])
            if count < BRANCHES and _fits(limb, q1, q2, q3, q4, near, out[count]):
                if _reaches(limb, out[count], ex, ey, ez, hx, hy, hz):
                    count += 1
            if deep == 0.0:
                break
        if wide == 0.0:
            break
    return count


@njit(_nrt=False)
def inverse(limb, hx, hy, hz, swivel, near, out):
    """All joints within their ranges of a hand and a swivel, into `out` (4, 4); their number."""
    ex, ey, ez = elbow_at(limb, hx, hy, hz, swivel)
    return joints_of_limb(limb, ex, ey, ez, hx, hy, hz, near, out)


@njit(_nrt=False)
def _fits(limb, q1, q2, q3, q4, near, out):
    """Return whether angles, some turns away or not, are in their ranges; `out` (4,) gets them."""
    fits, out[0] = in_range(q1, limb.low[0], limb.high[0], near[0])
    there, out[1] = in_range(q2, limb.low[1], limb.high[1], near[1])
    fits = fits and there
    there, out[2] = in_range(q3, limb.low[2], limb.high[2], near[2])
    fits = fits and there
    there, out[3] = in_range(q4, limb.low[3], limb.high[3], near[3])
    return fits and there


@njit(_nrt=False)
def _reaches(limb, q, ex, ey, ez, hx, hy, hz):
    """Return whether joints (4,) put elbow and hand where they should be."""
    ax, ay, az, bx, by, bz = limb_at(limb, q)
    elbow = (ax - ex) ** 2 + (ay - ey) ** 2 + (az - ez) ** 2
    hand = (bx - hx) ** 2 + (by - hy) ** 2 + (bz - hz) ** 2
    reach = limb.reach
    return elbow <= (CLAMPED * reach) ** 2 and hand <= (ROUNDING * reach) ** 2
