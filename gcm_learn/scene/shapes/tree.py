"""Trees of bounding balls, in which the part that is nearest to a segment is found.

A tree is complete: node k has the children 2 k + 1 and 2 k + 2. Leaf j of n holds the parts from
j count // n to (j + 1) count // n. It lies in `Bodies.vertices`, two numbers in a row: the box
about all parts (low and high end), the nodes (centre and radius), the parts. A body's row says
where the tree begins (FIRST), how many parts it has and how deep it is (second and third size).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar
from weakref import WeakKeyDictionary

import numpy as np

from gcm_learn.compiled import njit
from gcm_learn.scene.bodies import FIRST, SIZE
from gcm_learn.situation import Surface

_HEAD = 3  # rows of the box
_ROUNDED_UP = 1.0 + 1e-12  # no part may stick out of a ball


Rooted = TypeVar("Rooted", bound=Surface)


def kept(build: Callable[[Rooted], np.ndarray]) -> Callable[[Rooted], np.ndarray]:
    """Wrap `build` so that a shape's tree is built once and kept as long as the shape exists."""
    trees: WeakKeyDictionary[Rooted, np.ndarray] = WeakKeyDictionary()

    def tree(shape: Rooted) -> np.ndarray:
        if shape not in trees:
            trees[shape] = build(shape)
        return trees[shape]

    return tree


def depth_of(count: int, leaf: int) -> int:
    """Return the depth of a tree of `count` parts with at most `leaf` parts in each leaf."""
    return max(0, int(np.ceil(np.log2(count / leaf))))


def tree_of(parts: np.ndarray, centres: np.ndarray, radii: np.ndarray, leaf: int) -> np.ndarray:
    """Build a tree; nodes are divided along the longest edge of their box, into equal halves.

    Parameters
    ----------
    parts : (n, 2 m) ndarray
        Numbers of the parts.
    centres, radii : (n, 3) and (n,) ndarray
        Balls that hold the parts.
    leaf : int
        Largest number of parts in a leaf.

    Returns
    -------
    (rows, 2) ndarray
    """
    centres = np.array(centres)  # one that may be written to, so that the kernel has one type
    order, nodes = np.arange(len(parts)), np.empty((2 ** (depth_of(len(parts), leaf) + 1) - 1, 4))
    _divide(centres, radii, order, nodes)
    box = (centres - radii[:, None]).min(axis=0), (centres + radii[:, None]).max(axis=0)
    return np.concatenate([*box, nodes.ravel(), parts[order].ravel()]).reshape(-1, 2)


