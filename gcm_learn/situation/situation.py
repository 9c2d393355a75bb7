"""A situation: one arm and the bodies around it, with everything they will do."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Generic

from gcm_learn.arms import Arm, SpatialArm, is_arm
from gcm_learn.checks import (
    choice,
    orthogonal,
    positive,
    put,
    quote,
    sequence,
    show,
    text,
    unit_vector,
    vector,
)
from gcm_learn.errors import ArmKindError, SituationError
from gcm_learn.situation.motion import (
    MOST_PERIODS,
    Motion,
    Pendulum,
    PlanarQuadratic,
    SolidQuadratic,
)
from gcm_learn.situation.shapes import PLANAR, SOLID, Shape

ROLES = ("target", "obstacle")


@dataclass(frozen=True)
class Plane:
    """The plane in which the arm moves in a 3D scene; all vectors in the world frame.

    Parameters
    ----------
    origin : (3,) tuple of float
        Position of the shoulder.
    x, y : (3,) tuple of float
        Orthogonal unit vectors: the axes of arm-plane coordinates.
    """

    origin: tuple[float, float, float]
    x: tuple[float, float, float]
    y: tuple[float, float, float]

    def __post_init__(self) -> None:
        """Check that the axes are orthonormal."""
        put(self, "origin", vector(self.origin, "origin", 3))
        put(self, "x", unit_vector(self.x, "x"))
        put(self, "y", unit_vector(self.y, "y"))
        orthogonal(self.x, self.y, "y", "x")

    @property
    def normal(self) -> tuple[float, float, float]:
        """Third axis of arm-plane coordinates, ``x cross y``."""
        (a, b, c), (d, e, f) = self.x, self.y
        return (b * f - c * e, c * d - a * f, a * e - b * d)


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
    """

    role: str
    name: str
    shape: Shape
    motion: Motion

    def __post_init__(self) -> None:
        """Check the role and that shape and motion live in the same space."""
        put(self, "role", choice(self.role, "role", ROLES))
        put(self, "name", text(self.name, "name"))
        if not isinstance(self.shape, PLANAR + SOLID):
            raise SituationError("shape", f"must be a shape (got {show(self.shape)})")
        if not isinstance(self.motion, (PlanarQuadratic, SolidQuadratic, Pendulum)):
            raise SituationError("motion", f"must be a motion (got {show(self.motion)})")
        if self.is_solid == isinstance(self.motion, PlanarQuadratic):
            space = "3D" if self.is_solid else "planar"
            reason = f"{space} shape {quote(self.shape.kind)} needs a {space} motion"
            raise SituationError("motion", f"{reason} (got {type(self.motion).__name__})")

    @property
    def is_solid(self) -> bool:
        """Whether the body is three-dimensional."""
        return isinstance(self.shape, SOLID)


if TYPE_CHECKING:
    from typing_extensions import TypeVar  # a default makes a plain `Situation` one of the plane

    ArmKind = TypeVar("ArmKind", bound=Arm | SpatialArm, default=Arm, covariant=True)
else:
    from typing import TypeVar

    ArmKind = TypeVar("ArmKind")


@dataclass(frozen=True)
class Situation(Generic[ArmKind]):
    """Everything a planner is told.

    In annotations, `Situation` has a planar arm, ``Situation[SpatialArm]`` one in space, and
    `AnySituation` either.

    Parameters
    ----------
    name : str
        Any string; unique within a file.
    horizon : float
        Last moment at which a catch counts, above zero [s].
    arm : Arm or SpatialArm
        The arm at t = 0 and its limits.
    bodies : tuple of Body
        At least one target, any number of obstacles; all solid when there is a plane or the arm
        is spatial, else all planar.
    plane : Plane, optional
        The arm's plane, present exactly when a planar arm is in a 3D scene.
    """

    name: str
    horizon: float
    arm: ArmKind
    bodies: tuple[Body, ...]
    plane: Plane | None = None

    def __post_init__(self) -> None:
        """Check the fields, then the bodies against each other and against the plane."""
        put(self, "name", text(self.name, "name"))
        put(self, "horizon", positive(self.horizon, "horizon"))
        if not is_arm(self.arm):
            raise SituationError("arm", f"must be an arm (got {show(self.arm)})")
        if self.is_spatial and self.plane is not None:
            raise SituationError("plane", "is for planar arms (the arm is spatial)")
        if self.plane is not None and not isinstance(self.plane, Plane):
            raise SituationError("plane", f"must be a plane (got {show(self.plane)})")
        put(self, "bodies", tuple(sequence(self.bodies, "bodies", "bodies")))
        self._check_bodies()

    def _check_bodies(self) -> None:
        """Refuse duplicate names, bodies of the other dimension and scenes without a target."""
        seen: dict[str, int] = {}
        for k, body in enumerate(self.bodies):
            if not isinstance(body, Body):
                raise SituationError(f"bodies[{k}]", f"must be a body (got {show(body)})")
            if body.name in seen:
                reason = f"{quote(body.name)} is already the name of bodies[{seen[body.name]}]"
                raise SituationError(f"bodies[{k}].name", reason)
            seen[body.name] = k
            self._check_dimension(body, f"bodies[{k}].shape.kind")
            if isinstance(body.motion, Pendulum):
                longest = 2.0 * math.pi * MOST_PERIODS / body.motion.fastest
                if self.horizon > longest:
                    reason = f"{self.horizon:g} s is over {MOST_PERIODS} periods of bodies[{k}]"
                    raise SituationError("horizon", f"{reason} (at most {longest:g})")
        if not self.targets:
            raise SituationError("bodies", f"no target among {len(self.bodies)} bodies")

    def _check_dimension(self, body: Body, field: str) -> None:
        """Refuse a body that does not live in the arm's space."""
        if body.is_solid == (self.is_solid or self.is_spatial):
            return
        if body.is_solid:
            reason = "is 3D, but the situation has no plane"
        else:
            why = "arm is spatial" if self.is_spatial else "situation has a plane"
            reason = f"is planar, but the {why}"
        raise SituationError(field, f"{quote(body.shape.kind)} {reason}")

    @property
    def targets(self) -> tuple[Body, ...]:
        """The bodies to be caught."""
        return tuple(body for body in self.bodies if body.role == "target")

    @property
    def obstacles(self) -> tuple[Body, ...]:
        """The bodies not to be touched."""
        return tuple(body for body in self.bodies if body.role == "obstacle")

    @property
    def is_solid(self) -> bool:
        """Whether a planar arm is in a 3D scene, in which its hand meets the cuts of solids."""
        return self.plane is not None

    @property
    def is_spatial(self) -> bool:
        """Whether the arm moves in space."""
        return isinstance(self.arm, SpatialArm)


AnySituation = Situation[Arm] | Situation[SpatialArm]


def planar(situation: AnySituation, who: str) -> Situation[Arm]:
    """The situation, if its arm is planar.

    Parameters
    ----------
    situation : Situation
    who : str
        Who asks, for the message, e.g. ``"planner 'gcm'"``.

    Raises
    ------
    ArmKindError
    """
    if isinstance(situation.arm, SpatialArm):
        name = quote(situation.name)
        raise ArmKindError(f"{who} does not take spatial arms (situation {name})")
    return situation


def spatial(situation: AnySituation, who: str) -> Situation[SpatialArm]:
    """The situation, if its arm is spatial; see `planar`.

    Raises
    ------
    ArmKindError
    """
    if isinstance(situation.arm, SpatialArm):
        return situation
    raise ArmKindError(f"{who} takes spatial arms only (situation {quote(situation.name)})")
