"""Perception of the world: at a steady rate, late, inexact, with dropouts.

Places and velocities are of the bodies' centres; a pendulum is seen along its arc.  Shapes,
orientations and spins are exact, and a centre at rest is recognised.  Accelerations are not seen.
Of piecewise and sampled motions the whole law is known but for where it lies: each look sees all of
it shifted alike, so its velocities are exact.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple

import numpy as np

from gcm_learn import seeding
from gcm_learn.errors import ArenaError
from gcm_learn.execution.loop.kinds import LEADS
from gcm_learn.scene import bodies_later
from gcm_learn.situation import (
    AnySituation,
    Body,
    Motion,
    Pendulum,
    Piece,
    Piecewise,
    PlanarQuadratic,
    Sampled,
    SolidQuadratic,
)

PERIOD = 0.02  # between two looks: 50 Hz [s]
Quadratic = PlanarQuadratic | SolidQuadratic
Course = Piecewise | Sampled
"""Motion whose law is known but for a shift of its places."""
DARK = 0.1  # how long a dropout lasts [s]
_SHORTEST = 1e-3  # hang below which a pendulum's angle is hardly seen [forearms]


class Percept(NamedTuple):
    """Result of one look."""

    time: float
    """Time of the world at the look [s]; the percept comes later."""
    bodies: tuple[Body, ...]
    """Their motions begin at that time; all accelerations are 0, since they are not seen, but in
    piecewise motions."""
    rests: tuple[bool, ...]
    """True for bodies whose centres rest."""


@dataclass(frozen=True)
class Perception:
    """Model of inexact perception."""

    place: float = 0.0
    """Standard deviation of each coordinate of a place [forearms]."""
    faster: float = 5.0
    """Deviation of velocities over that of places [1/s]."""
    dropouts: float = 0.0
    """Frequency of dropouts [1/s]; each takes 0.1 s, without any percept."""
    delay: int = 1
    """Periods after which the percept of a look comes."""
    period: float = PERIOD
    """Between two looks [s]."""
    latency: float = 0.0
    """Time by which percepts come later still [s]; they tell when they were seen."""

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            whole = field.name == "delay"
            if isinstance(value, bool) or not isinstance(value, int if whole else (int, float)):
                kind = "an integer" if whole else "a number"
                raise ArenaError(f"{field.name}: must be {kind} (got {value!r})")
            if not 0.0 <= value < 1e6:
                raise ArenaError(f"{field.name}: must be from 0 to 1e6 (got {value!r})")
        if self.period == 0.0:
            raise ArenaError("period: must be positive (got 0)")
        if self.dropouts * self.period > 1.0:
            most = 1.0 / self.period
            raise ArenaError(f"dropouts: must be at most {most:g} a second (got {self.dropouts:g})")

    def deviations(self, motion: Motion, forearm: float) -> tuple[float, float]:
        """Standard deviations of a motion's place and velocity, of a pendulum's angle and rate.

        Parameters
        ----------
        motion : PlanarQuadratic, SolidQuadratic, Pendulum, Piecewise or Sampled
        forearm : float
            Length of the arm's forearm [lengths].
        """
        place = self.place * forearm
        if isinstance(motion, Pendulum):
            place /= max(motion.hang_distance, _SHORTEST * forearm)
        return place, self.faster * place

    def told(self, situation: AnySituation, look: int, seed: int, *index: int) -> Percept | None:
        """Return the percept at look number `look`, or None in a dropout.

        Parameters
        ----------
        situation : Situation
            The world from t = 0 on.
        look : int
            From 0 on; look k is at k periods.
        seed : int
        *index : int
            Of the errors: the same for the same seed, index and look, whatever was asked before.
        """
        seen = look - self.delay
        time = seen * self.period - self.latency
        if time < 0.0 or time >= situation.horizon or self.dark(seen, seed, *index):
            return None
        source = seeding.rng(seed, *index, seen)
        forearm = LEADS.of(situation).forearm(situation.arm)
        bodies = tuple(
            replace(body, motion=self._blurred(body.motion, forearm, source))
            for body in bodies_later(situation.bodies, time)
        )
        return Percept(time, bodies, tuple(rests(body.motion) for body in situation.bodies))

    def dark(self, seen: int, seed: int, *index: int) -> bool:
        """Return whether a look falls into a dropout."""
        if self.dropouts == 0.0:
            return False
        last = max(math.ceil(DARK / self.period - 1e-9), 1)
        chance = self.dropouts * self.period
        return any(
            seeding.rng(seed, *index, k, 1).random() < chance
            for k in range(max(seen - last + 1, 0), seen + 1)
        )

    def _blurred(self, motion: Motion, forearm: float, source: np.random.Generator) -> Motion:
        """Return a motion with random errors of perception."""
        place, fast = self.deviations(motion, forearm)
        if isinstance(motion, Pendulum):
            off, faster = source.normal(size=2).tolist()
            return replace(
                motion, angle=motion.angle + place * off, rate=motion.rate + fast * faster
            )
        if isinstance(motion, Course):
            return shifted(motion, place * source.normal(size=3))
        if not isinstance(motion, Quadratic):
            raise ArenaError(f"perception: does not see {motion.kind} motions")
        count = len(motion.position)
        off, faster = place * source.normal(size=count), fast * source.normal(size=count)
        if rests(motion):
            faster = np.zeros(count)
        seen: Any = dict(
            position=tuple((np.array(motion.position) + off).tolist()),
            velocity=tuple((np.array(motion.velocity) + faster).tolist()),
            acceleration=(0.0,) * count,
        )
        return replace(motion, **seen)


def start_of(motion: Course) -> tuple[float, float, float]:
    """Return the place of a piecewise or sampled motion at t = 0."""
    return motion.pieces[0].motion.position


def shifted(motion: Course, off: np.ndarray) -> Course:
    """Return a piecewise or sampled motion with all places shifted by `off` (3,) [lengths]."""
    if isinstance(motion, Sampled):
        rows: Any = (np.array(motion.positions) + off).tolist()
        return replace(motion, positions=tuple(map(tuple, rows)))
    pieces = []
    for start, law in motion.pieces:
        place: Any = tuple((np.array(law.position) + off).tolist())
        pieces.append(Piece(start, replace(law, position=place)))
    return Piecewise.unchecked(pieces)


def rests(motion: Motion) -> bool:
    """Return whether a body's centre rests, and goes on to rest."""
    if not isinstance(motion, Quadratic):
        return False
    return not any(motion.velocity) and not any(motion.acceleration)
