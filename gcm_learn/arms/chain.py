"""The chain: any number of revolute and prismatic joints that carry capsules."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any, ClassVar, NamedTuple

from gcm_learn.arms.chain_model import ChainModel, no_link
from gcm_learn.arms.rotations import IDENTITY, Base
from gcm_learn.checks import (
    in_ranges,
    non_negative,
    positive,
    positive_vector,
    put,
    quote,
    sequence,
    show,
    text,
    vector,
    whole,
)
from gcm_learn.errors import SituationError

FROM_MODEL = "model"
"""Default of a chain's limits of acceleration and jerk: those that the model gives."""


class Start(NamedTuple):
    """Names in messages about rates or accelerations at t = 0, and the word for excess."""

    field: str
    needs: str
    """Field of the limits without which it must not be given."""
    excess: str


def started(
    given: object, start: Start, most: Sequence[float] | None, limits: Sequence[float] | None
) -> tuple[float, ...] | None:
    """Return rates or accelerations (n,) at t = 0, zero by default; `limits` of None give None.

    Parameters
    ----------
    given : object
    start : Start
    most : (n,) sequence of float, optional
        Largest sizes; there are some wherever there are limits.
    limits : (n,) sequence of float, optional
        Limits of the next derivative, `needs`.
    """
    if given is None:
        return None if limits is None else (0.0,) * len(limits)
    if limits is None or most is None:
        raise SituationError(start.field, f"are given without {start.needs}")
    values = vector(given, start.field, len(most))
    for k, (value, limit) in enumerate(zip(values, most, strict=True)):
        if abs(value) > limit:
            reason = f"{value} is too {start.excess} (max {limit})"
            raise SituationError(f"{start.field}[{k}]", reason)
    return values


RATES = Start("rates", "max_acceleration", "fast")
ACCELERATIONS = Start("accelerations", "max_jerk", "large")


