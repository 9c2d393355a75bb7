"""A situation: one arm, and the bodies around it with all their future motion."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Generic

from gcm_learn import arms, checks
from gcm_learn.errors import ArmKindError, SituationError
from gcm_learn.situation.asked import (
    check_asked,
    check_start,
    newer_of_arm,
    with_jerk_of_model,
    without_jerk,
)
from gcm_learn.situation.body import Body
from gcm_learn.situation.laws import CATCHES, ENDS, FORMATS
from gcm_learn.situation.motion import MOST_PERIODS, Pendulum

_CALLED = arms.ByKind(
    {arms.PLANAR: "planar", arms.SPATIAL: "spatial", arms.CHAIN: "a chain"},
    default="of another kind",
)


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
        checks.put(self, "origin", checks.vector(self.origin, "origin", 3))
        checks.put(self, "x", checks.unit_vector(self.x, "x"))
        checks.put(self, "y", checks.unit_vector(self.y, "y"))
        checks.orthogonal(self.x, self.y, "y", "x")

    @property
    def normal(self) -> tuple[float, float, float]:
        """Third axis of arm-plane coordinates, ``x cross y``."""
        (a, b, c), (d, e, f) = self.x, self.y
        return (b * f - c * e, c * d - a * f, a * e - b * d)


if TYPE_CHECKING:
    from typing_extensions import TypeVar  # a default makes a plain `Situation` one of the plane

    ArmKind = TypeVar("ArmKind", bound=arms.Arm | arms.Chain, default=arms.Arm, covariant=True)
else:
    from typing import TypeVar

    ArmKind = TypeVar("ArmKind")


@dataclass(frozen=True)
class Situation(Generic[ArmKind]):
    """Input of a planner: the arm, the bodies and the rules.

    In annotations, `Situation` has a planar arm, ``Situation[SpatialArm]`` one in space, and
    `AnySituation` either.

    Parameters
    ----------
    name : str
        Any string; unique within a file.
    horizon : float
        Last moment at which a catch counts, above zero [s].
    arm : Arm, SpatialArm or Chain
        The arm at t = 0 and its limits.
    bodies : tuple of Body
        At least one target, any number of obstacles; all solid when there is a plane or the arm
        is not planar, else all planar.
    plane : Plane, optional
        The arm's plane, present exactly when a planar arm is in a 3D scene.
    catch : {"any", "all", "most"}
        Targets to be caught: one of them, every one, or as many as possible.  Only
        ``gcm-learn/situation@3`` and ``@4`` have more than "any".
    format : str, optional
        Version of the exchange format.  By default the first one of the arm's kind, or ``@4`` where
        one of its fields is used.  A model's limits of jerk alone do not ask for ``@4``, without
        which they do not count.
    end : {"free", "rest"}
        Motion of the arm at the end: any, or none.
    end_by : float, optional
        Time at which the whole movement has ended, not negative; any time when absent [s].
    """

    name: str
    horizon: float
    arm: ArmKind
    bodies: tuple[Body, ...]
    plane: Plane | None = None
    catch: str = "any"
    format: str = ""
    end: str = "free"
    end_by: float | None = None

    def __post_init__(self) -> None:
        """Check the fields, then the bodies against each other, the format and the arm."""
        checks.put(self, "name", checks.text(self.name, "name"))
        checks.put(self, "horizon", checks.positive(self.horizon, "horizon"))
        if not arms.is_arm(self.arm):
            raise SituationError("arm", f"must be an arm (got {checks.show(self.arm)})")
        checks.put(self, "end", checks.choice(self.end, "end", ENDS))
        if self.end_by is not None:
            checks.put(self, "end_by", checks.non_negative(self.end_by, "end_by"))
        checks.put(self, "bodies", tuple(checks.sequence(self.bodies, "bodies", "bodies")))
        self._check_format()
        if self.plane is not None and not isinstance(self.arm, arms.Arm):
            raise SituationError("plane", f"is for planar arms (the arm is {_CALLED.of(self)})")
        if self.plane is not None and not isinstance(self.plane, Plane):
            raise SituationError("plane", f"must be a plane (got {checks.show(self.plane)})")
        self._check_bodies()
        check_start(self.arm, self.bodies, self.format)
        check_asked(self.arm, self.bodies, self.end)

    def _check_format(self) -> None:
        """Fill in the format, and refuse a format without such an arm, catch or fields."""
        kind, newer = arms.kind_of(self.arm), tuple(self._newer())
        if not self.format:
            checks.put(self, "format", kind.formats[-1 if newer else 0])
        checks.put(self, "format", checks.choice(self.format, "format", kind.formats))
        catches = FORMATS[self.format].catches
        if self.catch in CATCHES and self.catch not in catches:
            raise SituationError(
                "catch", f"{checks.quote(self.catch)} is not known to {self.format}"
            )
        checks.put(self, "catch", checks.choice(self.catch, "catch", catches))
        if FORMATS[self.format].holds:
            return
        for field in newer:
            raise SituationError(field, f"is not known to {self.format}")
        checks.put(self, "arm", without_jerk(self.arm))

    def _newer(self) -> Iterator[str]:
        """Yield the fields in use that ``gcm-learn/situation@4`` adds."""
        if self.end != ENDS[0]:
            yield "end"
        if self.end_by is not None:
            yield "end_by"
        yield from newer_of_arm(self.arm)
        for k, body in enumerate(self.bodies):
            yield from (f"bodies[{k}].{name}" for name in getattr(body, "newer", ()))

    def _check_bodies(self) -> None:
        """Refuse duplicate names, bodies of the other dimension and scenes without a target."""
        seen: dict[str, int] = {}
        for k, body in enumerate(self.bodies):
            if not isinstance(body, Body):
                raise SituationError(f"bodies[{k}]", f"must be a body (got {checks.show(body)})")
            if body.name in seen:
                reason = (
                    f"{checks.quote(body.name)} is already the name of bodies[{seen[body.name]}]"
                )
                raise SituationError(f"bodies[{k}].name", reason)
            seen[body.name] = k
            self._check_dimension(body, f"bodies[{k}].shape.kind")
            self._check_known(body, f"bodies[{k}]")
            if isinstance(body.motion, Pendulum):
                longest = 2.0 * math.pi * MOST_PERIODS / body.motion.fastest
                if self.horizon > longest:
                    reason = f"{self.horizon:g} s is over {MOST_PERIODS} periods of bodies[{k}]"
                    raise SituationError("horizon", f"{reason} (at most {longest:g})")
        if not self.targets:
            raise SituationError("bodies", f"no target among {len(self.bodies)} bodies")

    def _check_dimension(self, body: Body, field: str) -> None:
        """Refuse a body that does not live in the arm's space."""
        planar_arm = isinstance(self.arm, arms.Arm)
        if body.is_solid == (self.is_solid or not planar_arm):
            return
        if body.is_solid:
            reason = "is 3D, but the situation has no plane"
        else:
            why = "situation has a plane" if planar_arm else f"arm is {_CALLED.of(self)}"
            reason = f"is planar, but the {why}"
        raise SituationError(field, f"{checks.quote(body.shape.kind)} {reason}")

    def _check_known(self, body: Body, field: str) -> None:
        """Refuse motions and approaches that the format does not have."""
        known = FORMATS[self.format]
        if not isinstance(body.motion, known.motions):
            reason = f"{checks.quote(body.motion.kind)} is not known to {self.format}"
            raise SituationError(f"{field}.motion.kind", reason)
        if body.approach and not known.approach:
            raise SituationError(f"{field}.approach", f"is not known to {self.format}")

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
        """True if a planar arm is in a 3D scene, where the hand meets plane sections of solids."""
        return self.plane is not None

    @property
    def is_spatial(self) -> bool:
        """True if the arm moves in space."""
        return isinstance(self.arm, arms.SpatialArm)


