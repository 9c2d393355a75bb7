"""The chain: any number of revolute and prismatic joints that carry capsules."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, ClassVar

from gcm_learn.arms.followers import Follows, JointTree
from gcm_learn.arms.rotations import unit_quaternion
from gcm_learn.arms.spatial import IDENTITY, Base
from gcm_learn.arms.starts import Start, started
from gcm_learn.checks import (
    UNIT_LENGTH,
    choice,
    in_ranges,
    non_negative,
    normalised,
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

JOINT_TYPES = ("revolute", "prismatic")
FROM_MODEL = "model"
"""Default of a chain's limits of acceleration and jerk: those that the model gives."""
RATES = Start("rates", "max_acceleration", "fast")
ACCELERATIONS = Start("accelerations", "max_jerk", "large")


@dataclass(frozen=True)
class ChainJoint:
    """A joint of a chain: frame k = frame p * T(origin) * R(rotation) * motion of q_k.

    Parameters
    ----------
    axis : (3,) tuple of float
        Unit vector about which the joint turns (`revolute`) or along which it moves
        (`prismatic`); normalised.
    range : (2,) tuple of float
        Lowest and highest value, both allowed [rad or lengths].
    max_speed : float
        Above zero [rad/s or lengths/s].
    type : {"revolute", "prismatic"}
    origin : (3,) tuple of float
        Place in frame p.
    rotation : (4,) tuple of float
        Unit quaternion (w, x, y, z); normalised.
    max_acceleration : float, optional
        Above zero [rad/s^2 or lengths/s^2]; no limit when absent.
    name : str
    parent : int, optional
        Number p of the frame that carries the joint, 0 for the base; k - 1 when absent.
    follows : Follows, optional
        Leader by which the joint is moved; it has a coordinate of its own when absent.
    max_jerk : float, optional
        Above zero, and only beside `max_acceleration` [rad/s^3 or lengths/s^3].
    """

    axis: tuple[float, float, float]
    range: tuple[float, float]
    max_speed: float
    type: str = "revolute"
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    rotation: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    max_acceleration: float | None = None
    name: str = ""
    parent: int | None = None
    follows: Follows | None = None
    max_jerk: float | None = None

    def __post_init__(self) -> None:
        """Check the documented ranges and normalise axis and rotation."""
        put(self, "type", choice(self.type, "type", JOINT_TYPES))
        put(self, "origin", vector(self.origin, "origin", 3))
        put(self, "rotation", unit_quaternion(self.rotation, "rotation", UNIT_LENGTH))
        put(self, "axis", normalised(self.axis, "axis"))
        low, high = vector(self.range, "range", 2)
        if low > high:
            raise SituationError("range", f"low {low} is above high {high}")
        put(self, "range", (low, high))
        put(self, "max_speed", positive(self.max_speed, "max_speed"))
        if self.max_acceleration is not None:
            put(self, "max_acceleration", positive(self.max_acceleration, "max_acceleration"))
        put(self, "name", text(self.name, "name"))
        if self.max_jerk is not None:
            put(self, "max_jerk", positive(self.max_jerk, "max_jerk"))
        if self.parent is not None:
            put(self, "parent", whole(self.parent, "parent"))
        if self.follows is not None and not isinstance(self.follows, Follows):
            raise SituationError("follows", f"must be a leader (got {show(self.follows)})")


@dataclass(frozen=True)
class Link:
    """A capsule that a joint's frame carries; a sphere where both ends are equal.

    Parameters
    ----------
    joint : int
        Number of the joint, from 1; 0 is the base.
    start, end : (3,) tuple of float
        Ends of the capsule's axis, `from` and `to` in files, in the joint's frame.
    radius : float
        Above zero.
    name : str, optional
        Several links may share one; absent in ``gcm-learn/arm@1``.
    """

    joint: int
    start: tuple[float, float, float]
    end: tuple[float, float, float]
    radius: float
    name: str | None = None

    def __post_init__(self) -> None:
        """Check the documented ranges."""
        put(self, "joint", whole(self.joint, "joint"))
        put(self, "start", vector(self.start, "from", 3))
        put(self, "end", vector(self.end, "to", 3))
        put(self, "radius", positive(self.radius, "radius"))
        if self.name is not None:
            put(self, "name", text(self.name, "name"))


