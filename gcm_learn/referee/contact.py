"""Distances over a whole movement, with proof: no instant between samples is left out.

An interval of time is settled by the distance in its middle and by bounds of the ways that both
parts make until its ends.  Other intervals are divided.
"""

from __future__ import annotations

from collections.abc import Set
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np

from gcm_learn.referee.motions import Body, into
from gcm_learn.referee.rotations import Array
from gcm_learn.referee.segments import point_apart, segments_apart
from gcm_learn.referee.shapes import is_centred, segment_gaps
from gcm_learn.referee.tolerances import WORK

PARTS = 4
"""Into which an interval is divided."""
HAIR = 1e-9
"""Way that is as good as none, as a share of the length of the arm."""


class Motion(Protocol):
    """Capsules that move along a trajectory."""

    radii: Array
    """Radii (links,)."""
    pairs: Array
    """Pairs (m, 2) of links that must not overlap."""
    size: float
    """Length of the arm."""

    def starts(self) -> Array:
        """Return times (k + 1,) between which intervals begin."""
        ...

    def ends(self, times: Array) -> Array:
        """Return both ends (k, links, 2, 3) of the links' axes at times (k,)."""
        ...

    def ways(self, low: Array, middle: Array, high: Array) -> Array:
        """Return bounds (k, links) of the links' ways from the middles of intervals (k,)."""
        ...

    def pair_ways(self, low: Array, middle: Array, high: Array) -> Array:
        """Return bounds (k, m) of the ways of pairs relative to each other."""
        ...


class Watched(NamedTuple):
    """A movement of links, and the pairs of link and obstacle that it ignores."""

    motion: Motion
    ignored: Set[tuple[int, str]]
    """Links and obstacles that are not checked."""
    carried: str = ""
    """Name of a carried target, which is the only link; empty for links of the arm."""


@dataclass(frozen=True)
class Nearest:
    """Least distance over a movement."""

    gap: float = np.inf
    """Signed distance, at most the asked-for error above the least one."""
    at: float = 0.0
    what: str = ""
    settled: bool = True
    """False if too many intervals were examined."""


class _Intervals:
    """Intervals of time, each with the index of the pair that is compared in it."""

    def __init__(self, edges: Array, count: int, work: int) -> None:
        self.work = work
        low, high = edges[:-1], edges[1:]
        self.low, self.high = (np.tile(t, count) for t in (low, high))
        self.which = np.repeat(np.arange(count), len(low))
        self.spent = 0

    def middles(self) -> tuple[Array, Array, Array, Array]:
        """Return distinct intervals by low, middle and high, and the place of each in them."""
        self.spent += len(self.low)
        middle = 0.5 * (self.low + self.high)
        distinct, first, place = np.unique(middle, return_index=True, return_inverse=True)
        return self.low[first], distinct, self.high[first], place.reshape(-1)

    def keep(self, chosen: Array) -> None:
        self.low, self.high, self.which = (
            column[chosen] for column in (self.low, self.high, self.which)
        )

    def divide(self) -> None:
        cuts = np.linspace(self.low, self.high, PARTS + 1)
        self.low, self.high = cuts[:-1].T.ravel(), cuts[1:].T.ravel()
        self.which = np.repeat(self.which, PARTS)

    @property
    def settled(self) -> bool:
        return len(self.low) == 0

    @property
    def exhausted(self) -> bool:
        return self.spent > self.work


