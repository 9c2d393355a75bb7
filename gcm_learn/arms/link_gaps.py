"""Distances between the links of a limb, and the links near a point; link ends are array rows."""

from __future__ import annotations

import numpy as np

from gcm_learn.compiled import njit


@njit(_nrt=False, forceinline=True)
def segments_apart2(u, v, w):
    """Squared distance of two segments along u and v, the first of which begins w from the second.

    See C. Ericson, Real-Time Collision Detection, 5.1.9.
    """
    ux, uy, uz = u
    vx, vy, vz = v
    wx, wy, wz = w
    a, e = ux * ux + uy * uy + uz * uz, vx * vx + vy * vy + vz * vz
    f, c = vx * wx + vy * wy + vz * wz, ux * wx + uy * wy + uz * wz
    b = ux * vx + uy * vy + uz * vz
    s, t = 0.0, 0.0
    if a <= 1e-30 and e > 1e-30:
        t = min(max(f / e, 0.0), 1.0)
    elif a > 1e-30 and e <= 1e-30:
        s = min(max(-c / a, 0.0), 1.0)
    elif a > 1e-30:
        below = a * e - b * b
        s = min(max((b * f - c * e) / below, 0.0), 1.0) if below > 1e-14 * a * e else 0.0
        t = (b * s + f) / e
        if t < 0.0 or t > 1.0:
            t = min(max(t, 0.0), 1.0)
            s = min(max((b * t - c) / a, 0.0), 1.0)
    x, y, z = wx + s * ux - t * vx, wy + s * uy - t * vy, wz + s * uz - t * vz
    return x * x + y * y + z * z


@njit(_nrt=False)
def segments_gap2(r, i, j):
    """Squared distance of two links' axes."""
    u = r[i, 3] - r[i, 0], r[i, 4] - r[i, 1], r[i, 5] - r[i, 2]
    v = r[j, 3] - r[j, 0], r[j, 4] - r[j, 1], r[j, 5] - r[j, 2]
    return segments_apart2(u, v, (r[i, 0] - r[j, 0], r[i, 1] - r[j, 1], r[i, 2] - r[j, 2]))


@njit(_nrt=False)
def nearest_pair(pairs, radii, r, balls, ways, enough):
    """Distance of the nearest of some pairs of links, and the same less slack; see `self_gap`."""
    best, room = 1e300, 1e300
    for k in range(pairs.shape[0]):
        i, j = pairs[k, 0], pairs[k, 1]
        slip = ways[i] + ways[j]
        far = enough + slip + balls[i, 3] + balls[j, 3]
        x, y, z = balls[i, 0] - balls[j, 0], balls[i, 1] - balls[j, 1], balls[i, 2] - balls[j, 2]
        if far < 0.0 or x * x + y * y + z * z > far * far:
            continue
        gap = np.sqrt(max(segments_gap2(r, i, j), 0.0)) - radii[i] - radii[j]
        best, room = min(best, gap), min(room, gap - slip)
    return best, room


@njit(_nrt=False)
def near_links(balls, ways, x, y, z, far, near):
    """Write to `near` the links whose balls, enlarged by `ways`, are within `far` of a point.

    Returns
    -------
    int
        Number of these links.
    """
    count = 0
    for i in range(ways.size):
        u, v, w = x - balls[i, 0], y - balls[i, 1], z - balls[i, 2]
        most = far + balls[i, 3] + ways[i]
        near[count] = i
        if most >= 0.0 and u * u + v * v + w * w <= most * most:
            count += 1
    return count


def balls_about(ends: np.ndarray, radii: np.ndarray) -> np.ndarray:
    """Return balls about links (m, 4): centres, not yet known, and radii."""
    balls = np.zeros((len(ends), 4))
    # rounded up, as a link must not stick out
    balls[:, 3] = (0.5 * np.linalg.norm(ends[:, 3:] - ends[:, :3], axis=1) + radii) * (1.0 + 1e-9)
    return balls
