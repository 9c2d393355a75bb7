"""Motion laws of bodies: one entry for each law, with its place in formats."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from gcm_learn.arms import Kind, kinds, quaternion_of, rotation_of
from gcm_learn.situation.motion import Pendulum, PlanarQuadratic, SolidQuadratic
from gcm_learn.situation.timed_motion import Piece, Piecewise, Sampled

SolidMotion = SolidQuadratic | Pendulum | Piecewise | Sampled
Motion = PlanarQuadratic | SolidMotion

_ITS_MIRROR = np.diag([1.0, -1.0, 1.0])  # a body reflected in its own xz-plane


class Coordinates(NamedTuple):
    """Coordinates that map a point p to ``turn @ (p - origin)``.

    A reflection also reflects each body in its own xz-plane, which mirrors all our solids.  Bodies
    are therefore turned only.
    """

    turn: np.ndarray  # (3, 3) orthogonal
    origin: np.ndarray  # (3,)
    reflected: bool

    def move(self, v: ArrayLike) -> tuple[float, float, float]:
        """Return a direction in these coordinates."""
        x, y, z = (self.turn @ np.asarray(v, dtype=float)).tolist()
        return (x, y, z)

    def place(self, v: ArrayLike) -> tuple[float, float, float]:
        """Return a point in these coordinates."""
        return self.move(np.asarray(v, dtype=float) - self.origin)

    def axial(self, v: ArrayLike) -> tuple[float, float, float]:
        """Return an axis of rotation, which reflections turn round as well."""
        return self.move(-np.asarray(v, dtype=float) if self.reflected else v)

    def pose(self, orientation: tuple[float, ...]) -> tuple[float, float, float, float]:
        """Return an orientation in these coordinates."""
        rotation = self.turn @ rotation_of(orientation)
        return quaternion_of(rotation @ _ITS_MIRROR if self.reflected else rotation)


def carried(motion: SolidMotion, turn: np.ndarray, origin: np.ndarray) -> SolidMotion:
    """Return a motion law in other coordinates, which map p to ``turn @ (p - origin)``.

    Parameters
    ----------
    motion : SolidMotion
    turn : (3, 3) ndarray
        Orthogonal; may be a reflection.
    origin : (3,) ndarray
    """
    view = Coordinates(turn, origin, bool(np.linalg.det(turn) < 0.0))
    result: SolidMotion = LAWS[type(motion)].carried(motion, view)
    return result


def sides(motion: SolidMotion) -> Iterator[float]:
    """Yield the numbers of a motion law that a mirror in the xz-plane negates."""
    yield from LAWS[type(motion)].sides(motion)


@dataclass(frozen=True)
class SolidLaw:
    """Functions of one motion law of solids.

    Parameters
    ----------
    carried : callable
        Maps a motion and a `Coordinates` to the motion in those coordinates.
    sides : callable
        Maps a motion to the numbers that a mirror in the xz-plane negates.
    """

    carried: Callable[[Any, Coordinates], Any]
    sides: Callable[[Any], Iterator[float]]


def _quadratic_carried(motion: SolidQuadratic, view: Coordinates) -> SolidQuadratic:
    return SolidQuadratic(
        view.place(motion.position),
        view.move(motion.velocity),
        view.move(motion.acceleration),
        view.pose(motion.orientation),
        view.axial(motion.spin),
    )


def _quadratic_sides(motion: SolidQuadratic) -> Iterator[float]:
    yield from (motion.position[1], motion.velocity[1], motion.acceleration[1])
    yield from (motion.spin[0], motion.spin[2])


def _pendulum_carried(motion: Pendulum, view: Coordinates) -> Pendulum:
    axis, down = view.axial(motion.axis), view.move(motion.down)
    return replace(motion, pivot=view.place(motion.pivot), axis=axis, down=down)


def _pendulum_sides(motion: Pendulum) -> Iterator[float]:
    yield from (motion.pivot[1], motion.down[1], motion.axis[0], motion.axis[2])


def _piecewise_carried(motion: Piecewise, view: Coordinates) -> Piecewise:
    return Piecewise.unchecked(
        Piece(start, _quadratic_carried(piece, view)) for start, piece in motion.pieces
    )


def _sampled_carried(motion: Sampled, view: Coordinates) -> Sampled:
    turns = motion.orientations
    return Sampled(
        motion.times,
        tuple(map(view.place, motion.positions)),
        None if turns is None and _unturned(view) else tuple(map(view.pose, motion.turns)),
    )


def _unturned(view: Coordinates) -> bool:
    return bool((view.turn @ (_ITS_MIRROR if view.reflected else np.eye(3)) == np.eye(3)).all())


def _sides_of_pieces(motion: Piecewise | Sampled) -> Iterator[float]:
    for _, piece in motion.pieces:
        yield from _quadratic_sides(piece)


LAWS: dict[type, SolidLaw] = {
    SolidQuadratic: SolidLaw(_quadratic_carried, _quadratic_sides),
    Pendulum: SolidLaw(_pendulum_carried, _pendulum_sides),
    Piecewise: SolidLaw(_piecewise_carried, _sides_of_pieces),
    Sampled: SolidLaw(_sampled_carried, _sides_of_pieces),
}


NEWEST: dict[str, tuple[str, ...]] = {
    "situation": ("end", "end_by"),
    "arm": ("max_jerk", "accelerations", "max_joint_jerk", "joint_accelerations"),
    "body": ("hold", "place", "ignore", "ignore_for", "margin"),
    "approach": ("hand",),
}
"""Fields that ``gcm-learn/situation@4`` adds, by the part of a situation that has them."""


@dataclass(frozen=True)
class Format:
    """One version of the exchange format.

    Parameters
    ----------
    name : str
    motions : tuple of type
        Motion laws that bodies may follow.
    catches : tuple of str
        Known values of `catch`; the first is the default, and one alone is never written.
    approach : bool
        Whether targets may have an approach.
    planes : bool
        Whether a planar arm may stand in a plane among solids.
    normalises : bool
        Whether unit vectors may be off by up to `checks.UNIT_LENGTH`, and are normalised.
    holds : bool
        Whether there are the fields of `NEWEST`: holds, places, margins, ends, limits of jerk.
    """

    name: str
    motions: tuple[type[Motion], ...]
    catches: tuple[str, ...] = ("any",)
    approach: bool = False
    planes: bool = False
    normalises: bool = False
    holds: bool = False

    @property
    def kinds(self) -> tuple[Kind, ...]:
        """Kinds of arms that situations of this format have."""
        return tuple(kind for kind in kinds() if self.name in kind.formats)

    @cached_property
    def motion_kinds(self) -> tuple[str, ...]:
        """Values of `kind` in motions."""
        return tuple(dict.fromkeys(motion.kind for motion in self.motions))

    @cached_property
    def absent(self) -> dict[str, frozenset[str]]:
        """Fields that this format does not know, by the part of a situation that has them."""
        absent = {part: () if self.holds else names for part, names in NEWEST.items()}
        absent["situation"] += () if len(self.catches) > 1 else ("catch",)
        absent["body"] += () if self.approach else ("approach",)
        return {part: frozenset(names) for part, names in absent.items()}


_QUADRATIC = (PlanarQuadratic, SolidQuadratic, Pendulum)
_TIMED = (*_QUADRATIC, Piecewise, Sampled)
CATCHES = ("any", "all", "most")
ENDS = ("free", "rest")
"""Motions of the arm at the end; the first is the default."""

FORMATS = {
    version.name: version
    for version in (
        Format("gcm-learn/situation@1", _QUADRATIC, planes=True),
        Format("gcm-learn/situation@2", _QUADRATIC),
        Format("gcm-learn/situation@3", _TIMED, CATCHES, approach=True, normalises=True),
        Format(
            "gcm-learn/situation@4", _TIMED, CATCHES, approach=True, normalises=True, holds=True
        ),
    )
}
