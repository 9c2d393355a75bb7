"""Models of chains: joints, the capsules that they carry, and the hand."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from gcm_learn.arms.followers import Follows, JointTree
from gcm_learn.arms.rotations import unit_quaternion
from gcm_learn.checks import (
    UNIT_LENGTH,
    choice,
    normalised,
    positive,
    put,
    sequence,
    show,
    text,
    vector,
    whole,
)
from gcm_learn.errors import SituationError

JOINT_TYPES = ("revolute", "prismatic")


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
        put(self, "radius", self._radius())
        if self.name is not None:
            put(self, "name", text(self.name, "name"))

    def _radius(self) -> float:
        return positive(self.radius, "radius")


@dataclass(frozen=True)
class Hand:
    """Hand of an arm: its catching point, and the direction in which it reaches.

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
                    raise SituationError(field, no_link(item, len(self.links)))
            if pair[0] == pair[1]:
                raise SituationError(field, f"is a pair of link {pair[0]} with itself")
            result.append((pair[0], pair[1]))
        return tuple(result)

    def named(self, link: int) -> str:
        """Return the name of a link in messages."""
        name = self.links[link].name or f"link {link}"
        return name if name.isprintable() else repr(name)


def _records(value: object, field: str, record: type[Any]) -> tuple[Any, ...]:
    """Return `value` as a tuple of at least one record, all of type `record`."""
    items = tuple(sequence(value, field, f"{record.__name__} records"))
    if not items:
        raise SituationError(field, "must not be empty")
    for k, item in enumerate(items):
        if not isinstance(item, record):
            raise SituationError(f"{field}[{k}]", f"must be a {record.__name__} (got {show(item)})")
    return items


def no_link(given: int, count: int) -> str:
    """Return the sentence on the number of a link that there is not."""
    return f"{given} is no link (there are {count}, from 0)"
