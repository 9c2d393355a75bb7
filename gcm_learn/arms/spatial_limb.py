"""The spatial arm as a chain of four joints, whose inverse has a closed form.

Kernels have the shoulder at the origin and the base unturned; the functions below them take world
coordinates.
"""

from __future__ import annotations

import itertools
import math
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from gcm_learn.arms.chain_limb import ChainLimb, limb_of_chain
from gcm_learn.arms.rotations import rotation_of
from gcm_learn.arms.spatial import JOINTS, SpatialArm
from gcm_learn.arms.swivels import BRANCHES, bones_at, inverse, limb_at, swivel_of
from gcm_learn.compiled import njit

SAMPLES = 1024  # postures from which a pole keeps away
NEAREST = 3  # of them, less one, may be nearer to it than its distance


ROOM = ("frames", "axes", "reaches", "balls", "near", "ways", "turns", "paces")
"""Arrays of a limb that kernels write."""


def spatial_limb_of(arm: SpatialArm, bodies: tuple[str, ...] = ()) -> ChainLimb:
    """Return the arrays of a spatial arm for the kernels; its thickness is the links' radius."""
    limb = _limb(arm.upper_arm, arm.forearm, arm.joint_range, arm.max_joint_speed)
    return limb._replace(
        start=np.array(arm.joints),
        rates=np.array(arm.joint_rates or (0.0,) * JOINTS),
        thickness=arm.thickness,
        ignored=np.zeros((2, len(bodies)), dtype=np.bool_),
        **{name: getattr(limb, name).copy() for name in ROOM},
    )


@lru_cache(maxsize=64)
def _limb(
    upper: tuple[float, float, float],
    fore: tuple[float, float, float],
    ranges: tuple[tuple[float, float], ...],
    speeds: tuple[float, float, float, float],
) -> ChainLimb:
    """Return the limb of two bones, cached because every situation packs one."""
    low: Any = tuple(low for low, _ in ranges)
    limb = limb_of_chain(
        SpatialArm(
            upper_arm=upper, forearm=fore, joints=low, joint_range=ranges, max_joint_speed=speeds,
            grasp=0.0,
        )
    )  # fmt: skip
    rho, length, pole = math.hypot(*upper), math.hypot(*fore), _pole(upper, fore, ranges)
    limb.balls[:, 3] = np.array([0.5 * rho, 0.5 * length]) * (1.0 + 1e-9)
    numbers = [*upper, *fore, *_TOWARDS[pole], *_ACROSS[pole], rho, length]
    return limb._replace(length=length, solved=np.array(numbers))


@lru_cache(maxsize=64)
def _pole(
    upper: tuple[float, ...], fore: tuple[float, ...], ranges: tuple[tuple[float, float], ...]
) -> int:
    """Return the index of the direction in `_TOWARDS` that hands avoid.

    Sampled hands are farthest from this direction, seen from the shoulder.  The hands of some
    arms can be in every direction; then few of them come near to it.
    """
    return int(_avoided(np.array([*upper, *fore]), np.array(ranges), _SPREAD, _TOWARDS))


@njit
def _avoided(bones, ranges, spread, towards):
    """Return the first index in `towards` (m, 3) whose NEAREST-th nearest hand is farthest away.

    Parameters
    ----------
    spread : (n, 4) ndarray
        The hands' joints, as shares of their ranges.
    """
    hands, q, found = np.empty((spread.shape[0], 4)), np.empty(4), np.empty(NEAREST)
    for k in range(spread.shape[0]):
        for j in range(4):
            q[j] = ranges[j, 0] + spread[k, j] * (ranges[j, 1] - ranges[j, 0])
        _, _, _, x, y, z = bones_at(bones, q)
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
    """Return for each direction (k, 3) one unit vector orthogonal to it."""
    least = np.abs(directions).argmin(axis=1)
    across = np.cross(directions, np.eye(3)[least])
    return np.array([row / np.linalg.norm(row) for row in across])


_SPREAD, _TOWARDS = _spread(), _grid()
_ACROSS = _across(_TOWARDS)


def inverse_in_space(
    arm: SpatialArm, hand: ArrayLike, swivel: float, near: ArrayLike | None = None
) -> np.ndarray:
    """All joint angles that hold the hand at a place of the world with a swivel of the elbow.

    Parameters
    ----------
    arm : SpatialArm
    hand : (3,) array_like
    swivel : float
        Angle of the elbow about the line from shoulder to hand, see `swivel_in_space` [rad].
    near : (4,) array_like, optional
        Of angles some turns apart the nearest to these is taken; the middle of the ranges by
        default.

    Returns
    -------
    (k, 4) ndarray
        None to four solutions within the joints' ranges [rad].
    """
    limb = spatial_limb_of(arm)
    close = 0.5 * (limb.low + limb.high) if near is None else np.asarray(near, dtype=float)
    there = (np.asarray(hand, dtype=float) - arm.base.origin) @ rotation_of(arm.base.rotation)
    out = np.empty((BRANCHES, JOINTS))
    return out[: inverse(limb, *there, float(swivel), close, out)]


def swivel_in_space(arm: SpatialArm, joints: ArrayLike) -> float:
    """Return the elbow's swivel at joint angles (4,): its angle about the shoulder-hand line."""
    limb = spatial_limb_of(arm)
    return float(swivel_of(limb, *limb_at(limb, np.asarray(joints, dtype=float))))