@dataclass(frozen=True)
class Chain:
    """A chain at t = 0.

    Parameters
    ----------
    model : ChainModel
    joints : (n,) tuple of float
        Posture q at t = 0, a number for each coordinate, within the joints' ranges; `posture` in
        files [rad or lengths].
    grasp : float
        Signed distance of hand and target at which it is caught, not negative.
    base : Base
        Pose of frame 0 in the world.
    joint_rates : (n,) tuple of float, optional
        Rates at t = 0, `rates` in files; only with limits of acceleration, and zero there when
        absent.
    max_hand_speed : float, optional
        Above zero [lengths/s]; no limit when absent.
    max_joint_acceleration : (n,) tuple of float, optional
        Above zero, `max_acceleration` in files; the model's by default, None for no limits. Lowered
        to what followers' own limits ask for.
    ignore : tuple of (int or str, str)
        Pairs of a link and the name of an obstacle that are not checked. A link is given by its
        number, or by a name, which stands for all links of that name.
    max_joint_jerk : (n,) tuple of float, optional
        Above zero, `max_jerk` in files, and only with limits of acceleration; the model's by
        default, None for no limits. Situations of ``@3`` have none, and drop the model's.
    joint_accelerations : (n,) tuple of float, optional
        Accelerations at t = 0, `accelerations` in files; only with limits of jerk, and zero there
        when absent.
    """

    model: ChainModel
    joints: tuple[float, ...]
    grasp: float
    base: Base = IDENTITY
    joint_rates: tuple[float, ...] | None = None
    max_hand_speed: float | None = None
    max_joint_acceleration: Any = FROM_MODEL
    ignore: tuple[tuple[int | str, str], ...] = ()
    max_joint_jerk: Any = FROM_MODEL
    joint_accelerations: tuple[float, ...] | None = None

    kind: ClassVar[str] = "chain"
    thickness: ClassVar[float] = 0.0  # links have radii of their own

    def __post_init__(self) -> None:
        """Check the documented ranges, then posture and rates against the model."""
        if not isinstance(self.model, ChainModel):
            raise SituationError("model", f"must be a chain's model (got {show(self.model)})")
        if not isinstance(self.base, Base):
            raise SituationError("base", f"must be a base (got {show(self.base)})")
        put(self, "joints", vector(self.joints, "posture", self.model.dof))
        put(self, "grasp", non_negative(self.grasp, "grasp"))
        if self.max_hand_speed is not None:
            put(self, "max_hand_speed", positive(self.max_hand_speed, "max_hand_speed"))
        put(self, "max_joint_acceleration", self._limits("acceleration"))
        put(self, "max_joint_jerk", self._limits("jerk"))
        ranges = [joint.range for joint in self.model.coordinates]
        put(self, "joints", in_ranges(self.joints, ranges, "posture"))
        self.model.check_start(self.joints)
        most, jerks = self.max_joint_acceleration, self.max_joint_jerk
        put(self, "joint_rates", started(self.joint_rates, RATES, self.max_joint_speed, most))
        now = self.joint_accelerations
        put(self, "joint_accelerations", started(now, ACCELERATIONS, most, jerks))
        put(self, "ignore", self._ignore())

    def _limits(self, of: str) -> tuple[float, ...] | None:
        """Return the limits (n,) of accelerations or jerk, lowered where followers need it."""
        given, field = getattr(self, f"max_joint_{of}"), f"max_{of}"
        lifted = of == "jerk" and self.max_joint_acceleration is None
        if isinstance(given, str) and given == FROM_MODEL:
            given = tuple(getattr(joint, field) for joint in self.model.coordinates)
            given = None if lifted or given[0] is None else given
        if given is None:
            return None
        limits = positive_vector(given, field, self.dof)
        if lifted:
            raise SituationError(field, "is given without max_acceleration")
        return self.model.limits(limits, field)

    def _ignore(self) -> tuple[tuple[int | str, str], ...]:
        result: list[tuple[int | str, str]] = []
        for k, given in enumerate(sequence(self.ignore, "ignore", "pairs")):
            field = f"ignore[{k}]"
            pair = sequence(given, field, "a link and an obstacle")
            if len(pair) != 2:
                raise SituationError(field, f"must be a link and an obstacle (got {len(pair)})")
            link = pair[0] if isinstance(pair[0], str) else whole(pair[0], field)
            count = len(self.model.links)
            if isinstance(link, int) and not 0 <= link < count:
                raise SituationError(field, no_link(link, count))
            if isinstance(link, str) and all(link != known.name for known in self.model.links):
                raise SituationError(field, f"{quote(link)} is not the name of a link")
            result.append((link, text(pair[1], field)))
        return tuple(result)

    @property
    def ignored(self) -> tuple[tuple[int, str], ...]:
        """Pairs of `ignore` with links by their numbers."""
        return tuple(
            (i, name)
            for link, name in self.ignore
            for i, known in enumerate(self.model.links)
            if link in (i, known.name)
        )

    @property
    def dof(self) -> int:
        """Number of joints."""
        return self.model.dof

    @property
    def hand_axis(self) -> tuple[float, float, float]:
        """Unit vector along which the hand reaches, in the frame of its joint."""
        return self.model.hand.axis

    @cached_property
    def joint_range(self) -> tuple[tuple[float, float], ...]:
        """(n, 2) Range of each coordinate that keeps followers in range, widened to the start."""
        both = zip(self.model.ranges, self.joints, strict=True)
        return tuple((min(low, q), max(high, q)) for (low, high), q in both)

    @cached_property
    def max_joint_speed(self) -> tuple[float, ...]:
        """(n,) Limits of the coordinates' rates, with which followers keep their own."""
        own = [joint.max_speed for joint in self.model.coordinates]
        return self.model.limits(own, "max_speed")

    def with_model(self, model: ChainModel) -> Chain:
        """Return a chain of another model at the same posture."""
        same = {field.name: getattr(self, field.name) for field in fields(Chain)}
        return Chain(**same | {"model": model})

    def thicker(self, width: float) -> Chain:
        """Return the arm with links that are thicker by a width."""
        links = tuple(replace(link, radius=link.radius + width) for link in self.model.links)
        return self.with_model(replace(self.model, links=links))

    def slower(self, share: float) -> Chain:
        """Return the arm with the speed limits of hand and joints multiplied by `share`."""
        speed = None if self.max_hand_speed is None else share * self.max_hand_speed
        joints = [replace(joint, max_speed=share * joint.max_speed) for joint in self.model.joints]
        slow = self.with_model(replace(self.model, joints=tuple(joints)))
        return replace(slow, max_hand_speed=speed)

    def without_pairs(self) -> Chain:
        """Return the arm with links that may overlap each other."""
        return self.with_model(replace(self.model, self_collision=()))

    def farthest(self, k: int) -> float:
        """Return the largest size of the value of joint k (from 0)."""
        line = self.model.lines[k]
        ends = self.joint_range[line.coordinate]
        return max(abs(line.factor * end + line.offset) for end in ends)

    @property
    def reach(self) -> float:
        """Bound of the distance between the base's origin and the hand."""
        reach = math.hypot(*self.model.hand.point)
        for k in self.model.path(self.model.hand.joint):
            joint = self.model.joints[k]
            reach += math.hypot(*joint.origin)
            if joint.type == "prismatic":
                reach += self.farthest(k)
        return reach
