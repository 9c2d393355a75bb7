"""Links and hands along postures, in the world, for any arm that moves in its joints."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from gcm_learn.arms.chain import Chain
from gcm_learn.arms.chain_limb import place_axes
from gcm_learn.arms.kinds import kind_of
from gcm_learn.arms.limbs import axis_of, hand_of, jacobian, link, link_count, place
from gcm_learn.arms.rotations import rotation_of
from gcm_learn.arms.spatial import SpatialArm
from gcm_learn.compiled import njit


@njit
def _trace(limb, joints, links, radii, hands):
    for k in range(joints.shape[0]):
        where = place(limb, joints[k])
        for i in range(link_count(limb)):
            row = link(limb, where, i)
            for j in range(6):
                links[k, i, j] = row[j]
            radii[i] = row[6]
        hands[k, 0], hands[k, 1], hands[k, 2] = hand_of(limb, where)
        hands[k, 3], hands[k, 4], hands[k, 5] = axis_of(limb, where)


@njit
def _links_of(limb):
    return link_count(limb)


@njit(_nrt=False)
def _differentiate(limb, q, out):
    place(limb, q)
    jacobian(limb, q, out)


def _traced(arm: Any, joints: ArrayLike) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    limb = kind_of(arm).pack(arm, ())
    rows = np.ascontiguousarray(joints, dtype=float).reshape(-1, len(arm.joints))
    count = _links_of(limb)
    links, radii = np.empty((len(rows), count, 6)), np.empty(count)
    hands = np.empty((len(rows), 6))
    _trace(limb, rows, links, radii, hands)
    return links, radii + limb.thickness, hands


def _in_world(arm: Any, points: np.ndarray) -> np.ndarray:
    return points @ rotation_of(arm.base.rotation).T + np.array(arm.base.origin)


def links_along(arm: Any, joints: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Return the capsules of an arm at postures, in the world.

    Parameters
    ----------
    arm : SpatialArm, Chain or another arm that moves in its joints
    joints : (k, n) array_like
        Postures, in their ranges or not.

    Returns
    -------
    ends : (k, m, 2, 3) ndarray
        Both ends of every link's axis.
    radii : (m,) ndarray
    """
    links, radii, _ = _traced(arm, joints)
    return _in_world(arm, links.reshape(*links.shape[:2], 2, 3)), radii


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
    given = np.asarray(joints, dtype=float)
    ends, _ = links_along(arm, given)
    rows = ends[:, :, 1].reshape(*given.shape[:-1], 2, 3)
    return rows[..., 0, :], rows[..., 1, :]


def off_segment(points: np.ndarray, start: ArrayLike, end: ArrayLike) -> np.ndarray:
    """Return distances (k,) of points (k, 3) from the segment between two others (3,)."""
    axis, off = np.subtract(end, start), points - np.asarray(start)
    share = np.clip(off @ axis / max(float(axis @ axis), 1e-300), 0.0, 1.0)
    off = off - share[:, None] * axis
    return np.sqrt((off * off).sum(axis=1))


def hands_along(arm: Any, joints: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Return the hand's positions and directions of reach at postures (k, n) of an arm.

    Returns
    -------
    hand, axis : (k, 3) ndarray
        In the world; the axis has length 1.
    """
    _, _, hands = _traced(arm, joints)
    return _in_world(arm, hands[:, :3]), hands[:, 3:] @ rotation_of(arm.base.rotation).T


def hand_frame(arm: Chain, joints: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return rotation (3, 3) and origin (3,) of the frame of the hand's joint, in the base.

    The posture has one number for each coordinate (n,).
    """
    limb = kind_of(arm).pack(arm, ())
    place(limb, joints)
    place_axes(limb, joints)
    frame = limb.frames[limb.carriers[-1]]
    return frame[:9].reshape(3, 3), frame[9:]


def hand_speed(arm: Any, joints: ArrayLike, rates: ArrayLike) -> float:
    """Return the speed of the hand of an arm at joints (n,) that move with rates (n,)."""
    q = np.array(joints, dtype=float)
    columns = np.zeros((3, q.size))
    _differentiate(kind_of(arm).pack(arm, ()), q, columns)
    return float(np.linalg.norm(columns @ np.array(rates, dtype=float)))