AnySituation = Situation[arms.Arm] | Situation[arms.Chain]


def planar(situation: AnySituation, who: str) -> Situation[arms.Arm]:
    """Return the situation if its arm is planar, else raise an error.

    Parameters
    ----------
    situation : Situation
    who : str
        Who asks, for the message, e.g. ``"planner 'gcm'"``.

    Raises
    ------
    ArmKindError
    """
    if isinstance(situation.arm, arms.Arm):
        return situation
    name, plural = checks.quote(situation.name), arms.kind_of(situation).plural
    raise ArmKindError(f"{who} does not take {plural} (situation {name})")


def with_end(situation: Situation[Any], end: str) -> Situation[Any]:
    """Return the situation with another end, in the newest format of its arm.

    Limits of jerk count there wherever the arm has them.

    Parameters
    ----------
    situation : Situation
    end : {"free", "rest"}

    Raises
    ------
    SituationError
        If the arm is to rest, but has no limits of acceleration; the situation is named.
    """
    arm, newest = situation.arm, arms.kind_of(situation).formats[-1]
    if situation.format != newest and arms.kind_of(arm) is arms.CHAIN:
        arm = with_jerk_of_model(arm)
    try:
        return replace(situation, arm=arm, end=end, format=newest)
    except SituationError as error:
        name = checks.quote(situation.name)
        raise SituationError(error.field, f"{error.reason} (situation {name})") from None
