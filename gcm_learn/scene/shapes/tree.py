"""Trees of bounding balls, in which the part that is nearest to a segment is found.

A tree is complete: node k has the children 2 k + 1 and 2 k + 2, and leaf j of n holds the parts
from j count // n to (j + 1) count // n. It lies in `Bodies.vertices`, two numbers in a row. A node
takes two rows (centre and radius); the parts follow after the nodes. A body's row says where the
tree begins (FIRST), how many parts it has and how deep it is (second and third of its sizes).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar
from weakref import WeakKeyDictionary

import numpy as np

from gcm_learn.compiled import njit
from gcm_learn.scene.bodies import FIRST, SIZE
from gcm_learn.scene.shapes.ball import off_bone
from gcm_learn.situation import Surface

NONE = 1e300
"""Distance of parts that are farther than what was asked for."""
_ROUNDED_UP = 1.0 + 1e-12  # no part may stick out of a ball


Rooted = TypeVar("Rooted", bound=Surface)


def kept(build: Callable[[Rooted], np.ndarray]) -> Callable[[Rooted], np.ndarray]:
    """Return a function that builds the tree of a shape once, for as long as the shape is there."""
    trees: WeakKeyDictionary[Rooted, np.ndarray] = WeakKeyDictionary()

    def tree(shape: Rooted) -> np.ndarray:
        if shape not in trees:
            trees[shape] = build(shape)
        return trees[shape]

    return tree


def depth_of(count: int, leaf: int) -> int:
    """Return the depth of a tree whose leaves hold at most `leaf` of so many parts."""
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
    count, nodes, order = len(parts), [], np.arange(len(parts))
    depth = depth_of(count, leaf)
    for level in range(depth + 1):
        edges = count * np.arange(2**level + 1) // 2**level
        starts, which = edges[:-1], np.repeat(np.arange(2**level), np.diff(edges))
        c, r = centres[order], radii[order]
        low = np.minimum.reduceat(c - r[:, None], starts)
        high = np.maximum.reduceat(c + r[:, None], starts)
        middle = 0.5 * (low + high)
        far = np.linalg.norm(c - middle[which], axis=1) + r
        nodes.append(np.c_[middle, np.maximum.reduceat(far, starts) * _ROUNDED_UP])
        if level < depth:
            along = c[np.arange(count), np.argmax(high - low, axis=1)[which]]
            order = order[np.lexsort((along, which))]
    return np.concatenate([np.concatenate(nodes).reshape(-1, 2), parts[order].reshape(-1, 2)])


@njit(_nrt=False, forceinline=True)
def _to_node(v, row, p, d):
    """Lower bound of the distance of the segment from p to p + d to the parts of a node."""
    x, y, z = v[row, 0] - p[0], v[row, 1] - p[1], v[row + 1, 0] - p[2]
    return off_bone(x, y, z, d[0], d[1], d[2]) - v[row + 1, 1]


@njit(_nrt=False, forceinline=True)
def nearest(off_part, rows_of_part, bodies, b, p, q, floor, enough):
    """Find the part of body b that is nearest to the segment p-q.

    Parameters
    ----------
    off_part : callable
        Maps (bodies, b, row, p, q) to the distance of the part that begins in a row.
    rows_of_part : int
    floor : float
        Distance at which the search stops: nothing nearer is asked for.
    enough : float
        Distance beyond which no part is asked for.

    Returns
    -------
    distance : float
        NONE if it is beyond `enough`.
    row : int
        Row in `Bodies.vertices` in which the part begins.
    """
    v, first = bodies.vertices, int(bodies.rows[b, FIRST])
    count, depth = int(bodies.rows[b, SIZE + 1]), int(bodies.rows[b, SIZE + 2])
    leaves, d = 1 << depth, (q[0] - p[0], q[1] - p[1], q[2] - p[2])
    parts = first + 2 * (2 * leaves - 1)
    best, found, place = enough, NONE, parts
    node, level, waiting = 0, 0, 0
    if _to_node(v, first, p, d) > best:
        return found, place
    while True:
        if level < depth:
            node = 2 * node + 1
            near, far = _to_node(v, first + 2 * node, p, d), _to_node(v, first + 2 * node + 2, p, d)
            level += 1
            if far < near:
                node, near, far = node + 1, far, near
            if far <= best:
                waiting |= 1 << level
            if near <= best:
                continue
        else:
            leaf = node - leaves + 1
            for k in range(leaf * count // leaves, (leaf + 1) * count // leaves):
                row = parts + rows_of_part * k
                away = off_part(bodies, b, row, p, q)
                if away <= best:
                    best, found, place = away, away, row
            if found <= floor:
                return found, place
        while True:  # back to the nearest sibling that waits
            if level == 0:
                return found, place
            if waiting >> level & 1:
                waiting ^= 1 << level
                node += 1 if node & 1 else -1
                if _to_node(v, first + 2 * node, p, d) <= best:
                    break
            else:
                node = (node - 1) >> 1
                level -= 1
