"""Records of the wave of Eq. 10 in space: the cells in a buffer, blocks, batches."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.charts.posture_lattice import Nodes
from gcm_learn.compiled import njit
from gcm_learn.wave.params import Run
from gcm_learn.wave.posture_stencil import FIELD, LEFT, SLAB, WIDTH

UNASKED, GAPS, WHOLE = 0, 1, 2  # of a block: whether all of its cells have postures
UNKNOWN = np.float32(-1e30)  # room
MOST = 65_536  # cells that are checked together; the rest has its turn next
ADAPTED, SHARE, DEGREE, ARRIVED = FIELD, 3 * FIELD, 4 * FIELD, 5 * FIELD
DOORS = np.array([-SLAB, -WIDTH, -1, 1, WIDTH, SLAB])


class Found(NamedTuple):
    """Findings about the cells of a lattice, which waves keep for later waves."""

    nodes: Nodes
    elbows: np.ndarray  # (n^3, 3) float32
    rates: np.ndarray  # (n^3,) float32: speed of the hand, as a share of the front's
    asked: np.ndarray  # (n + 2, n + 2, blocks + 2) uint8: UNASKED, GAPS or WHOLE
    rated: np.ndarray  # the same shape, bool: blocks whose rates are known


class SpaceGround(NamedTuple):
    """A lattice in space, what is known of its cells, and how the wave is run on it."""

    B: np.ndarray  # the buffer of `wave.posture_stencil`
    n: int
    joint_speed: np.ndarray  # (dof,) [rad/s]
    speed: float  # of the fastest front [lengths/s]
    found: Found
    known: np.ndarray  # (n + 2, n + 2, blocks + 2) uint8: ASLEEP, SEEN or AWAKE
    wake: np.ndarray  # the same shape, bool: blocks that are about to be stepped; False in between
    slowest: float  # least rate of a cell
    fewest: int  # excited cells that start a wave
    run: Run


class Runs(NamedTuple):
    """The blocks that are stepped, and those in which a cell may soon be reached."""

    start: np.ndarray  # (blocks,) uint64: first entries
    watch: np.ndarray  # (blocks,) uint64
    slabs: np.ndarray  # (n + 1,): where those begin in `start` whose cells have the same z
    size: np.ndarray  # (2,): how many of each


class SpaceBatch(NamedTuple):
    """Cells that are reached together, in the front's unit of time."""

    cells: np.ndarray  # (MOST,)
    since: np.ndarray  # (MOST,): when the front was next door
    when: np.ndarray  # (MOST,): when it comes


class Judged(NamedTuple):
    """Verdicts on cells."""

    state: np.ndarray  # (n^3,) uint8: FREE, FROZEN or CONTACT
    via: np.ndarray  # (n^3,) int32: cell that the front came from, -1 if from the hand
    room: np.ndarray  # (n^3,) float32: distance that obstacles have at least when it comes
    widening: np.ndarray  # (n^3,) margin beyond that of the parameters, or (0,)
    margin: float  # widening of obstacles, in strides of the limb


@njit(_nrt=False, forceinline=True)
def entry_of(m, n):
    """Place of cell m in a field of the buffer."""
    return (m // (n * n) + 1) * SLAB + (m // n % n + 1) * WIDTH + m % n + LEFT


@njit(_nrt=False, forceinline=True)
def cell_of(k, n):
    """Cell at place k of a field."""
    return ((k // SLAB - 1) * n + k % SLAB // WIDTH - 1) * n + k % WIDTH - LEFT


@njit(_nrt=False, forceinline=True)
def insulate(B, k):
    """Cut a cell out of the lattice: it neither changes nor is seen by its neighbours."""
    B[k] = B[k + ADAPTED] = B[k + SHARE] = np.float32(0.0)
    for e in DOORS:
        B[k + e + DEGREE] -= np.float32(1.0)


@njit(_nrt=False, forceinline=True)
def four_joints(joints, m):
    """Joints of cell m as four numbers."""
    return joints[m, 0], joints[m, 1], joints[m, 2], joints[m, 3]


@njit(_nrt=False)
def is_step(joints, leap, m, p):
    """Return whether the rule is continuous between cells m and p, which have postures.

    The function takes arrays because handing the whole ground on costs as much again.
    """
    far = 0.0
    for j in range(joints.shape[1]):
        far = max(far, abs(joints[m, j] - joints[p, j]))
    return far <= leap
