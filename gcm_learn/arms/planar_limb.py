"""Two-joint kinematics: shoulder at the origin, upper arm rho, forearm 1, one fixed elbow side."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from gcm_learn.arms.planar import Arm
from gcm_learn.compiled import njit


class PlanarLimb(NamedTuple):
    """A planar arm of two bones with its shoulder at the origin, and its hand at t = 0.

    Lengths in forearms.
    """

    rho: float  # length of the upper arm
    side: float  # of the elbow: a value of `SIDE`
    near: float  # radii of the ring that the hand can reach
    far: float
    thickness: float  # radius of both bones
    x: float  # hand at t = 0
    y: float


SIDE = {"right": 1.0, "left": -1.0}  # sign of the elbow's offset, seen from shoulder to hand


@njit
def elbow_of(x, y, rho, side):
    """Elbow of the hand (x, y): erratum 7's closed form, clipped at the rims of the ring."""
    r = np.sqrt(x * x + y * y)
    if r < 1e-12:  # the direction is undefined at the shoulder: take +x
        return 0.0, -side * rho
    ux, uy = x / r, y / r
    a = min(max((r * r + rho * rho - 1.0) / (2.0 * rho * r), -1.0), 1.0)
    b = side * np.sqrt(1.0 - a * a)
    return rho * (a * ux + b * uy), rho * (a * uy - b * ux)


@njit
def elbows_of(hands, rho, side):
    """Elbows (n, 2) of hands (n, 2)."""
    out = np.empty(hands.shape)
    for k in range(hands.shape[0]):
        out[k, 0], out[k, 1] = elbow_of(hands[k, 0], hands[k, 1], rho, side)
    return out


@njit
def joints_of(hands, rho, side):
    """Joint angles (n, 2) along a path of hands (n, 2); the shoulder angle is unwrapped."""
    out = np.empty(hands.shape)
    for k in range(hands.shape[0]):
        x, y = hands[k, 0], hands[k, 1]
        ex, ey = elbow_of(x, y, rho, side)
        shoulder = np.arctan2(ey, ex)
        # Angle of the forearm relative to the upper arm, from cross and dot products.
        fx, fy = x - ex, y - ey
        out[k, 1] = np.arctan2(ex * fy - ey * fx, ex * fx + ey * fy)
        if k > 0:
            turn = shoulder - out[k - 1, 0]
            shoulder -= 2.0 * np.pi * np.round(turn / (2.0 * np.pi))
        out[k, 0] = shoulder
    return out


def planar_limb_of(arm: Arm) -> PlanarLimb:
    """Return the numbers of a planar arm that the kernels read."""
    return PlanarLimb(
        arm.upper_arm, SIDE[arm.elbow], arm.inner_reach, arm.reach, arm.thickness, *arm.hand
    )


def elbow_position(hand: ArrayLike, upper_arm: float = 1.0, elbow: str = "right") -> np.ndarray:
    """Elbow position(s) for hand position(s): the inverse of Eq. 8 (erratum 7).

    Parameters
    ----------
    hand : (..., 2) array_like
        Hand positions [forearm lengths]; radii outside the ring are clipped to it.
    upper_arm : float
        Length of the upper arm, rho.
    elbow : {"right", "left"}
        Side of the elbow, looking from shoulder to hand.

    Returns
    -------
    (..., 2) ndarray
    """
    hand = np.asarray(hand, dtype=float)
    return elbows_of(hand.reshape(-1, 2), upper_arm, SIDE[elbow]).reshape(hand.shape)


def joint_angles(hand: ArrayLike, upper_arm: float = 1.0, elbow: str = "right") -> np.ndarray:
    """Joint angles along a hand path.

    Parameters
    ----------
    hand : (n, 2) array_like
        Hand positions in order; neighbouring ones should be close, so that unwrapping is right.

    Returns
    -------
    (n, 2) ndarray
        Direction of the upper arm (unwrapped) and angle of the forearm relative to it [rad].
    """
    hand = np.atleast_2d(np.asarray(hand, dtype=float))
    return joints_of(hand, upper_arm, SIDE[elbow])


def forward(joints: ArrayLike, upper_arm: float = 1.0) -> np.ndarray:
    """Hand position(s) of joint angles: the inverse of `joint_angles`.

    Parameters
    ----------
    joints : (..., 2) array_like
        Direction of the upper arm, angle of the forearm relative to it [rad].

    Returns
    -------
    (..., 2) ndarray
    """
    joints = np.asarray(joints, dtype=float)
    first, second = joints[..., 0], joints[..., 0] + joints[..., 1]
    return np.stack(
        [upper_arm * np.cos(first) + np.cos(second), upper_arm * np.sin(first) + np.sin(second)],
        axis=-1,
    )
