"""Motion laws that change at given times: pieces of quadratic motion, and sampled poses."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any, ClassVar, NamedTuple

import numpy as np

from gcm_learn.checks import LARGEST, number, put, sequence, show, unit_vector, vector
from gcm_learn.errors import SituationError
from gcm_learn.situation.motion import SolidQuadratic

Quaternion = tuple[float, float, float, float]
Vector = tuple[float, float, float]


def product(p: Sequence[float], q: Sequence[float]) -> Quaternion:
    """Return the quaternion of the rotation q followed by the rotation p."""
    a, b, c, d = p
    w, x, y, z = q
    return (
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    )


def turned(orientation: Sequence[float], spin: Sequence[float], t: float) -> Quaternion:
    """Return exp([spin t]) applied to an orientation; `spin` is in the world frame [rad/s]."""
    rate = math.hypot(*spin)
    if rate * t == 0.0:
        w, x, y, z = orientation
        return (w, x, y, z)
    half = 0.5 * rate * t
    along = math.sin(half) / rate
    x, y, z = spin
    return product((math.cos(half), x * along, y * along, z * along), orientation)


def spins_between(orientations: np.ndarray, steps: np.ndarray) -> np.ndarray:
    """Return the constant spins (m - 1, 3) that turn each of the orientations (m, 4) into the next.

    They turn the short way, within `steps` (m - 1,) [s].
    """
    w, x, y, z = orientations[:-1].T
    a, *turn = product(orientations[1:].T, (w, -x, -y, -z))  # type: ignore[arg-type]
    b, c, d = turn
    side, size = np.where(a < 0.0, -1.0, 1.0), np.sqrt(b * b + c * c + d * d)
    rate = side * 2.0 * np.arctan2(size, side * a) / (np.where(size > 0.0, size, 1.0) * steps)
    return (np.array(turn) * rate).T


def nearer(first: Sequence[float], second: Sequence[float]) -> tuple[float, ...]:
    """Return the second quaternion with the sign that brings it nearer to the first."""
    same = math.fsum(a * b for a, b in zip(first, second, strict=True)) >= 0.0
    return tuple(x if same else -x for x in second)


MEET = 1e-6
"""Largest gap where pieces meet, as a share of the larger of 1 and the numbers."""
HALF_TURN = 1e-6
"""Neighbouring orientations are half a turn apart if their product is at most this."""
_UNTURNED = (1.0, 0.0, 0.0, 0.0)


class PieceArrays(NamedTuple):
    """Pieces of a motion as arrays; see `SolidQuadratic`."""

    start: np.ndarray
    """(m,) [s]."""
    position: np.ndarray
    """(m, 3)."""
    velocity: np.ndarray
    """(m, 3)."""
    acceleration: np.ndarray
    """(m, 3)."""
    orientation: np.ndarray
    """(m, 4)."""
    spin: np.ndarray
    """(m, 3) [rad/s]."""

    def piece(self, k: int) -> Piece:
        """Return piece k."""
        start, *law = (row[k].tolist() for row in self)
        return Piece(start, SolidQuadratic(*map(tuple, law)))


class Piece(NamedTuple):
    """A quadratic motion from a time on, in the time since then."""

    start: float
    """Time at which the motion begins to hold [s]."""
    motion: SolidQuadratic


@dataclass(frozen=True)
class Piecewise:
    """Quadratic motions one after another, such as those between bounces.

    Parameters
    ----------
    pieces : tuple of (float, SolidQuadratic)
        Start [s] and motion of each piece, in the time since its start.  Starts increase from 0.
        Position and orientation agree where pieces meet; velocities may jump.
    """

    pieces: tuple[Piece, ...]

    kind: ClassVar[str] = "piecewise"

    def __post_init__(self) -> None:
        """Check that starts increase from 0 and that pieces meet."""
        pieces = tuple(
            _piece(item, f"pieces[{k}]")
            for k, item in enumerate(sequence(self.pieces, "pieces", "pieces"))
        )
        put(self, "pieces", pieces)
        _check_times([piece.start for piece in pieces], "pieces", "pieces[{}].start")
        for k, (before, after) in enumerate(pairwise(pieces), start=1):
            _check_meeting(before, after, k)

    @classmethod
    def unchecked(cls, pieces: Iterable[Piece]) -> Piecewise:
        """Return pieces that met in other coordinates, where the tolerance was another."""
        made = object.__new__(cls)
        put(made, "pieces", tuple(pieces))
        return made

    @cached_property
    def arrays(self) -> PieceArrays:
        """Return the pieces as arrays."""
        laws = [piece.motion for piece in self.pieces]
        names = PieceArrays._fields[1:]
        columns = (np.array([getattr(law, name) for law in laws]) for name in names)
        return PieceArrays(np.array([piece.start for piece in self.pieces]), *columns)

    def at(self, t: float) -> Piece:
        """Return the piece that holds at a time [s]."""
        return self.pieces[max(bisect_right(self.pieces, t, key=lambda p: p.start) - 1, 0)]


def _piece(value: Any, field: str) -> Piece:
    """Return a piece of which start and motion have been checked."""
    if not isinstance(value, tuple) or len(value) != 2 or not isinstance(value[1], SolidQuadratic):
        raise SituationError(field, f"must be a start and a SolidQuadratic (got {show(value)})")
    return Piece(number(value[0], f"{field}.start"), value[1])


def _check_times(times: Sequence[float], field: str, item: str) -> None:
    """Require that times begin at 0 and increase."""
    if not times:
        raise SituationError(field, "must not be empty")
    if times[0] != 0.0:
        raise SituationError(item.format(0), f"must be 0 (got {times[0]!r})")
    for k, (before, after) in enumerate(pairwise(times), start=1):
        if after <= before:
            raise SituationError(item.format(k), f"{after} does not come after {before}")


def _check_meeting(before: Piece, after: Piece, k: int) -> None:
    """Refuse a piece that does not begin where the piece before it ends."""
    position, orientation = flown(before.motion, after.start - before.start)
    gaps = (
        ("position", position, after.motion.position),
        ("orientation", nearer(after.motion.orientation, orientation), after.motion.orientation),
    )
    for name, end, begin in gaps:
        most = MEET * max(1.0, *map(abs, end), *map(abs, begin))
        gap = max(abs(a - b) for a, b in zip(end, begin, strict=True))
        if gap > most:
            reason = f"is {gap:.3g} away from the end of pieces[{k - 1}] (at most {most:.3g})"
            raise SituationError(f"pieces[{k}].{name}", reason)


def flown(motion: SolidQuadratic, t: float) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return position (3,) and orientation (4,) of a quadratic motion at a time [s]."""
    law = zip(motion.position, motion.velocity, motion.acceleration, strict=True)
    position = tuple(p + v * t + 0.5 * a * t * t for p, v, a in law)
    return position, turned(motion.orientation, motion.spin, t)


