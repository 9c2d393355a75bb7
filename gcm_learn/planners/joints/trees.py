"""Two trees in joints and time: their nodes and random numbers."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from gcm_learn.compiled import njit
from gcm_learn.planners.joints.moves import Study
from gcm_learn.planners.joints.ramps import Ramp, new_ramp
from gcm_learn.planners.joints.tree_moves import FROM_CATCH, FROM_START, LINES, Lines


class Trees(NamedTuple):
    """Both trees of a search, and the state of the search's random numbers."""

    moves: Lines | Ramp  # their kind, and room for one
    joints: np.ndarray  # (2, size, n)
    rates: np.ndarray  # (2, size, n): when a node is left, or reached in the second tree [rad/s]
    time: np.ndarray  # (2, size): when the limb is there [s]
    begin: np.ndarray  # (2, size): of the move that joins a node to `via` [s]
    end: np.ndarray  # (2, size) [s]
    free: np.ndarray  # (2, size): which rates of that move were free; see `ramp`
    via: np.ndarray  # (2, size): the node nearer to the root; -1 of a root
    body: np.ndarray  # (size,): caught at a root of the second tree, which all its nodes inherit
    size: np.ndarray  # (2,): nodes of each
    drawn: np.ndarray  # (n,): a posture
    drawn_rates: np.ndarray  # (n,)
    ends: np.ndarray  # (2,): when a move begins and ends [s]
    state: np.ndarray  # (1,) uint64: of the random numbers


def new_trees(study: Study, size: int, seed: int, accelerates: bool) -> Trees:
    """Return trees with the start alone."""
    n = study.goal.size
    trees = Trees(
        new_ramp(n) if accelerates else LINES,
        np.zeros((2, size, n)),
        np.zeros((2, size, n)),
        np.zeros((2, size)),
        np.zeros((2, size)),
        np.zeros((2, size)),
        np.zeros((2, size), np.int64),
        np.full((2, size), -1, np.int64),
        np.zeros(size, np.int64),
        np.zeros(2, np.int64),
        np.zeros(n),
        np.zeros(n),
        np.zeros(2),
        np.array([seed], np.uint64),
    )
    trees.joints[FROM_START, 0] = study.scene.limb.start
    trees.rates[FROM_START, 0] = study.scene.limb.rates
    trees.size[FROM_START] = 1
    return trees


def roomier(trees: Trees) -> Trees:
    """Return the same trees, able to hold twice as many nodes."""
    more: dict[str, Any] = {
        name: np.concatenate([rows, rows], axis=1)
        for name in ("joints", "rates", "time", "begin", "end", "free", "via")
        for rows in [getattr(trees, name)]
    }
    return trees._replace(body=np.concatenate([trees.body, trees.body]), **more)


@njit(_nrt=False)
def uniform(trees):
    """Draw a number in [0, 1): splitmix64 (Steele, Lea and Flood 2014)."""
    trees.state[0] += np.uint64(0x9E3779B97F4A7C15)
    z = trees.state[0]
    z = (z ^ (z >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    z = (z ^ (z >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    z = z ^ (z >> np.uint64(31))
    return float(z >> np.uint64(11)) * (1.0 / 9007199254740992.0)


@njit(_nrt=False)
def add_node(trees, tree, q, rates, time, free, via, body):
    """Add a node to a tree by the move of ``trees.ends``; return its number, -1 if full."""
    k = trees.size[tree]
    if k == trees.time.shape[1]:
        return -1
    for j in range(q.size):
        trees.joints[tree, k, j], trees.rates[tree, k, j] = q[j], rates[j]
    trees.begin[tree, k], trees.end[tree, k] = trees.ends
    trees.time[tree, k] = time
    trees.via[tree, k], trees.free[tree, k] = via, free
    if tree == FROM_CATCH:
        trees.body[k] = body
    trees.size[tree] = k + 1
    return k
