"""A kind of arm that the package does not know: a crane, whose rod slides along a boom that turns.

Its three joints turn the boom about the upright axis, slide the boom along itself, and lower the
rod.  All that the package needs is in this file: a record, a limb, its functions and their names.
"""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np

from gcm_learn.arms import (
    IDENTITY,
    Base,
    Chain,
    ChainJoint,
    ChainModel,
    Hand,
    Kind,
    Link,
)
from gcm_learn.arms.curves import on_curve, rate_of, turn_of
from gcm_learn.arms.limbs import register_limb
from gcm_learn.compiled import njit

BOOM, ROD = 0.6, 0.5  # lengths


@dataclass(frozen=True)
class Crane:
    """A crane at t = 0.

    Parameters
    ----------
    height : float
        Of the boom above the base.
    joints : (3,) tuple of float
        Turn of the boom [rad], distance of the rod from the upright axis, and how far the hand is
        below the boom.
    joint_range : (3, 2) tuple of float
    max_joint_speed : (3,) tuple of float
    grasp : float
    """

    height: float
    joints: tuple[float, float, float]
    joint_range: tuple[tuple[float, float], ...]
    max_joint_speed: tuple[float, float, float]
    grasp: float
    base: Base = IDENTITY
    max_hand_speed: float | None = None
    max_joint_acceleration: tuple[float, float, float] | None = None
    thickness: float = 0.03
    joint_rates: tuple[float, float, float] | None = None

    kind: ClassVar[str] = "crane"

    def __post_init__(self) -> None:
        """Make tuples of lists, as files give them."""
        for name in ("joints", "max_joint_speed"):
            object.__setattr__(self, name, tuple(float(x) for x in getattr(self, name)))
        pairs = tuple((float(low), float(high)) for low, high in self.joint_range)
        object.__setattr__(self, "joint_range", pairs)

    @property
    def reach(self) -> float:
        """Largest distance of the hand from the base, over all postures."""
        out, below = np.abs(np.array(self.joint_range).T).max(axis=0)[1:]
        return math.hypot(out, self.height + below)


class CraneLimb(NamedTuple):
    """A crane as kernels read it, its base at the origin."""

    height: float
    low: np.ndarray  # (3,) ends of the joints' ranges
    high: np.ndarray  # (3,)
    start: np.ndarray  # (3,) joints at t = 0
    rates: np.ndarray  # (3,) of the joints at t = 0
    thickness: float  # radius of boom and rod
    length: float  # unit of resolutions and safeties
    reach: float


def crane_limb_of(arm: Crane, bodies: tuple[str, ...] = ()) -> CraneLimb:
    """Return a crane as kernels read it."""
    low, high = np.array(arm.joint_range).T.copy()
    start, still = np.array(arm.joints), np.zeros(3)
    return CraneLimb(arm.height, low, high, start, still, arm.thickness, ROD, arm.reach)


@njit(_nrt=False)
def dof(limb):
    return 3


@njit(_nrt=False)
def place(limb, q):
    """Direction of the boom, distance of the rod from the axis, height of the hand."""
    return np.cos(q[0]), np.sin(q[0]), q[1], limb.height - q[2]


@njit(_nrt=False)
def hand_of(limb, place):
    c, s, out, z = place
    return c * out, s * out, z


@njit(_nrt=False)
def axis_of(limb, place):
    return 0.0, 0.0, -1.0


@njit(_nrt=False)
def link_count(limb):
    return 2


@njit(_nrt=False)
def link(limb, place, i):
    """The boom, then the rod, which reaches up from the hand."""
    c, s, out, z = place
    x, y, inner = c * out, s * out, out - BOOM
    if i == 0:
        return c * inner, s * inner, limb.height, x, y, limb.height, 0.0
    return x, y, z, x, y, z + ROD, 0.0


@njit(_nrt=False)
def ignores(limb, i, b):
    return False


@njit(_nrt=False)
def self_gap(limb, place, slack, enough):
    return 1e300, 1e300


