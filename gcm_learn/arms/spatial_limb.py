"""Four-joint kinematics in space: forward, Jacobian, bounds of motion.

Kernels have the shoulder at the origin and the base unturned; the functions below them take world
coordinates.
"""

from __future__ import annotations

import itertools
import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from gcm_learn.arms.curves import on_curve, rate_of, turn_of
from gcm_learn.arms.rotations import rotation_of
from gcm_learn.arms.spatial import JOINTS, SpatialArm
from gcm_learn.compiled import njit

SAMPLES = 1024  # postures from which a pole keeps away
NEAREST = 3  # of them, less one, may be nearer to it than its distance


class SpatialLimb(NamedTuple):
    """A spatial arm as kernels read it, its shoulder at the origin."""

    upper: np.ndarray  # (3,) shoulder to elbow, in the frame of the upper arm
    fore: np.ndarray  # (3,) elbow to hand, in the frame of the forearm
    low: np.ndarray  # (4,) ends of the joints' ranges [rad]
    high: np.ndarray  # (4,)
    pole: np.ndarray  # (3,) unit: swivels are undefined for hands in this direction
    zero: np.ndarray  # (3,) unit, orthogonal to the pole: near which swivels are 0
    rho: float  # lengths of upper arm and forearm
    length: float
    thickness: float  # radius of both
    start: np.ndarray  # (4,) joints at t = 0 [rad]
    rates: np.ndarray  # (4,) of the joints at t = 0 [rad/s]


@njit(_nrt=False)
def limb_at(limb, q):
    """Elbow and hand, six numbers, of joints (4,)."""
    u, f = limb.upper, limb.fore
    c1, s1, c2, s2 = np.cos(q[0]), np.sin(q[0]), np.cos(q[1]), np.sin(q[1])
    c3, s3, c4, s4 = np.cos(q[2]), np.sin(q[2]), np.cos(q[3]), np.sin(q[3])
    side = s4 * f[0] + c4 * f[1]
    x, y = u[0] + c4 * f[0] - s4 * f[1], u[1] + c3 * side - s3 * f[2]
    z = u[2] + s3 * side + c3 * f[2]
    ahead, there = c2 * u[0] - s2 * u[1], c2 * x - s2 * y
    return (
        c1 * ahead + s1 * u[2], s2 * u[0] + c2 * u[1], c1 * u[2] - s1 * ahead,
        c1 * there + s1 * z, s2 * x + c2 * y, c1 * z - s1 * there,
    )  # fmt: skip


@njit(_nrt=False)
def limbs_at(limb, joints, out):
    """Elbows and hands of joints (n, 4), into `out` (n, 6)."""
    for k in range(joints.shape[0]):
        row = limb_at(limb, joints[k])
        for i in range(6):
            out[k, i] = row[i]


@njit(_nrt=False)
def hand_jacobian(limb, q, out):
    """Derivative of the hand by the joints (4,), into `out` (3, 4): its columns axis x arm."""
    ex, ey, ez, hx, hy, hz = limb_at(limb, q)
    c1, s1, c2, s2 = np.cos(q[0]), np.sin(q[0]), np.cos(q[1]), np.sin(q[1])
    c3, s3 = np.cos(q[2]), np.sin(q[2])
    fx, fy, fz = hx - ex, hy - ey, hz - ez
    out[0, 0], out[1, 0], out[2, 0] = hz, 0.0, -hx  # about y
    out[0, 1], out[1, 1], out[2, 1] = -c1 * hy, c1 * hx - s1 * hz, s1 * hy  # about R_y z
    # about the upper arm's own x
    ax, ay, az = c1 * c2, s2, -s1 * c2
    out[0, 2], out[1, 2], out[2, 2] = ay * fz - az * fy, az * fx - ax * fz, ax * fy - ay * fx
    # about the forearm's z: R_y R_z R_x z
    ax, ay, az = c1 * s2 * s3 + s1 * c3, -c2 * s3, c1 * c3 - s1 * s2 * s3
    out[0, 3], out[1, 3], out[2, 3] = ay * fz - az * fy, az * fx - ax * fz, ax * fy - ay * fx


