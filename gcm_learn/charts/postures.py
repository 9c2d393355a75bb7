"""The rule by which a hand in space has one posture for each of K swivels of the elbow.

A hand leaves the elbow a circle.  Of K postures the k-th has the swivel of the arm at t = 0 and k
K-ths of a turn. If the joints' ranges forbid that, it takes the nearest allowed swivel in its
own K-th of the circle.  Postures are on the branch of the inverse kinematics that the arm is on at
t = 0, or on another if that one allows none.  So the first posture of the hand at t = 0 is the
arm's own.

Joints jump where the nearest swivel changes sides, where the branch changes, and where allowed
swivels end or fall apart. They also jump next to the shoulder, and on the half-line on which
swivels are undefined.  There is no step there: a joint would turn farther than `leap_of`.
"""

from __future__ import annotations

import itertools
from typing import NamedTuple

import numpy as np

from gcm_learn.arms.spatial_limb import SpatialLimb, limb_at
from gcm_learn.arms.swivels import in_range, swivel_axes, swivel_of
from gcm_learn.compiled import njit

TRIED = np.pi / 12.0  # swivels that are tried where the first is not allowed are this near [rad]
HALVINGS = 7  # of what lies between the first that is allowed and the last that is not
BENT = 0.05  # by which a straight arm is folded to see where its elbow would go [rad]
_TINY = 1e-12  # share of squared lengths within which a root is one of a rounding error
_GRID = 65  # angles at which the elbow is checked for the hand's nearest and farthest


class Rule(NamedTuple):
    """Rule by which a hand has its postures; made by `rule_of`."""

    limb: SpatialLimb
    swivel: float  # at t = 0 [rad]
    branches: np.ndarray  # (m, 2): +1 or -1, on which side of the y axis the upper arm swings, and
    #                       to which side of it the forearm bends; that of t = 0 first
    postures: int  # K
    near: float  # distances from the shoulder between which hands can be
    far: float


def rule_of(limb: SpatialLimb, postures: int = 1) -> Rule:
    """The rule for a limb: K postures of which the first is its own at t = 0."""
    q = limb.start.copy()
    if _is_straight(limb, q):  # bend it to where there is more room: the branch follows
        away = q[3] - limb.low[3] < limb.high[3] - q[3]
        q[3] += BENT if away else -BENT
    swivel = swivel_of(limb, *limb_at(limb, q))
    return Rule(limb, float(swivel), _branches(limb, q), postures, *_distances(limb))


def leap_of(limb: SpatialLimb, spacing: float) -> float:
    """Angle by which no joint turns in a step between neighbouring cells [rad].

    From the rim, where the arm is stretched, the elbow bends with the root of the way
    inwards. Away from jumps, joints change nowhere faster.
    """
    step, reach = np.sqrt(3.0) * spacing, limb.rho + limb.length
    return float(min(np.sqrt(2.0 * step * reach / (limb.rho * limb.length)), 0.9 * np.pi))


def _branches(limb: SpatialLimb, q: np.ndarray) -> np.ndarray:
    """Branches (m, 2) within the joints' ranges; the branch of joints q (4,) comes first."""
    u, f, share = limb.upper, limb.fore, np.linspace(0.0, 1.0, _GRID)
    q2, q4 = (np.append(q[j], limb.low[j] + share * (limb.high[j] - limb.low[j])) for j in (1, 3))
    sides = _signs(np.cos(q2) * u[0] - np.sin(q2) * u[1], limb.rho)
    bends = _signs(np.sin(q4) * f[0] + np.cos(q4) * f[1], limb.length)
    return np.array(list(itertools.product(sides, bends)))


def _signs(values: np.ndarray, unit: float) -> list[float]:
    """Signs that occur among values, that of the first before the other."""
    first = 1.0 if values[0] >= 0.0 else -1.0
    return [first, -first] if (first * values < -1e-6 * unit).any() else [first]


def _is_straight(limb: SpatialLimb, q: np.ndarray) -> bool:
    """Return whether elbow, shoulder and hand are in one line, without a swivel."""
    place = np.array(limb_at(limb, q))
    return bool(np.linalg.norm(np.cross(place[:3], place[3:])) < 1e-6 * limb.rho * limb.length)


def _distances(limb: SpatialLimb) -> tuple[float, float]:
    """Distances from the shoulder between which the hand is at any joints in their ranges."""
    share = np.linspace(0.0, 1.0, _GRID)
    q3, q4 = (limb.low[j] + share * (limb.high[j] - limb.low[j]) for j in (2, 3))
    u, f = limb.upper, limb.fore
    along = np.cos(q4) * f[0] - np.sin(q4) * f[1]
    across = (np.sin(q4) * f[0] + np.cos(q4) * f[1])[None, :]
    c, s = np.cos(q3)[:, None], np.sin(q3)[:, None]
    seen = u[0] * along + u[1] * (c * across - s * f[2]) + u[2] * (s * across + c * f[2])
    width = max(limb.high[2] - limb.low[2], limb.high[3] - limb.low[3]) / (_GRID - 1)
    square = limb.rho**2 + limb.length**2 + 2.0 * np.array([seen.min(), seen.max()])
    square += np.array([-1.0, 1.0]) * 2.0 * limb.rho * limb.length * width
    near, far = np.sqrt(np.maximum(square, 0.0))
    return float(near), float(min(far, limb.rho + limb.length))


