"""Way of the target that the hand meets; films hold it in their picture from the start."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.rendering.bodies import drawn_scale
from gcm_learn.rendering.camera import Camera, Faces
from gcm_learn.rendering.poses import JointSituation

FARTHEST = 2.0  # [reaches] from the base: ways from farther away are not whole in a still picture
CUBE = np.array([(x, y, z) for x in (-1, 1) for y, z in ((-1, -1), (1, -1), (1, 1), (-1, 1))])


class TargetWay(NamedTuple):
    """Cubes about a target on its way until the hand is nearest to it."""

    times: np.ndarray
    """(k,) float: instants from 0 on [s]."""
    corners: np.ndarray
    """(k, 2, 4, 3) float: two opposite faces of a cube at each instant, in the world."""
    near: int
    """First instant from which on the target is no farther than `FARTHEST` from the base."""

    def faces(self, first: int = 0) -> Faces:
        """Return the cubes from an instant on, to be kept in a picture."""
        return Faces(self.corners[first:].reshape(-1, 4, 3), np.zeros(3), kept=True)

    def reach_seen(self, view: Camera, t: float) -> float:
        """Return how far from the middle of the picture the way from time t [s] on is."""
        first = min(int(np.searchsorted(self.times, t, side="right")) - 1, self.near)
        return float(np.abs(view.see(self.corners[first:])[..., :2]).max())


def target_way(
    situation: JointSituation, times: np.ndarray, places: np.ndarray, hands: np.ndarray
) -> TargetWay:
    """Return the way of the target to which the hand comes nearest.

    Parameters
    ----------
    situation : Situation
        With an arm that moves in its joints.
    times : (k,) ndarray
        Instants of the film [s].
    places : (m, k, 3) ndarray
        Centres of the targets, in the world.
    hands : (k, 3) ndarray
        Hand at these instants.
    """
    apart = np.linalg.norm(places - hands, axis=2)
    which, last = np.unravel_index(apart.argmin(), apart.shape)
    target = situation.targets[which]
    half = drawn_scale(situation, target) * target.shape.bounding_radius
    middles = places[which, : last + 1]
    corners = (middles[:, None] + half * CUBE).reshape(-1, 2, 4, 3)
    away = np.linalg.norm(middles - np.asarray(situation.arm.base.origin), axis=1)
    far = np.flatnonzero(away > FARTHEST * situation.arm.reach)
    near = min(int(far[-1]) + 1, len(middles) - 1) if far.size else 0
    return TargetWay(times[: last + 1], corners, near)