@dataclass(frozen=True)
class Sampled:
    """Poses at given times: linear between them, at rest after the last.

    Parameters
    ----------
    times : (m,) tuple of float
        Increasing from 0 [s].
    positions : (m, 3) tuple of float
        The body's centre in the world frame.
    orientations : (m, 4) tuple of float, optional
        Unit quaternions (w, x, y, z), body to world; the body turns from one to the next the
        short way at constant speed.  Identity when absent.
    """

    times: tuple[float, ...]
    positions: tuple[tuple[float, float, float], ...]
    orientations: tuple[tuple[float, float, float, float], ...] | None = None

    kind: ClassVar[str] = "sampled"

    def __post_init__(self) -> None:
        """Check shapes, times and the turns between neighbours."""
        times = sequence(self.times, "times", "numbers")
        put(self, "times", tuple(number(t, f"times[{k}]") for k, t in enumerate(times)))
        _check_times(self.times, "times", "times[{}]")
        positions = self._rows("positions", "3 numbers")
        rows = [vector(row, f"positions[{k}]", 3) for k, row in enumerate(positions)]
        put(self, "positions", tuple(rows))
        if self.orientations is not None:
            turns = self._rows("orientations", "4 numbers")
            units = [unit_vector(q, f"orientations[{k}]", 4) for k, q in enumerate(turns)]
            put(self, "orientations", tuple(units))
            self._check_turns()
        self._check_speeds()

    def _rows(self, name: str, content: str) -> Sequence[object]:
        rows = sequence(getattr(self, name), name, f"lists of {content}")
        if len(rows) != len(self.times):
            reason = f"must have one entry for each of {len(self.times)} times (got {len(rows)})"
            raise SituationError(name, reason)
        return rows

    def _check_turns(self) -> None:
        for k, (p, q) in enumerate(pairwise(self.orientations or ()), start=1):
            if abs(math.fsum(a * b for a, b in zip(p, q, strict=True))) <= HALF_TURN:
                reason = f"is half a turn away from orientations[{k - 1}]"
                raise SituationError(f"orientations[{k}]", reason)

    def _check_speeds(self) -> None:
        rows = zip(pairwise(self.times), pairwise(self.positions), strict=True)
        for k, ((s, t), (p, q)) in enumerate(rows, start=1):
            most = max(math.pi, *(abs(b - a) for a, b in zip(p, q, strict=True)))
            if most > (t - s) * LARGEST:
                raise SituationError(f"times[{k}]", f"{t} is too soon after {s}")

    @property
    def turns(self) -> tuple[tuple[float, float, float, float], ...]:
        """(m, 4) Orientations, given or not."""
        return self.orientations or (_UNTURNED,) * len(self.times)

    @cached_property
    def arrays(self) -> PieceArrays:
        """Return the motion as pieces of constant velocity and spin; the last piece rests."""
        start, position, turns = (np.array(x) for x in (self.times, self.positions, self.turns))
        steps, rest = np.diff(start), np.zeros((1, 3))
        velocity = np.vstack([np.diff(position, axis=0) / steps[:, None], rest])
        spin = np.vstack([spins_between(turns, steps), rest])
        return PieceArrays(start, position, velocity, np.zeros_like(position), turns, spin)

    @property
    def pieces(self) -> tuple[Piece, ...]:
        """Return the pieces; see `arrays`."""
        return tuple(map(self.arrays.piece, range(len(self.times))))

    def at(self, t: float) -> Piece:
        """Return the piece that holds at a time [s]."""
        return self.arrays.piece(max(bisect_right(self.times, t) - 1, 0))
