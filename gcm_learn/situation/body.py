"""Bodies: targets and obstacles, each a shape that follows a motion law."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from gcm_learn.checks import (
    choice,
    non_negative,
    normalised,
    number,
    positive,
    put,
    quote,
    sequence,
    show,
    text,
    vector,
)
from gcm_learn.errors import SituationError
from gcm_learn.situation.laws import Motion
from gcm_learn.situation.motion import PlanarQuadratic
from gcm_learn.situation.shapes import PLANAR, SPACE, SURFACES, Shape

ROLES = ("target", "obstacle")


@dataclass(frozen=True)
class Approach:
    """Directions from which a hand may catch a target.

    Parameters
    ----------
    axis : (3,) tuple of float
        Unit vector in the target's frame, with which it turns; normalised.
    within : float
        Largest angle between the hand's axis and `axis`, in [0, pi] [rad].
    hand : (3,) tuple of float, optional
        Unit vector in the frame of the hand's joint that stands for the hand's axis; normalised.
    """

    axis: tuple[float, float, float]
    within: float
    hand: tuple[float, float, float] | None = None

    def __post_init__(self) -> None:
        """Check the documented ranges and normalise the axes."""
        put(self, "axis", normalised(self.axis, "axis"))
        if self.hand is not None:
            put(self, "hand", normalised(self.hand, "hand"))
        put(self, "within", number(self.within, "within"))
        if not 0.0 <= self.within <= math.pi:
            raise SituationError("within", f"must be from 0 to pi (got {self.within!r})")


@dataclass(frozen=True)
class Hold:
    """Time for which a hand moves with a target after the catch.

    Parameters
    ----------
    seconds : float
        Not negative [s].
    relative_speed : float
        Largest speed of the hand relative to the target's material there, above zero [lengths/s].
    """

    seconds: float
    relative_speed: float

    def __post_init__(self) -> None:
        """Check the documented ranges."""
        put(self, "seconds", non_negative(self.seconds, "seconds"))
        put(self, "relative_speed", positive(self.relative_speed, "relative_speed"))


@dataclass(frozen=True)
class Place:
    """Place to which a hand carries a target after its hold.

    Parameters
    ----------
    position : (3,) tuple of float
        Place of the target's origin, in the world.
    within : float
        Largest distance from it, above zero.
    """

    position: tuple[float, float, float]
    within: float

    def __post_init__(self) -> None:
        """Check the documented ranges."""
        put(self, "position", vector(self.position, "position", 3))
        put(self, "within", positive(self.within, "within"))


@dataclass(frozen=True)
class Margin:
    """Distance that all links keep from an obstacle: ``now + rate t`` at time t.

    Parameters
    ----------
    now : float
        Not negative.
    rate : float
        Not negative [lengths/s].
    """

    now: float
    rate: float

    def __post_init__(self) -> None:
        """Check the documented ranges."""
        put(self, "now", non_negative(self.now, "now"))
        put(self, "rate", non_negative(self.rate, "rate"))


ASKED: dict[str, type] = {"hold": Hold, "place": Place, "margin": Margin}
"""Records in fields of bodies."""
OF_TARGETS = ("approach", "hold", "place", "ignore", "ignore_for")
"""Fields that targets alone have; `margin` is for obstacles."""
WITH = (("place", "hold"), ("ignore", "place"), ("ignore_for", "ignore"))
"""Fields of targets, and those without which they mean nothing."""


@dataclass(frozen=True)
class Body:
    """A target or an obstacle: a shape that follows a motion law.

    Parameters
    ----------
    role : {"target", "obstacle"}
        Targets are to be caught and block nothing; obstacles must not be touched.
    name : str
        Unique among the bodies of a situation.
    shape : Shape
        Planar or solid, like the motion.
    motion : Motion
        Planar or solid, like the shape.
    approach : tuple of Approach
        Directions from which the hand may catch a target, one or two, all of which are kept; any
        direction when empty. One alone need not be in a tuple.
    hold : Hold, optional
        How the hand moves with a target after the catch.
    place : Place, optional
        Where the hand carries a target after its hold.
    ignore : tuple of str
        Obstacles that a carried target may touch.
    ignore_for : float, optional
        Time for which they are ignored at both ends of the carry, above zero; all of it by
        default [s].
    margin : Margin, optional
        Distance that links keep from an obstacle; none by default.
    """

    role: str
    name: str
    shape: Shape
    motion: Motion
    approach: tuple[Approach, ...] = ()
    hold: Hold | None = None
    place: Place | None = None
    ignore: tuple[str, ...] = ()
    ignore_for: float | None = None
    margin: Margin | None = None

    def __post_init__(self) -> None:
        """Check the role and that shape and motion live in the same space."""
        put(self, "role", choice(self.role, "role", ROLES))
        put(self, "name", text(self.name, "name"))
        if not isinstance(self.shape, PLANAR + SPACE):
            raise SituationError("shape", f"must be a shape (got {show(self.shape)})")
        if isinstance(self.shape, SURFACES) and self.role == "target":
            reason = f"{quote(self.shape.kind)} is for obstacles (this is a target)"
            raise SituationError("shape.kind", reason)
        if not isinstance(self.motion, Motion):
            raise SituationError("motion", f"must be a motion (got {show(self.motion)})")
        if self.is_solid == isinstance(self.motion, PlanarQuadratic):
            space = "3D" if self.is_solid else "planar"
            reason = f"{space} shape {quote(self.shape.kind)} needs a {space} motion"
            raise SituationError("motion", f"{reason} (got {type(self.motion).__name__})")
        put(self, "approach", _approaches(self.approach))
        self._check_asked()

    def _check_asked(self) -> None:
        """Check the optional fields, each by itself, with the role and with the others."""
        for name, record in ASKED.items():
            given = getattr(self, name)
            if given is not None and not isinstance(given, record):
                raise SituationError(name, f"must be a {name} (got {show(given)})")
        names = sequence(self.ignore, "ignore", "names of obstacles")
        put(self, "ignore", tuple(text(name, f"ignore[{k}]") for k, name in enumerate(names)))
        if self.ignore_for is not None:
            put(self, "ignore_for", positive(self.ignore_for, "ignore_for"))
        for name in OF_TARGETS if self.role == "obstacle" else ("margin",):
            if self._has(name):
                other = "targets" if self.role == "obstacle" else "obstacles"
                article = "an" if self.role == "obstacle" else "a"
                raise SituationError(name, f"is for {other} (this is {article} {self.role})")
        for name, other in WITH:
            if self._has(name) and not self._has(other):
                raise SituationError(name, f"is given without {other}")

    def _has(self, name: str) -> bool:
        return getattr(self, name) not in (None, ())

    @property
    def newer(self) -> tuple[str, ...]:
        """Fields in use that ``gcm-learn/situation@4`` adds."""
        names = [name for name in (*ASKED, "ignore", "ignore_for") if self._has(name)]
        if len(self.approach) > 1 or any(one.hand is not None for one in self.approach):
            names.append("approach")
        if isinstance(self.shape, SURFACES):
            names.append("shape.kind")
        return tuple(names)

    @property
    def is_solid(self) -> bool:
        """Return whether the body is three-dimensional."""
        return isinstance(self.shape, SPACE)


def _approaches(given: Any) -> tuple[Approach, ...]:
    """Return the approaches of a target as a tuple; a single approach may be given alone."""
    if given is None:
        return ()
    alone = not isinstance(given, list | tuple)
    items: tuple[Any, ...] = (given,) if alone else tuple(given)
    for k, item in enumerate(items):
        if not isinstance(item, Approach):
            field = "approach" if alone else f"approach[{k}]"
            raise SituationError(field, f"must be an approach (got {show(item)})")
    if len(items) > 2:
        raise SituationError("approach", f"must be one or two approaches (got {len(items)})")
    return items