@njit(_nrt=False)
def _divide(centres, radii, order, nodes):
    """Put the parts into `order` (n,), and write the balls of all nodes, level by level."""
    count, node, wide = order.size, 0, 1
    while node < nodes.shape[0]:
        for k in range(wide):
            low, high = k * count // wide, (k + 1) * count // wide
            axis, longest = 0, -1.0
            for a in range(3):
                least, most = 1e300, -1e300
                for i in range(low, high):
                    place, radius = centres[order[i], a], radii[order[i]]
                    least, most = min(least, place - radius), max(most, place + radius)
                nodes[node, a] = 0.5 * (least + most)
                if most - least > longest:
                    axis, longest = a, most - least
            reach = 0.0
            for i in range(low, high):
                away = 0.0
                for a in range(3):
                    away += (centres[order[i], a] - nodes[node, a]) ** 2
                reach = max(reach, np.sqrt(away) + radii[order[i]])
            nodes[node, 3] = reach * _ROUNDED_UP
            if 2 * node + 2 < nodes.shape[0]:
                _part(centres, axis, order, low, high, (2 * k + 1) * count // (2 * wide))
            node += 1
        wide *= 2


@njit(_nrt=False)
def _part(centres, axis, order, low, high, middle):
    """Reorder order[low:high]: parts with lower centres along `axis` before `middle` (Hoare)."""
    while high - low > 1:
        pivot = centres[order[(low + high) // 2], axis]
        i, j = low, high - 1
        while i <= j:
            while centres[order[i], axis] < pivot:
                i += 1
            while centres[order[j], axis] > pivot:
                j -= 1
            if i <= j:
                order[i], order[j] = order[j], order[i]
                i, j = i + 1, j - 1
        if middle <= j:
            high = j + 1
        elif middle >= i:
            low = i
        else:
            return


@njit(_nrt=False, forceinline=True)
def above(distance):
    """Return the next larger distance, or a little more."""
    return distance + 1e-12 * abs(distance)


@njit(_nrt=False, forceinline=True)
def point_apart2(v, row, p, d, inverse, far):
    """Squared distance of the point in a row to the segment from p to p + d.

    Parameters
    ----------
    inverse : float
        Of the squared length of d; 0 for a point.
    far : float
        Distances above it need not be exact.
    """
    x, y, z = v[row, 0] - p[0], v[row, 1] - p[1], v[row + 1, 0] - p[2]
    s = min(max((x * d[0] + y * d[1] + z * d[2]) * inverse, 0.0), 1.0)
    x, y, z = x - s * d[0], y - s * d[1], z - s * d[2]
    return x * x + y * y + z * z


@njit(_nrt=False, forceinline=True)
def _off_box2(v, row, p, d):
    """Squared distance of the middle of the segment from p to p + d to the box about all parts."""
    x, y, z = p[0] + 0.5 * d[0], p[1] + 0.5 * d[1], p[2] + 0.5 * d[2]
    x = max(v[row, 0] - x, x - v[row + 1, 1], 0.0)
    y = max(v[row, 1] - y, y - v[row + 2, 0], 0.0)
    z = max(v[row + 1, 0] - z, z - v[row + 2, 1], 0.0)
    return x * x + y * y + z * z


@njit(_nrt=False, forceinline=True)
def nearest(apart2, rows_of_part, bodies, b, p, q, least, near, far):
    """Find the part of body b that is nearest to the segment p-q.

    Parameters
    ----------
    apart2 : callable
        Squared distance of a part, as `point_apart2`.
    rows_of_part : int
    least, near, far : float
        The search stops at a distance of `least`, is exact up to `near`, and passes over parts
        from `far` on. Between `near` and `far` any part is as good as the nearest.

    Returns
    -------
    distance : float
        1e300 if it is not below `far`.
    row : int
        Row in `Bodies.vertices` in which the part begins.
    """
    v, first = bodies.vertices, int(bodies.rows[b, FIRST])
    count, depth = int(bodies.rows[b, SIZE + 1]), int(bodies.rows[b, SIZE + 2])
    leaves, d = 1 << depth, (q[0] - p[0], q[1] - p[1], q[2] - p[2])
    parts = first + _HEAD + 2 * (2 * leaves - 1)
    length2 = d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
    inverse = 1.0 / length2 if length2 > 0.0 else 0.0
    best, found, place = far, 1e300, parts
    if _off_box2(v, first, p, d) > (far + 0.5 * np.sqrt(length2)) ** 2 or far < 0.0:
        return found, place
    first += _HEAD
    node, level, waiting = 0, 0, 0
    apart = point_apart2(v, first, p, d, inverse, 0.0)
    while True:
        reach = best + v[first + 2 * node + 1, 1]
        if reach > 0.0 and apart < reach * reach:
            if level < depth:  # on with the nearer child
                node = 2 * node + 1
                level += 1
                waiting |= 1 << level
                row = first + 2 * node
                apart = point_apart2(v, row, p, d, inverse, 0.0)
                other = point_apart2(v, row + 2, p, d, inverse, 0.0)
                if other < apart:
                    node, apart = node + 1, other
                continue
            leaf = node - leaves + 1
            for k in range(leaf * count // leaves, (leaf + 1) * count // leaves):
                row = parts + rows_of_part * k
                away = apart2(v, row, p, d, inverse, best)
                if away < best * best:
                    found, place = np.sqrt(away), row
                    best = min(found, near)
            if found <= least:
                return found, place
        while level > 0 and not waiting >> level & 1:
            node = (node - 1) >> 1
            level -= 1
        if level == 0:
            return found, place
        waiting ^= 1 << level
        node += 1 if node & 1 else -1
        apart = point_apart2(v, first + 2 * node, p, d, inverse, 0.0)
