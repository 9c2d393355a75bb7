"""Bodies: targets and obstacles, each a shape that follows a motion law."""

from __future__ import annotations

import math
from dataclasses import dataclass

from gcm_learn.checks import choice, normalised, number, put, quote, show, text
from gcm_learn.errors import SituationError
from gcm_learn.situation.laws import Motion
from gcm_learn.situation.motion import PlanarQuadratic
from gcm_learn.situation.shapes import PLANAR, SOLID, Shape

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
    """

    axis: tuple[float, float, float]
    within: float

    def __post_init__(self) -> None:
        """Check the documented ranges and normalise the axis."""
        put(self, "axis", normalised(self.axis, "axis"))
        put(self, "within", number(self.within, "within"))
        if not 0.0 <= self.within <= math.pi:
            raise SituationError("within", f"must be from 0 to pi (got {self.within!r})")


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
    approach : Approach, optional
        Directions from which the hand may catch a target; any when absent.
    """

    role: str
    name: str
    shape: Shape
    motion: Motion
    approach: Approach | None = None

    def __post_init__(self) -> None:
        """Check the role and that shape and motion live in the same space."""
        put(self, "role", choice(self.role, "role", ROLES))
        put(self, "name", text(self.name, "name"))
        if not isinstance(self.shape, PLANAR + SOLID):
            raise SituationError("shape", f"must be a shape (got {show(self.shape)})")
        if not isinstance(self.motion, Motion):
            raise SituationError("motion", f"must be a motion (got {show(self.motion)})")
        if self.is_solid == isinstance(self.motion, PlanarQuadratic):
            space = "3D" if self.is_solid else "planar"
            reason = f"{space} shape {quote(self.shape.kind)} needs a {space} motion"
            raise SituationError("motion", f"{reason} (got {type(self.motion).__name__})")
        if self.approach is not None:
            self._check_approach()

    def _check_approach(self) -> None:
        if not isinstance(self.approach, Approach):
            raise SituationError("approach", f"must be an approach (got {show(self.approach)})")
        if self.role != "target":
            raise SituationError("approach", "is for targets (this is an obstacle)")

    @property
    def is_solid(self) -> bool:
        """Return whether the body is three-dimensional."""
        return isinstance(self.shape, SOLID)
