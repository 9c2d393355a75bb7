"""Arms as faces: capsules with balls at their joints."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from gcm_learn.arms import hands_along, links_along
from gcm_learn.rendering.camera import Faces
from gcm_learn.rendering.colours import ARM, INK, JOINT, rgb
from gcm_learn.rendering.solids import frame_along, placed
from gcm_learn.situation import Capsule, Sphere

THINNEST = 0.022  # of the reach: thinner links are drawn so thick
BALL, HAND = 1.12, 1.3  # radii of joints and hand, in those of the links there
TOUCH = 1e-6  # of the reach: ends of links so close together are a joint


class Limb(NamedTuple):
    """Capsules of an arm at one or more postures, with the hand and the place of the base."""

    ends: np.ndarray
    """(k, m, 2, 3) float: both ends of every link's axis."""
    radii: np.ndarray
    """(m,) float: as drawn."""
    hand: np.ndarray
    """(k, 3) float"""
    base: np.ndarray
    """(3,) float"""


class Ball(NamedTuple):
    """A ball that marks the base, a joint or the hand."""

    name: str
    colour: str
    radius: float
    places: np.ndarray
    """(k, 3) float"""


def limb_along(arm: Any, joints: ArrayLike) -> Limb:
    """Return the limb of an arm that moves in its joints, at postures (k, n), in the world."""
    ends, radii = links_along(arm, joints)
    drawn = np.maximum(radii, THINNEST * arm.reach)
    return Limb(ends, drawn, hands_along(arm, joints)[0], np.asarray(arm.base.origin))


def arm_faces(arm: Any, joints: ArrayLike, alpha: float = 1.0) -> list[Faces]:
    """Return an arm as capsules, with balls for base, joints and hand.

    Parameters
    ----------
    arm : SpatialArm, Chain or another arm that moves in its joints
    joints : (n,) array_like
        [rad or lengths]
    alpha : float
    """
    return limb_faces(limb_along(arm, np.atleast_2d(joints)), alpha)


def limb_faces(limb: Limb, alpha: float = 1.0) -> list[Faces]:
    """Return the first posture of a limb as capsules and balls."""
    out = []
    for (a, b), radius in zip(limb.ends[0], limb.radii, strict=True):
        turn, half = bone_pose(a, b)
        out.append(placed(bone_shape(radius, half), (a + b) / 2, turn, rgb(ARM), alpha))
    for ball in balls_of(limb):
        shape = Sphere(ball.radius)
        out.append(placed(shape, ball.places[0], np.eye(3), rgb(ball.colour), alpha))
    return out


def bone_pose(a: np.ndarray, b: np.ndarray) -> tuple[np.ndarray, float]:
    """Return the turn (3, 3) of a capsule whose axis ends at two points, and half its length."""
    length = float(np.linalg.norm(b - a))
    return (frame_along((b - a) / length) if length > 0.0 else np.eye(3)), length / 2


def bone_shape(radius: float, half_length: float) -> Capsule | Sphere:
    """Return the shape of a link, a ball if its axis is a point."""
    return Capsule(radius, half_length) if half_length > 0.0 else Sphere(radius)


def balls_of(limb: Limb) -> Iterator[Ball]:
    """Yield balls where links meet, at the end nearest to the base, and at the hand."""
    first, size = limb.ends[0], TOUCH + TOUCH * float(np.abs(limb.ends).max())
    foot = divmod(int(np.linalg.norm(first - limb.base, axis=2).argmin()), 2)
    yield Ball("base", INK, BALL * limb.radii[foot[0]], limb.ends[:, foot[0], foot[1]])
    for i in range(len(first)):
        away = np.linalg.norm(first - first[i, 0], axis=2).min(axis=1)
        met = [j for j in range(len(first)) if j != i and away[j] <= size]
        if met and (i, 0) != foot:
            radius = BALL * float(limb.radii[[i, *met]].max())
            yield Ball(f"joint of link {i}", JOINT, radius, limb.ends[:, i, 0])
    last = np.linalg.norm(first - limb.hand[0], axis=2).min(axis=1).argmin()
    yield Ball("hand", ARM, HAND * limb.radii[last], limb.hand)