@njit(_nrt=False)
def motion_bounds(limb, q, p):
    """Bound the travel of points of upper arm and forearm on the line from q to p (4,).

    Joints 1 and 2 turn about orthogonal axes, and so do 3 and 4, so that rates add as the sides of
    a right angle.  Points of a bone move no farther than the farther of its ends, at any instant.

    Returns
    -------
    elbow, hand : float
        Of points of the upper arm, and of points of either bone.
    """
    shoulder = np.hypot(p[0] - q[0], p[1] - q[1])
    bend = np.hypot(p[2] - q[2], p[3] - q[3]) * limb.length
    _, _, _, x, y, z = limb_at(limb, q)
    there = np.sqrt(x * x + y * y + z * z)
    _, _, _, x, y, z = limb_at(limb, p)
    there += np.sqrt(x * x + y * y + z * z)
    farthest = min(0.5 * (there + bend), limb.rho + limb.length)
    elbow = shoulder * limb.rho
    return elbow, max(elbow, shoulder * farthest + bend)


@njit(_nrt=False, forceinline=True)
def dof(limb):
    """Number of joints."""
    return 4


@njit(_nrt=False, forceinline=True)
def hand_of(limb, place):
    """Hand of a place, which is elbow and hand."""
    return place[3], place[4], place[5]


@njit(_nrt=False)
def axis_of(limb, place):
    """Direction of the forearm, in which the hand reaches."""
    x, y, z = place[3] - place[0], place[4] - place[1], place[5] - place[2]
    return x / limb.length, y / limb.length, z / limb.length


@njit(_nrt=False, forceinline=True)
def link_count(limb):
    """Number of links: upper arm and forearm."""
    return 2


@njit(_nrt=False)
def link(limb, place, i):
    """Ends of a bone, and no radius beyond the limb's thickness."""
    ex, ey, ez, hx, hy, hz = place
    if i == 0:
        return 0.0, 0.0, 0.0, ex, ey, ez, 0.0
    return ex, ey, ez, hx, hy, hz, 0.0


@njit(_nrt=False, forceinline=True)
def ignores(limb, i, b):
    """No pair is ignored."""
    return False


@njit(_nrt=False, forceinline=True)
def self_gap(limb, place, slack, enough):
    """No pair of bones is checked."""
    return 1e300, 1e300


@njit(_nrt=False, forceinline=True)
def still(limb):
    """Slack of a limb that rests."""
    return 0.0, 0.0


@njit(_nrt=False)
def swept(limb, curve, s, half, place):
    """Bound how far points of upper arm and forearm travel from share s of a move to s +- half.

    Joints 1 and 2 turn about orthogonal axes, and so do 3 and 4. So rates add as the sides of a
    right angle. Turned about the shoulder, a point moves no more than the hand or the elbow.
    `place` has elbow and hand at s.
    """
    shoulder = np.hypot(turn_of(curve, 0, s, half), turn_of(curve, 1, s, half))
    bend = np.hypot(turn_of(curve, 2, s, half), turn_of(curve, 3, s, half)) * limb.length
    _, _, _, x, y, z = place
    farthest = min(np.sqrt(x * x + y * y + z * z) + bend, limb.rho + limb.length)
    upper = shoulder * limb.rho
    return upper, max(upper, shoulder * farthest + bend)


@njit(_nrt=False, forceinline=True)
def slack_of(limb, slack, i):
    """Slack of a bone."""
    return slack[i]


@njit(_nrt=False)
def hand_rate(limb, curve, s, q):
    """Way of the hand per share of a move, at share s; `q` (4,) is overwritten with the joints."""
    on_curve(curve, s, q)
    x, y, z = hand_velocity(limb, curve, s, q)
    return np.sqrt(x * x + y * y + z * z)