def nearest_obstacle(
    motion: Motion,
    bodies: list[Body],
    ignored: Set[tuple[int, str]],
    floor: float,
    close: float,
    work: int = WORK,
    margins: bool = False,
) -> Nearest:
    """Return the least distance of links and obstacles, less the obstacles' margins if so asked.

    Parameters
    ----------
    floor : float
        Distances below it are contacts.
    close : float
        Allowed error of a distance that is no contact.
    work : int
        Intervals that are examined at most.
    """
    obstacles = [body for body in bodies if body.role == "obstacle"]
    now, rate = np.array([o.margin if margins else (0.0, 0.0) for o in obstacles] or [(0, 0)]).T
    links = range(len(motion.radii))
    pairs = [
        (i, k) for k, body in enumerate(obstacles) for i in links if (i, body.name) not in ignored
    ]
    if not pairs:
        return Nearest()
    link, body = np.array(pairs).T
    centred = np.array([is_centred(o.shape) for o in obstacles])
    items, best, upper = _Intervals(motion.starts(), len(pairs), work), Nearest(), np.inf
    while not items.settled:
        if items.exhausted:
            return Nearest(best.gap, best.at, best.what, settled=False)
        low, middle, high, place = items.middles()
        i, b = link[items.which], body[items.which]
        axis = motion.ends(middle)[place, i]
        centre, turn = _poses(obstacles, middle)
        way = motion.ways(low, middle, high)[place, i]
        way += np.stack([o.ways(low, middle, high) for o in obstacles])[b, place]
        thick = motion.radii[i] + now[b] + rate[b] * middle[place]
        way += 0.5 * rate[b] * (high - low)[place]
        off = point_apart(centre[b, place], axis[:, 0], axis[:, 1]) - thick
        upper = min(upper, float(off[centred[b]].min(initial=np.inf)))
        gap = off - np.array([o.ball for o in obstacles])[b]
        near = ~(gap - way >= _cut(min(best.gap, upper), close, floor))  # NaN is near
        for k, obstacle in enumerate(obstacles):
            rows = np.flatnonzero(near & (b == k))
            if len(rows) and obstacle.shape["kind"] != "sphere":
                ends = axis[rows].transpose(1, 0, 2)
                ends = [into(centre[k, place[rows]], turn[k, place[rows]], end) for end in ends]
                gap[rows] = segment_gaps(obstacle.shape, *ends) - thick[rows]
        rows = np.flatnonzero(near)
        if len(rows):
            k = rows[gap[rows].argmin()]
            if gap[k] < best.gap:
                what = f"link {i[k]} and {obstacles[b[k]].name}"
                best = Nearest(float(gap[k]), float(middle[place[k]]), what)
        if best.gap < floor:
            return best
        cut = _cut(min(best.gap, upper), close, floor)
        items.keep(near & ~(gap - way >= cut) & ~(way <= HAIR * motion.size))
        items.divide()
    if upper < best.gap:  # within the allowed error
        return Nearest(upper, best.at, best.what)
    return best


def _cut(best: float, close: float, floor: float) -> float:
    """Return the distance from which on an interval is settled."""
    return floor if np.isinf(close) else max(best - close, floor)


def _poses(bodies: list[Body], times: Array) -> tuple[Array, Array]:
    """Return centres (bodies, k, 3) and rotations (bodies, k, 3, 3)."""
    centres, turns = zip(*(body.poses(times) for body in bodies), strict=True)
    return np.array(centres), np.array(turns)


def overlap(motion: Motion, floor: float, work: int = WORK) -> Nearest:
    """Return a distance of two links below a floor, or none at all."""
    if not len(motion.pairs):
        return Nearest()
    first, second = motion.pairs.T
    radii = motion.radii[first] + motion.radii[second]
    items = _Intervals(motion.starts(), len(first), work)
    while not items.settled:
        if items.exhausted:
            return Nearest(settled=False)
        low, middle, high, place = items.middles()
        i, j = first[items.which], second[items.which]
        axes = motion.ends(middle)
        a, b = axes[place, i], axes[place, j]
        gap = segments_apart(a[:, 0], a[:, 1], b[:, 0], b[:, 1]) - radii[items.which]
        k = int(gap.argmin())
        if gap[k] < floor:
            return Nearest(float(gap[k]), float(middle[place[k]]), f"links {i[k]} and {j[k]}")
        way = motion.pair_ways(low, middle, high)[place, items.which]
        items.keep(~(gap - way >= floor) & ~(way <= HAIR * motion.size))
        items.divide()
    return Nearest()
