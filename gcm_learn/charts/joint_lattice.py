"""A lattice over the joints of an arm: each node is one posture.

Neighbouring values of a joint are as far apart as it turns in one `step` of time, and the start is
a node. Postures that no movement reaches before the horizon are left out.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.compiled import njit
from gcm_learn.scene import Scene

MOST_VALUES = 64  # of one joint


class JointLattice(NamedTuple):
    """Nodes of a lattice over the joints; node k of joint values i is the dot of i and strides."""

    values: np.ndarray  # (dof, most): of every joint [rad]
    counts: np.ndarray  # (dof,): how many there are
    strides: np.ndarray  # (dof,)
    start: int  # node of the posture at t = 0
    step: float  # time of a step of one joint [s]


def joint_lattice(scene: Scene, nodes: int) -> JointLattice:
    """The lattice of about so many nodes over the postures that a movement can reach in time."""
    limb, speed = scene.limb, scene.limits.joint_speed
    way = speed * scene.limits.horizon
    low, high = np.maximum(limb.low, limb.start - way), np.minimum(limb.high, limb.start + way)
    step = _step((high - low) / speed, nodes)
    axes = [_axis(*ends) for ends in zip(limb.start, low, high, speed * step, strict=True)]
    counts = np.array([axis.size for axis, _ in axes])
    values = np.zeros((counts.size, counts.max()))
    for row, (axis, _) in zip(values, axes, strict=True):
        row[: axis.size] = axis
    strides = np.cumprod(np.concatenate([[1], counts[:-1]]))
    start = int(np.dot(strides, [k for _, k in axes]))
    return JointLattice(values, counts, strides, start, step)


def _step(spans: np.ndarray, nodes: int) -> float:
    """Time of a step [s] with which spans (dof,) [s] make so many nodes."""
    least = spans.max() / (MOST_VALUES - 3)
    wide = spans[spans > 0.0]
    while wide.size:
        step = float((wide.prod() / nodes) ** (1.0 / wide.size))
        if (wide >= step).all():
            return max(step, least)
        nodes = max(nodes // 2, 1)
        wide = wide[wide >= step]  # two values do for a joint that hardly moves
    return 1.0


def _axis(start: float, low: float, high: float, width: float) -> tuple[np.ndarray, int]:
    """Values from `low` to `high` with the start among them, and its index."""
    below = start - width * np.arange(int((start - low) / width), 0, -1)
    above = start + width * np.arange(1, int((high - start) / width) + 1)
    near = 0.3 * width  # to a value: an end of the range need not be a value of its own
    first = [low] if start > low and (below[0] if below.size else start) - low > near else []
    last = [high] if start < high and high - (above[-1] if above.size else start) > near else []
    values = np.concatenate([first, below, [start], above, last])
    return np.clip(values, low, high), len(first) + below.size


@njit(_nrt=False)
def posture_of(lattice, node, q):
    """Write the joints at a node into q (dof,)."""
    for j in range(q.size):
        q[j] = lattice.values[j, node // lattice.strides[j] % lattice.counts[j]]


@njit(_nrt=False)
def neighbour(lattice, node, j, way):
    """Node whose joint j is a step `way` (+1 or -1) from that of a node; -1 at an end."""
    k = node // lattice.strides[j] % lattice.counts[j] + way
    return node + way * lattice.strides[j] if 0 <= k < lattice.counts[j] else -1


@njit(_nrt=False)
def nearest(lattice, q, corner):
    """One of the nodes about joints q (dof,): bit j of `corner` says above or below in joint j.

    -1 where that is the node of another corner.
    """
    node = 0
    for j in range(q.size):
        last, k = lattice.counts[j] - 1, 0
        while k < last and lattice.values[j, k + 1] <= q[j]:
            k += 1
        if corner >> j & 1:
            if k == last:
                return -1
            k += 1
        node += k * lattice.strides[j]
    return node