@njit(_nrt=False)
def hand_velocity(limb, curve, s, q):
    """Derivative of the hand by the share of a move, at share s where the joints are q (4,)."""
    ex, ey, ez, hx, hy, hz = limb_at(limb, q)
    c1, s1, c2, s2 = np.cos(q[0]), np.sin(q[0]), np.cos(q[1]), np.sin(q[1])
    c3, s3 = np.cos(q[2]), np.sin(q[2])
    r = rate_of(curve, 0, s), rate_of(curve, 1, s), rate_of(curve, 2, s), rate_of(curve, 3, s)
    # what turns all: about y, then about R_y z
    wx, wy, wz = r[1] * s1, r[0], r[1] * c1
    x, y, z = wy * hz - wz * hy, wz * hx - wx * hz, wx * hy - wy * hx
    # what turns the forearm: about the upper arm's x, then about R_y R_z R_x z
    fx, fy, fz = hx - ex, hy - ey, hz - ez
    wx = r[2] * c1 * c2 + r[3] * (c1 * s2 * s3 + s1 * c3)
    wy = r[2] * s2 - r[3] * c2 * s3
    wz = -r[2] * s1 * c2 + r[3] * (c1 * c3 - s1 * s2 * s3)
    return x + wy * fz - wz * fy, y + wz * fx - wx * fz, z + wx * fy - wy * fx


@njit(_nrt=False)
def hand_travel(limb, q, p):
    """Bound how far the hand travels on the straight move from q to p (4,)."""
    return motion_bounds(limb, q, p)[1]


@njit(_nrt=False)
def hand_bound(limb, rates):
    """Bound of the hand's speed; joints 1 and 2 turn about orthogonal axes, as do 3 and 4."""
    far = limb.rho + limb.length
    return np.hypot(rates[0], rates[1]) * far + np.hypot(rates[2], rates[3]) * limb.length


@njit(_nrt=False)
def axis_bound(limb, rates):
    """Bound of the forearm's angular speed."""
    return np.hypot(rates[0], rates[1]) + np.hypot(rates[2], rates[3])


@njit(_nrt=False, forceinline=True)
def reach_of(limb):
    """Bound of the distance between shoulder and hand: both bones in line."""
    return limb.rho + limb.length


@njit(_nrt=False)
def axis_turns(limb, q, out):
    """Write the derivative of the forearm's direction by the joints (4,) into `out` (3, 4)."""
    ex, ey, ez, hx, hy, hz = limb_at(limb, q)
    c1, s1, c2, s2 = np.cos(q[0]), np.sin(q[0]), np.cos(q[1]), np.sin(q[1])
    c3, s3 = np.cos(q[2]), np.sin(q[2])
    fx, fy, fz = (hx - ex) / limb.length, (hy - ey) / limb.length, (hz - ez) / limb.length
    axes = (
        (0.0, 1.0, 0.0), (s1, 0.0, c1), (c1 * c2, s2, -s1 * c2),
        (c1 * s2 * s3 + s1 * c3, -c2 * s3, c1 * c3 - s1 * s2 * s3),
    )  # fmt: skip
    for j in range(4):
        ax, ay, az = axes[j]
        out[0, j] = ay * fz - az * fy
        out[1, j], out[2, j] = az * fx - ax * fz, ax * fy - ay * fx


def spatial_limb_of(arm: SpatialArm) -> SpatialLimb:
    """A spatial arm as kernels read it."""
    pole = _pole(arm.upper_arm, arm.forearm, arm.joint_range)
    return SpatialLimb(
        *_bones(arm.upper_arm, arm.forearm, arm.joint_range),
        pole=_TOWARDS[pole].copy(),
        zero=_ACROSS[pole].copy(),
        rho=math.hypot(*arm.upper_arm),
        length=math.hypot(*arm.forearm),
        thickness=arm.thickness,
        start=np.array(arm.joints),
        rates=np.array(arm.joint_rates or (0.0,) * JOINTS),
    )


