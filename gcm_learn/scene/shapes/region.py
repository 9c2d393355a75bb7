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

import numpy as np

from gcm_learn.compiled import njit

EMPTY_DISTANCE = 1e300
"""Distance to a region that is empty."""


@njit
def placed(polygon: np.ndarray, centre: np.ndarray) -> np.ndarray:
    """Shift a polygon by the centre and drop vertices that repeat the one before them."""
    kept = np.empty_like(polygon)
    count = 0
    for k in range(polygon.shape[0]):
        x, y = polygon[k, 0] + centre[0], polygon[k, 1] + centre[1]
        if count == 0 or x != kept[count - 1, 0] or y != kept[count - 1, 1]:
            kept[count] = x, y
            count += 1
    while count > 1 and kept[0, 0] == kept[count - 1, 0] and kept[0, 1] == kept[count - 1, 1]:
        count -= 1
    return kept[:count]


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


@njit
def region_distance(px: float, py: float, discs: np.ndarray, polygon: np.ndarray) -> float:
    """Signed distance of a point to a cut.

    Parameters
    ----------
    px, py : float
    discs : (k, 3) ndarray
    polygon : (m, 2) ndarray
        As `cut` returns them.

    Returns
    -------
    float
        Exact outside; inside it is negative and its magnitude at most the distance to the
        boundary; `EMPTY_DISTANCE` when the cut is empty.
    """
    best = polygon_distance(px, py, polygon, 0, polygon.shape[0])
    for k in range(discs.shape[0]):
        best = min(best, np.hypot(px - discs[k, 0], py - discs[k, 1]) - discs[k, 2])
    return best