@dataclass(frozen=True)
class Hand:
    """The point that catches and the direction in which it reaches.

    Parameters
    ----------
    joint : int
        Number of the joint whose frame carries the hand, from 1.
    point : (3,) tuple of float
        Place in that frame.
    axis : (3,) tuple of float
        Unit vector in that frame; normalised.
    """

    joint: int
    point: tuple[float, float, float]
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)

    def __post_init__(self) -> None:
        """Check the documented ranges and normalise the axis."""
        put(self, "joint", whole(self.joint, "joint"))
        put(self, "point", vector(self.point, "point", 3))
        put(self, "axis", normalised(self.axis, "axis"))


@dataclass(frozen=True)
class ChainModel(JointTree):
    """An arm as the exchange formats ``gcm-learn/arm@1`` and ``@2`` describe it.

    Parameters
    ----------
    name : str
    joints : tuple of ChainJoint
        From the base outwards, at least one; all that have a coordinate have `max_acceleration`, or
        none of them has.
    links : tuple of Link
        At least one.
    hand : Hand
    self_collision : tuple of (int, int)
        Pairs of links that must not overlap.
    source : str
        Origin of the numbers.
    """

    name: str
    joints: tuple[ChainJoint, ...]
    links: tuple[Link, ...]
    hand: Hand
    self_collision: tuple[tuple[int, int], ...] = ()
    source: str = ""

    def __post_init__(self) -> None:
        """Check the records against each other."""
        for name in ("name", "source"):
            put(self, name, text(getattr(self, name), name))
        for name, record in (("joints", ChainJoint), ("links", Link)):
            put(self, name, _records(getattr(self, name), name, record))
        if not isinstance(self.hand, Hand):
            raise SituationError("hand", f"must be a hand (got {show(self.hand)})")
        self.check_tree()
        plain = [replace(j, parent=None) if j.parent == k else j for k, j in enumerate(self.joints)]
        put(self, "joints", tuple(plain))
        self.check_limits("max_acceleration")
        self.check_limits("max_jerk")
        for k, link in enumerate(self.links):
            if not 0 <= link.joint <= len(self.joints):
                raise SituationError(f"links[{k}].joint", self._no_joint(link.joint, 0))
        if not 1 <= self.hand.joint <= len(self.joints):
            raise SituationError("hand.joint", self._no_joint(self.hand.joint, 1))
        put(self, "self_collision", self._pairs())

    def _no_joint(self, given: int, least: int) -> str:
        return f"must be from {least} to {len(self.joints)} (got {given})"

    def _pairs(self) -> tuple[tuple[int, int], ...]:
        result = []
        for k, given in enumerate(sequence(self.self_collision, "self_collision", "pairs")):
            field = f"self_collision[{k}]"
            pair = [whole(item, field) for item in sequence(given, field, "2 links")]
            if len(pair) != 2:
                raise SituationError(field, f"must be a list of 2 links (got {len(pair)})")
            for item in pair:
                if not 0 <= item < len(self.links):
                    raise SituationError(field, _no_link(item, len(self.links)))
            if pair[0] == pair[1]:
                raise SituationError(field, f"is a pair of link {pair[0]} with itself")
            result.append((pair[0], pair[1]))
        return tuple(result)

    def named(self, link: int) -> str:
        """Return what messages call a link."""
        name = self.links[link].name or f"link {link}"
        return name if name.isprintable() else repr(name)


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
        """Return the limits (n,) of accelerations or jerk, with those of followers."""
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
                raise SituationError(field, _no_link(link, count))
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
        """(n, 2) Ends of each coordinate, its followers' ranges kept; the start is in between."""
        both = zip(self.model.ranges, self.joints, strict=True)
        return tuple((min(low, q), max(high, q)) for (low, high), q in both)

    @property
    def max_joint_speed(self) -> tuple[float, ...]:
        """(n,) Limits of the coordinates' rates, with which followers keep their own."""
        own = [joint.max_speed for joint in self.model.coordinates]
        return self.model.limits(own, "max_speed")

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


def _records(value: object, field: str, record: type[Any]) -> tuple[Any, ...]:
    """Return a tuple of at least one record of a type."""
    items = tuple(sequence(value, field, f"{record.__name__} records"))
    if not items:
        raise SituationError(field, "must not be empty")
    for k, item in enumerate(items):
        if not isinstance(item, record):
            raise SituationError(f"{field}[{k}]", f"must be a {record.__name__} (got {show(item)})")
    return items


def _no_link(given: int, count: int) -> str:
    return f"{given} is no link (there are {count}, from 0)"


def unknown_obstacle(name: str) -> str:
    """Return the sentence on an ignored obstacle that is not in the situation."""
    return f"{quote(name)} is not the name of an obstacle"
