"""Ranges, speeds and accelerations of joints, and the speed of the hand, at every instant."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gcm_learn.referee.chain import Geometry
from gcm_learn.referee.curves import Curve
from gcm_learn.referee.rotations import Array
from gcm_learn.referee.tolerances import (
    JERK,
    MOMENT,
    ROUNDING,
    SHORTEST,
    WORK,
    Complaint,
    Tolerances,
)


@dataclass(frozen=True)
class Limits:
    """Limits of an arm with m joints, of which n are coordinates."""

    low: Array
    high: Array
    speed: Array
    acceleration: Array | None
    hand_speed: float | None
    jerk: Array | None
    own: list[int]
    """Joints (n,) that are coordinates."""


def joint_complaints(limits: Limits, curve: Curve, granted: Tolerances) -> list[Complaint]:
    """Return complaints about ranges, speeds and accelerations, at extremes of the curves."""
    complaints = _ranges(limits, curve, granted)
    span = np.where(curve.spans > 0.0, curve.spans, 1.0)[:, None]
    values = curve.powers[:, :, 0]
    size = 1.0 + np.abs(values).max(axis=0) + np.abs(np.diff(values, axis=0)).sum(axis=0)
    share = granted.limit + ROUNDING * curve.knots[1:, None] / span
    most = limits.speed * (1.0 + share) + ROUNDING * size / span
    complaints += _beyond("moves too fast", curve, curve.most(1), most, limits.speed)
    if limits.acceleration is not None:
        most = limits.acceleration * (1.0 + 2.0 * share) + 8.0 * ROUNDING * size / span**2
        most -= limits.acceleration * granted.limit
        if limits.jerk is not None:
            most = limits.acceleration * (1.0 + granted.limit) + _grain(curve) / span**2
        hard = curve.most(2)
        complaints += _beyond("accelerates too much", curve, hard, most, limits.acceleration)
        complaints += _leaps(limits.acceleration, curve, granted)
    return complaints


def jerk_complaints(limits: Limits, curve: Curve, followed: Curve, first: Array) -> list[Complaint]:
    """Return complaints about jerk and jumps of accelerations, which begin as first (n,)."""
    if limits.jerk is None or limits.acceleration is None or not curve.spans.any():
        return []
    span, complaints = curve.spans[:, None], []
    if not span.min() >= SHORTEST * (1.0 - MOMENT):
        at = float(curve.knots[span.argmin()])
        complaints.append(Complaint("trajectory.time", f"a piece lasts {span.min():g} s", at))
    most = limits.jerk * (1.0 + JERK) + _grain(followed) / span**3
    complaints += _beyond("jerks too much", followed, followed.most(3), most, limits.jerk)
    piece = np.arange(len(span))
    before = np.concatenate([first[None], curve.accelerations(piece, curve.spans)[:-1]])
    shorter = np.minimum(span, np.concatenate([span[:1], span[:-1]]))
    most = JERK * limits.acceleration[limits.own] + _grain(curve) / shorter**2
    jumps = np.abs(curve.accelerations(piece, np.zeros(len(piece))) - before)
    return complaints + _beyond("jumps in its acceleration", curve, jumps, most, most.max(axis=0))


def _grain(curve: Curve) -> float:
    """Return the rounding error of differences between joint values."""
    return ROUNDING * max(1.0, float(np.abs(curve.powers[:, :, 0]).max()))


def _leaps(limit: Array, curve: Curve, granted: Tolerances) -> list[Complaint]:
    """Return complaints about rates that change too much over a piece, even a very short piece."""
    piece = np.arange(len(curve.powers))
    first, last = curve.rates(piece, np.zeros(len(piece))), curve.rates(piece, curve.spans)
    rates = np.concatenate([first, last[-1:]])
    steps = np.abs(np.diff(rates, axis=0))
    allowed = limit * ((1.0 + granted.limit) * curve.spans[:, None])
    allowed += 10.0 * ROUNDING * (np.abs(rates).max() + limit * curve.knots[-1])
    return [
        Complaint("trajectory.rates", f"joint {j} changes its rate at once", _when(curve, over))
        for j, over in enumerate((steps - allowed).T)
        if not (over <= 0.0).all()
    ]


def _ranges(limits: Limits, curve: Curve, granted: Tolerances) -> list[Complaint]:
    least, most = curve.extremes(0)
    ends = np.stack([limits.low, limits.high])
    slack = np.maximum(granted.range_absolute, granted.range_relative * np.abs(ends))
    beyond = np.maximum(limits.low - slack[0] - least, most - limits.high - slack[1])
    return [
        Complaint("trajectory.joints", f"joint {j} leaves its range", _when(curve, beyond[:, j]))
        for j in np.flatnonzero(~(beyond <= 0.0).all(axis=0))
    ]


def _beyond(words: str, curve: Curve, values: Array, most: Array, limit: Array) -> list[Complaint]:
    """Return a complaint for each joint with a value (n, joints) above the most allowed."""
    complaints = []
    for j in np.flatnonzero(~(values <= most).all(axis=0)):
        over = values[:, j] - most[:, j]
        what = f"joint {j} {words}: {values[over.argmax(), j]:.9g}, limit {limit[j]:g}"
        complaints.append(Complaint("trajectory.joints", what, _when(curve, over)))
    return complaints


def _when(curve: Curve, over: Array) -> float:
    """Return the begin of the piece in which something is most exceeded."""
    return float(curve.knots[over.argmax()])


# --- the hand --------------------------------------------------------------------------------


def hand_complaints(
    limit: float | None, geometry: Geometry, curve: Curve, hand: tuple[int, Array], granted: float
) -> list[Complaint]:
    """Return a complaint if the hand, a point of a joint's frame, is too fast."""
    if limit is None:
        return []
    reach = geometry.lengths[geometry.path(hand[0])].sum() + np.linalg.norm(hand[1])
    rounding = 2.0 * ROUNDING * (1.0 + np.abs(curve.powers[:, :, 0]).max()) * reach
    span = np.where(curve.spans > 0.0, curve.spans, 1.0)
    most = (limit * (1.0 + granted) + rounding / span) ** 2
    found, at, settled = _fastest(geometry, curve, hand, most)
    if not settled:
        return [Complaint("trajectory", "the hand's speed cannot be decided")]
    if found is None:
        return []
    what = f"the hand is too fast: {np.sqrt(found):.9g}, limit {limit:g}"
    return [Complaint("trajectory", what, at)]


