"""Regions of the arm's plane: a cut with z = 0 in arm-plane coordinates.

A cut is a union of discs and one convex polygon, each of which may be missing:

========  =====================================================================================
sphere    a disc
box       the polygon in which the plane meets it, exact
cylinder  an ellipse, or the strip between two lines when the axis lies in the plane, less what
          lies beyond the end faces; a disc when the axis is the plane's normal
capsule   the cylinder's cut and a disc for each of the two end balls
========  =====================================================================================

Ellipse arcs are sampled: vertices lie on the true boundary, so the polygon lies inside the cut.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from gcm_learn.compiled import njit

EMPTY_DISTANCE = 1e300
"""Distance to a region that is empty."""
MOST_DISCS = 3
ROWS = 512  # of corners and of the spare array: more than any cut needs on the way


class Cut(NamedTuple):
    """Arrays that a cut is written into.

    Kernels that make arrays take several times as long to compile as those that fill them.
    """

    discs: np.ndarray  # (MOST_DISCS, 3): x, y and radius
    corners: np.ndarray  # (ROWS, 2): a convex polygon, counter-clockwise
    spare: np.ndarray  # (ROWS, 2): intermediate results


@njit
def new_cut():
    """Return arrays for a cut."""
    return Cut(np.empty((MOST_DISCS, 3)), np.empty((ROWS, 2)), np.empty((ROWS, 2)))


@njit(_nrt=False)
def placed(corners, count, x, y):
    """Shift a polygon's first `count` corners by (x, y); drop corners equal to the one before.

    Returns the number that is left.
    """
    kept = 0
    for k in range(count):
        cx, cy = corners[k, 0] + x, corners[k, 1] + y
        if kept == 0 or cx != corners[kept - 1, 0] or cy != corners[kept - 1, 1]:
            corners[kept, 0], corners[kept, 1] = cx, cy
            kept += 1
    while (
        kept > 1 and corners[0, 0] == corners[kept - 1, 0] and corners[0, 1] == corners[kept - 1, 1]
    ):
        kept -= 1
    return kept


@njit(_nrt=False)
def polygon_distance(px: float, py: float, vertices: np.ndarray, first: int, last: int) -> float:
    """Signed distance of a point to a simple polygon, convex or not.

    Parameters
    ----------
    px, py : float
    vertices : (m, 2) ndarray
    first, last : int
        The corners are vertices[first:last], in either direction; fewer than three (or no area)
        mean a segment or a point.

    Returns
    -------
    float
        Negative inside, `EMPTY_DISTANCE` without corners.
    """
    best = np.inf
    inside = False
    before = last - 1
    for k in range(first, last):
        ax, ay = vertices[before, 0], vertices[before, 1]
        dx, dy = vertices[k, 0] - ax, vertices[k, 1] - ay
        wx, wy = px - ax, py - ay
        # compared before any rounding: both edges at a corner must agree on which side it is
        if (ay > py) != (vertices[k, 1] > py) and wx < dx * (wy / dy):
            inside = not inside
        length2 = dx * dx + dy * dy
        if length2 > 0.0:
            share = min(max((wx * dx + wy * dy) / length2, 0.0), 1.0)
            wx -= share * dx
            wy -= share * dy
        best = min(best, np.hypot(wx, wy))
        before = k
    if first == last:
        return EMPTY_DISTANCE
    return -best if inside else best


@njit(_nrt=False)
def region_distance(px, py, made, discs, corners):
    """Signed distance of a point to a cut.

    Parameters
    ----------
    px, py : float
    made : Cut
    discs, corners : int
        How many there are, as `cut` returns them.

    Returns
    -------
    float
        Exact outside; inside it is negative and its magnitude at most the distance to the
        boundary; `EMPTY_DISTANCE` when the cut is empty.
    """
    best = polygon_distance(px, py, made.corners, 0, corners)
    for k in range(discs):
        away = np.hypot(px - made.discs[k, 0], py - made.discs[k, 1])
        best = min(best, away - made.discs[k, 2])
    return best


Sizes = tuple[float, float, float]


class ShapeEntry(NamedTuple):
    """Numbers of a shape in a body's row."""

    number: int
    """Number in the column KIND."""
    sizes: Callable[[Any], Sizes]
    """Sizes in the columns SIZE to SIZE + 2, from a shape of `gcm_learn.situation`."""
    is_ball: bool = False
    """True if the shape is all of the ball that holds it, so that no turn can be seen."""
    is_round: bool = False
    """True if a turn about the z axis cannot be seen."""
    vertices: Callable[[Any], Any] = lambda _shape: ()
    """Corners in the plane or a tree (m, 2), from a shape of `gcm_learn.situation`."""
