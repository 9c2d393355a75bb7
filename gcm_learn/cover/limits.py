"""Bounds of a limb's turns, speeds and distances to targets, over families of movements."""

from __future__ import annotations

import numpy as np

from gcm_learn.arms.limbs import hand_bound, hand_of, jacobian, lever, place
from gcm_learn.compiled import njit
from gcm_learn.motion.joint_interception import target_room
from gcm_learn.motion.rules import CATCH_SAFETY, SAFETY
from gcm_learn.motion.verification import LARGEST_TURN, STRAY
from gcm_learn.scene.bodies import pose_at
from gcm_learn.scene.shapes.choice import gap_in_plane

__all__ = ["CATCH_SAFETY", "LARGEST_TURN", "SAFETY", "STRAY"]  # kernels below are for this folder

_ROUND = 1.0 + 1e-9  # bounds of curved ways are rounded up


@njit(_nrt=False)
def elbow_rates(low, high, rho):
    """Bound the turns of shoulder and elbow for a way of the hand of length 1.

    Parameters
    ----------
    low, high : float
        The hand's distance from the shoulder stays within these [forearm lengths].

    Returns
    -------
    shoulder, elbow : float
        [rad per forearm length]; 1e300 where the ring's rims come near and no bound exists.
    """
    if low <= 1e-3 or low <= abs(rho - 1.0) + 1e-6 or high >= rho + 1.0 - 1e-6:
        return 1e300, 1e300
    # The angle of the upper arm to the hand's direction has this cosine.  Its derivative by the
    # radius is (1 + (1 - rho^2) / r^2) / (2 rho sin).  Both factors are largest at an end.
    first = (low * low + rho * rho - 1.0) / (2.0 * rho * low)
    last = (high * high + rho * rho - 1.0) / (2.0 * rho * high)
    cosine = max(abs(first), abs(last))
    bend = 1.0 - rho * rho
    slope = max(abs(1.0 + bend / (low * low)), abs(1.0 + bend / (high * high)))
    slope /= 2.0 * rho * np.sqrt(max(1.0 - cosine * cosine, 1e-30))
    # Along the radius and around: two orthogonal directions.
    shoulder = np.sqrt(1.0 / (low * low) + slope * slope)
    first = (low * low - rho * rho - 1.0) / (2.0 * rho)
    last = (high * high - rho * rho - 1.0) / (2.0 * rho)
    cosine = max(abs(first), abs(last))
    elbow = high / (rho * np.sqrt(max(1.0 - cosine * cosine, 1e-30)))
    return shoulder * _ROUND, elbow * _ROUND


@njit
def turn_bounds(hand, far, rho):
    """Bound turns of shoulder and elbow for a unit of the hand's way, on each piece of a path.

    Parameters
    ----------
    hand : (n, 2) ndarray
    far : (n,) ndarray
        How far the hand may be off, growing.

    Returns
    -------
    (n - 1, 2) ndarray
    """
    out = np.empty((hand.shape[0] - 1, 2))
    for k in range(out.shape[0]):
        x, y = 0.5 * (hand[k, 0] + hand[k + 1, 0]), 0.5 * (hand[k, 1] + hand[k + 1, 1])
        dx, dy = hand[k + 1, 0] - hand[k, 0], hand[k + 1, 1] - hand[k, 1]
        radius, ball = np.sqrt(x * x + y * y), 0.5 * np.sqrt(dx * dx + dy * dy) + far[k + 1]
        out[k, 0], out[k, 1] = elbow_rates(radius - ball, radius + ball, rho)
    return out


@njit
def hand_speeds(limb, rates):
    """Bound the hand's speed (n,) while the joints' rates are at most `rates` (n, m)."""
    out = np.empty(rates.shape[0])
    for k in range(rates.shape[0]):
        out[k] = hand_bound(limb, rates[k])
    return out


@njit
def derivative(limb, q):
    """Return the hand's derivative (3, m) by the joints q (m,), and the longest lever."""
    out = np.zeros((3, q.size))
    place(limb, q)
    jacobian(limb, q, out)
    return out, lever(limb)


@njit
def room_at_catch(scene, q, t, body):
    """Signed distance of the hand at joints q (m,) to a target at t [s]."""
    poses = np.zeros((scene.bodies.rows.shape[0], 12))
    x, y, z = hand_of(scene.limb, place(scene.limb, q))
    return target_room(scene, body, x, y, z, t, poses)


@njit
def hand_room_at_catch(scene, x, y, t, body):
    """Signed distance of a planar arm's hand at (x, y) to a target at t [s]."""
    poses = np.zeros((scene.bodies.rows.shape[0], 12))
    pose_at(scene.bodies, body, t, poses)
    return gap_in_plane(scene.bodies, poses, body, x, y)
