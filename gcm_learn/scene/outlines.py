"""Outlines of bodies in the arm plane."""

from __future__ import annotations

import numpy as np

from gcm_learn.scene.cuts import cut_outline
from gcm_learn.scene.packing import pose
from gcm_learn.situation import PLANAR, Disc, Polygon, Situation

CIRCLE = np.linspace(0.0, 2 * np.pi, 65)[:-1]


def outline(situation: Situation, index: int, t: float) -> np.ndarray | None:
    """Return the outline of a body, or of its cut with the arm plane.

    Parameters
    ----------
    situation : Situation
    index : int
        Position of the body in ``situation.bodies``.
    t : float
        Time [s].

    Returns
    -------
    (n, 2) ndarray or None
        Corners in order, in arm-plane coordinates; None when the plane misses the body.
    """
    shape = situation.bodies[index].shape
    centre, rotation = pose(situation, index, t)
    if isinstance(shape, PLANAR):
        return centre[:2] + _planar(shape) @ rotation[:2, :2].T
    corners = cut_outline(shape, centre, rotation)
    return corners if len(corners) else None


def _planar(shape: Disc | Polygon) -> np.ndarray:
    if isinstance(shape, Disc):
        return shape.radius * np.stack([np.cos(CIRCLE), np.sin(CIRCLE)], axis=1)
    return np.asarray(shape.vertices)
