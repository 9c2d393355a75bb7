"""Clouds: balls of one radius about many points; the sizes are radius, count and depth of tree."""

from __future__ import annotations

import numpy as np

from gcm_learn.compiled import njit
from gcm_learn.scene.bodies import CLOUD, SIZE
from gcm_learn.scene.shapes.region import ShapeEntry
from gcm_learn.scene.shapes.tree import above, depth_of, kept, nearest, point_apart2, tree_of
from gcm_learn.situation import Cloud

LEAF = 16
_ROWS = 2  # of a point in the tree: three numbers and a free one


@kept
def _tree(cloud: Cloud) -> np.ndarray:
    """Return the tree of a cloud."""
    spare = np.zeros(len(cloud.points))
    return tree_of(np.c_[cloud.points, spare], cloud.points, spare, LEAF)


def _sizes(cloud: Cloud) -> tuple[float, float, float]:
    return cloud.radius, len(cloud.points), depth_of(len(cloud.points), LEAF)


ENTRY = ShapeEntry(CLOUD, _sizes, vertices=_tree)


@njit(_nrt=False)
def _nearest(bodies, b, p, q, least, near, far):
    """Distance of the nearest point to the segment p-q, and the point's row."""
    return nearest(point_apart2, _ROWS, bodies, b, p, q, least, near, far)


@njit(_nrt=False)
def gap(bodies, b, x, y, z):
    """Signed distance of a point, negative inside a ball."""
    return _nearest(bodies, b, (x, y, z), (x, y, z), 0.0, 1e300, 1e300)[0] - bodies.rows[b, SIZE]


@njit(_nrt=False)
def gap_of_bone(bodies, b, p, q, near, far):
    """Distance of the segment p-q, 0 when they meet; see `choice.gap_of_bone`."""
    radius = bodies.rows[b, SIZE]
    found, _ = _nearest(bodies, b, p, q, radius, above(near + radius), above(far + radius))
    return max(found - radius, 0.0)


@njit(_nrt=False)
def part_near(bodies, b, p, q):
    """Row of the ball that is nearest to the segment p-q."""
    return _nearest(bodies, b, p, q, 0.0, 1e300, 1e300)[1]


@njit(_nrt=False)
def from_nearest(bodies, b, part, x, y, z):
    """Vector (3) from the nearest point of a ball to a point; 0 from inside."""
    v = bodies.vertices
    x, y, z = x - v[part, 0], y - v[part, 1], z - v[part + 1, 0]
    far = np.sqrt(x * x + y * y + z * z)
    out = max(far - bodies.rows[b, SIZE], 0.0) / max(far, 1e-300)
    return out * x, out * y, out * z


@njit(_nrt=False)
def long_axis(bodies, b):
    """Longest axis (3): zero, which means unknown."""
    return 0.0, 0.0, 0.0
