"""Clouds: balls of one radius about many points; the sizes are radius, count and depth of tree."""

from __future__ import annotations

import numpy as np

from gcm_learn.compiled import njit
from gcm_learn.scene.bodies import CLOUD
from gcm_learn.scene.shapes.ball import off_bone
from gcm_learn.scene.shapes.region import ShapeEntry
from gcm_learn.scene.shapes.tree import depth_of, kept, nearest, tree_of
from gcm_learn.situation import Cloud

LEAF = 8
_ROWS = 2  # of a point in the tree


@kept
def _tree(cloud: Cloud) -> np.ndarray:
    """Return the tree of a cloud."""
    count = len(cloud.points)
    radii = np.full(count, cloud.radius)
    return tree_of(np.c_[cloud.points, radii], cloud.points, radii, LEAF)


def _sizes(cloud: Cloud) -> tuple[float, float, float]:
    return cloud.radius, len(cloud.points), depth_of(len(cloud.points), LEAF)


ENTRY = ShapeEntry(CLOUD, _sizes, vertices=_tree)


@njit(_nrt=False, forceinline=True)
def _off_ball(bodies, b, row, p, q):
    v = bodies.vertices
    x, y, z = v[row, 0] - p[0], v[row, 1] - p[1], v[row + 1, 0] - p[2]
    return off_bone(x, y, z, q[0] - p[0], q[1] - p[1], q[2] - p[2]) - v[row + 1, 1]


@njit(_nrt=False)
def gap(bodies, b, x, y, z):
    """Signed distance of a point, negative inside a ball."""
    return nearest(_off_ball, _ROWS, bodies, b, (x, y, z), (x, y, z), -1e300, 1e300)[0]


@njit(_nrt=False)
def gap_of_bone(bodies, b, p, q, enough):
    """Distance of the segment p-q, 0 when they meet."""
    return max(nearest(_off_ball, _ROWS, bodies, b, p, q, 0.0, enough)[0], 0.0)


@njit(_nrt=False)
def part_near(bodies, b, p, q):
    """Row of the ball that is nearest to the segment p-q."""
    return nearest(_off_ball, _ROWS, bodies, b, p, q, -1e300, 1e300)[1]


@njit(_nrt=False)
def from_nearest(bodies, b, part, x, y, z):
    """Vector (3) from the nearest point of a ball to a point; 0 from inside."""
    v = bodies.vertices
    x, y, z = x - v[part, 0], y - v[part, 1], z - v[part + 1, 0]
    far = np.sqrt(x * x + y * y + z * z)
    out = max(far - v[part + 1, 1], 0.0) / max(far, 1e-300)
    return out * x, out * y, out * z


@njit(_nrt=False)
def long_axis(bodies, b):
    """Longest axis (3): none, as nothing is known of how balls are spread."""
    return 0.0, 0.0, 0.0