def _fastest(
    geometry: Geometry, curve: Curve, hand: tuple[int, Array], most: Array
) -> tuple[float | None, float, bool]:
    """Return a squared speed above `most` (n,) of its piece, its time, and if all is decided.

    A chord plus its bow bounds the square: half the square's second derivative is bounded.
    """
    (first, second, third), _ = point_bounds(geometry, curve, hand)
    bow = second**2 + first * third
    piece = np.flatnonzero(~(first**2 <= most))
    low, high = np.zeros(len(piece)), curve.spans[piece]
    spent = 0
    while len(piece):
        spent += len(piece)
        ends = [_square(geometry, curve, hand, piece, s) for s in (low, high)]
        top = np.maximum(*ends)
        over = top - most[piece]
        if (over > 0.0).any():
            k = int(over.argmax())
            since = low[k] if ends[0][k] > ends[1][k] else high[k]
            return float(top[k]), float(curve.knots[piece[k]] + since), True
        if spent > WORK:
            return None, 0.0, False
        kept = ~(top + (high - low) ** 2 * bow[piece] / 4.0 <= most[piece])
        piece, low, high = piece[kept], low[kept], high[kept]
        middle = 0.5 * (low + high)
        piece = np.tile(piece, 2)
        low, high = np.concatenate([low, middle]), np.concatenate([middle, high])
    return None, 0.0, True


def _square(
    geometry: Geometry, curve: Curve, hand: tuple[int, Array], piece: Array, since: Array
) -> Array:
    joints, rates = curve.within(piece, since), curve.rates(piece, since)
    return (geometry.velocity(joints, rates, *hand) ** 2).sum(axis=1)


def point_bounds(
    geometry: Geometry, curve: Curve, hand: tuple[int, Array]
) -> tuple[tuple[Array, Array, Array], tuple[Array, Array, Array]]:
    """Bound (n,) the first three derivatives of a point, and of the angles that turn its frame.

    Rotations turn a vector one after the other.  Its k-th derivative is at most its length times
    the k-th complete Bell polynomial of the sums of the angles' derivatives.
    """
    x, y, z = (geometry.followed(curve).most(order) for order in (1, 2, 3))
    turned = [np.zeros(len(x)) for _ in range(3)]
    n1, n2, n3 = (np.zeros(len(x)) for _ in range(3))
    for j in geometry.path(hand[0]):
        joint, (b1, b2, b3) = geometry.joints[j], _bell(*turned)
        size = float(np.linalg.norm(joint.origin))
        if joint.slides:
            far = size + max(map(abs, joint.ends))
            n1 += far * b1 + x[:, j]
            n2 += far * b2 + 2.0 * x[:, j] * b1 + y[:, j]
            n3 += far * b3 + 3.0 * (x[:, j] * b2 + y[:, j] * b1) + z[:, j]
        else:
            n1, n2, n3 = n1 + size * b1, n2 + size * b2, n3 + size * b3
            turned = [t + v[:, j] for t, v in zip(turned, (x, y, z), strict=True)]
    b1, b2, b3 = _bell(*turned)
    size = float(np.linalg.norm(hand[1]))
    x, y, z = turned
    return (n1 + size * b1, n2 + size * b2, n3 + size * b3), (x, y, z)


def _bell(x: Array, y: Array, z: Array) -> tuple[Array, Array, Array]:
    return x, x * x + y, x * x * x + 3.0 * x * y + z