@njit(_nrt=False)
def _root(square, unit):
    """Root of a square that may be a rounding error below 0; -1 if it is more than that."""
    if square < 0.0:
        return 0.0 if square > -_TINY * unit * unit else -1.0
    return np.sqrt(square)


@njit(_nrt=False)
def held(rule, branch, x, y, z, swivel, q):
    """Return whether the arm reaches the hand (x, y, z) with a swivel; q (4,) gets the joints.

    It is `scene.spatial_limb.inverse` on one branch of the rule.
    """
    limb = rule.limb
    u, f = limb.upper, limb.fore
    r, nx, ny, nz, ax, ay, az, bx, by, bz = swivel_axes(limb, x, y, z)
    if r <= 0.0:
        return False
    along = 0.5 * (r + (limb.rho - limb.length) * (limb.rho + limb.length) / r)
    radius = _root((limb.rho - along) * (limb.rho + along), limb.rho)
    if radius < 0.0:
        return False
    c, s = radius * np.cos(swivel), radius * np.sin(swivel)
    ex, ey = along * nx + c * ax + s * bx, along * ny + c * ay + s * by
    ez = along * nz + c * az + s * bz
    wide = _root(ex * ex + ez * ez - u[2] * u[2], limb.rho)
    if wide < 0.0:
        return False
    side, square = rule.branches[branch, 0] * wide, ex * ex + ez * ez
    if square > _TINY * limb.rho * limb.rho:
        s, c = (ex * u[2] - ez * side) / square, (ez * u[2] + ex * side) / square
        fits, q[0] = in_range(np.arctan2(s, c), limb.low[0], limb.high[0], limb.start[0])
    else:  # the upper arm is along the y axis
        fits, q[0] = True, limb.start[0]
        s, c = np.sin(q[0]), np.cos(q[0])
    if not fits:
        return False
    dx, dy, dz = x - ex, y - ey, z - ez
    dx, dz = c * dx - s * dz, s * dx + c * dz
    s, c = ey * u[0] - side * u[1], side * u[0] + ey * u[1]
    size = np.sqrt(s * s + c * c)
    if size > _TINY * limb.rho * limb.rho:
        s, c = s / size, c / size
        fits, q[1] = in_range(np.arctan2(s, c), limb.low[1], limb.high[1], limb.start[1])
    else:
        q[1] = limb.start[1]
        s, c = np.sin(q[1]), np.cos(q[1])
    if not fits:
        return False
    dx, dy = c * dx + s * dy, c * dy - s * dx
    deep = _root(dy * dy + dz * dz - f[2] * f[2], limb.length)
    if deep < 0.0:
        return False
    bend = rule.branches[branch, 1] * deep
    if dy * dy + dz * dz > _TINY * limb.length * limb.length:
        angle = np.arctan2(dz * bend - dy * f[2], dy * bend + dz * f[2])
        fits, q[2] = in_range(angle, limb.low[2], limb.high[2], limb.start[2])
    else:  # the forearm is along the upper arm's x
        q[2] = limb.start[2]
    angle = np.arctan2(bend * f[0] - dx * f[1], dx * f[0] + bend * f[1])
    there, q[3] = in_range(angle, limb.low[3], limb.high[3], limb.start[3])
    return fits and there


@njit(_nrt=False)
def posture_of(rule, k, x, y, z, q):
    """Write the k-th posture of the hand (x, y, z) into q (4,); return False without one.

    Parameters
    ----------
    x, y, z : float
        In the frame of the base.
    """
    away = np.sqrt(x * x + y * y + z * z)
    if away < rule.near or away > rule.far:
        return False
    own, width = rule.swivel + 2.0 * np.pi * k / rule.postures, np.pi / rule.postures
    tries = int(np.ceil(width / TRIED))
    for branch in range(rule.branches.shape[0]):
        if held(rule, branch, x, y, z, own, q):
            return True
        for i in range(1, tries + 1):
            far, sign = width * i / tries, 1.0
            if not held(rule, branch, x, y, z, own + far, q):
                if not held(rule, branch, x, y, z, own - far, q):
                    continue
                sign = -1.0
            near = width * (i - 1) / tries
            for _ in range(HALVINGS):
                middle = 0.5 * (near + far)
                if held(rule, branch, x, y, z, own + sign * middle, q):
                    far = middle
                else:
                    near = middle
            return held(rule, branch, x, y, z, own + sign * far, q)
    return False