@njit(_nrt=False)
def still(limb):
    return 0.0, 0.0


@njit(_nrt=False)
def swept(limb, curve, s, half, place):
    """The farther end of the boom turns about the axis; boom and rod slide, and the rod sinks."""
    turn, slide = turn_of(curve, 0, s, half), turn_of(curve, 1, s, half)
    out = place[2]
    boom = turn * (max(abs(out), abs(out - BOOM)) + slide) + slide
    return boom, turn * (abs(out) + slide) + slide + turn_of(curve, 2, s, half)


@njit(_nrt=False)
def slack_of(limb, slack, i):
    return slack[0] if i == 0 else slack[1]


@njit(_nrt=False)
def hand_rate(limb, curve, s, q):
    on_curve(curve, s, q)
    around = q[1] * rate_of(curve, 0, s)
    out, down = rate_of(curve, 1, s), rate_of(curve, 2, s)
    return np.sqrt(around * around + out * out + down * down)


@njit(_nrt=False)
def hand_travel(limb, q, p):
    return limb.reach * abs(p[0] - q[0]) + abs(p[1] - q[1]) + abs(p[2] - q[2])


@njit(_nrt=False)
def hand_bound(limb, rates):
    return limb.reach * rates[0] + rates[1] + rates[2]


@njit(_nrt=False)
def axis_bound(limb, rates):
    return 0.0


@njit(_nrt=False)
def reach_of(limb):
    return limb.reach


@njit(_nrt=False)
def lever(limb):
    return max(limb.reach, 1.0)


@njit(_nrt=False)
def jacobian(limb, q, out):
    c, s = np.cos(q[0]), np.sin(q[0])
    out[0, 0], out[1, 0], out[2, 0] = -s * q[1], c * q[1], 0.0
    out[0, 1], out[1, 1], out[2, 1] = c, s, 0.0
    out[0, 2], out[1, 2], out[2, 2] = 0.0, 0.0, -1.0


@njit(_nrt=False)
def direction_of(limb, q, x, y, z):
    c, s = np.cos(q[0]), np.sin(q[0])
    return c * x - s * y, s * x + c * y, z


@njit(_nrt=False)
def spins(limb, q, out):
    out[:] = 0.0
    out[2, 0] = 1.0


@njit(_nrt=False)
def postures_at(limb, x, y, z, k, count, low, high, out):
    """The inverse in closed form, put back into the box of interest."""
    out[0, 0], out[0, 1], out[0, 2] = np.arctan2(y, x), np.sqrt(x * x + y * y), limb.height - z
    for j in range(3):
        out[0, j] = min(max(out[0, j], low[j]), high[j])
    return 1


@njit(_nrt=False)
def inverts(limb):
    return True


register_limb(CraneLimb, sys.modules[__name__])


def chain_of(arm: Crane) -> Chain:
    """Return the chain that moves as a crane does, for the referee."""
    moves = (("revolute", (0, 0, 1)), ("prismatic", (1, 0, 0)), ("prismatic", (0, 0, -1)))
    joints = tuple(
        ChainJoint(axis, ends, fast, kind, (0, 0, 0 if k else arm.height))
        for k, ((kind, axis), ends, fast) in enumerate(
            zip(moves, arm.joint_range, arm.max_joint_speed, strict=True)
        )
    )
    boom = Link(2, (-BOOM, 0, 0), (0, 0, 0), arm.thickness)
    rod = Link(3, (0, 0, 0), (0, 0, ROD), arm.thickness)
    model = ChainModel("", joints, (boom, rod), Hand(3, (0, 0, 0), (0, 0, -1)))
    return Chain(model, arm.joints, arm.grasp, arm.base, max_hand_speed=arm.max_hand_speed)


CRANE = Kind(
    "crane", "cranes", Crane, CraneLimb, crane_limb_of, formats=("gcm-learn/situation@3",),
    as_chain=chain_of,
)  # fmt: skip