def forward_in_space(arm: SpatialArm, joints: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Elbow and hand of joint angles, in the world.

    Parameters
    ----------
    arm : SpatialArm
    joints : (..., 4) array_like
        Joint angles [rad], in their ranges or not.

    Returns
    -------
    elbow, hand : (..., 3) ndarray
    """
    given = np.ascontiguousarray(joints, dtype=float)
    out = np.empty((given.size // JOINTS, 6))
    limbs_at(spatial_limb_of(arm), given.reshape(-1, JOINTS), out)
    rows = out.reshape(*given.shape[:-1], 2, 3) @ rotation_of(arm.base.rotation).T
    world = rows + np.array(arm.base.origin)
    return world[..., 0, :], world[..., 1, :]


def _bones(
    upper: ArrayLike, fore: ArrayLike, ranges: ArrayLike
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Upper arm, forearm and the ends of the joints' ranges, as arrays."""
    low, high = np.array(ranges).T.copy()
    return np.array(upper, dtype=float), np.array(fore, dtype=float), low, high


@lru_cache(maxsize=64)
def _pole(
    upper: tuple[float, ...], fore: tuple[float, ...], ranges: tuple[tuple[float, float], ...]
) -> int:
    """Return the index of the direction in `_TOWARDS` that hands avoid.

    Sampled hands are farthest from this direction, seen from the shoulder.  The hands of some
    arms can be in every direction; then few of them come near to it.
    """
    return int(_avoided(_Bones(*_bones(upper, fore, ranges)), _SPREAD, _TOWARDS))


class _Bones(NamedTuple):
    """Bones of a limb, as `limb_at` takes them, and its ranges."""

    upper: np.ndarray
    fore: np.ndarray
    low: np.ndarray
    high: np.ndarray


@njit
def _avoided(bones, spread, towards):
    """First of the directions (m, 3) whose NEAREST-th nearest hand is farthest away.

    Parameters
    ----------
    spread : (n, 4) ndarray
        The hands' joints, as shares of their ranges.
    """
    hands, q, found = np.empty((spread.shape[0], 4)), np.empty(4), np.empty(NEAREST)
    for k in range(spread.shape[0]):
        for j in range(4):
            q[j] = bones.low[j] + spread[k, j] * (bones.high[j] - bones.low[j])
        _, _, _, x, y, z = limb_at(bones, q)
        far = max(np.sqrt(x * x + y * y + z * z), 1e-300)
        hands[k, 0], hands[k, 1], hands[k, 2], hands[k, 3] = x, y, z, far
    best, least = 0, 2.0
    for m in range(towards.shape[0]):
        found[:] = -2.0
        for k in range(hands.shape[0]):
            along = hands[k, 0] * towards[m, 0] + hands[k, 1] * towards[m, 1]
            cosine = (along + hands[k, 2] * towards[m, 2]) / hands[k, 3]
            if cosine > found[0]:
                i = 0
                while i + 1 < NEAREST and cosine > found[i + 1]:
                    found[i] = found[i + 1]
                    i += 1
                found[i] = cosine
                if found[0] >= least:
                    break
        if found[0] < least:
            best, least = m, found[0]
    return best


def _grid() -> np.ndarray:
    """The 26 directions (26, 3) to the neighbours in a grid."""
    grid = np.array([d for d in itertools.product((0.0, -1.0, 1.0), repeat=3) if any(d)])
    return grid / np.linalg.norm(grid, axis=1)[:, None]


def _spread() -> np.ndarray:
    """Points (SAMPLES, 4) spread evenly over the unit cube: an additive recurrence."""
    ratio = 1.1673039782614187  # root of x^5 = x + 1, as the golden ratio is of x^2 = x + 1
    steps = ratio ** -np.arange(1.0, JOINTS + 1.0)
    return (0.5 + np.arange(SAMPLES)[:, None] * steps) % 1.0


def _across(directions: np.ndarray) -> np.ndarray:
    """One direction orthogonal to each."""
    least = np.abs(directions).argmin(axis=1)
    across = np.cross(directions, np.eye(3)[least])
    return np.array([row / np.linalg.norm(row) for row in across])


_SPREAD, _TOWARDS = _spread(), _grid()
_ACROSS = _across(_TOWARDS)
