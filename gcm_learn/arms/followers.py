"""Trees of joints, and joints that follow others by a line."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from gcm_learn.checks import number, put, quote, whole
from gcm_learn.errors import SituationError

HAIR = 1e-6
"""By which a follower may be outside its range at t = 0, times the larger of 1 and the bound."""


@dataclass(frozen=True)
class Follows:
    """Leader of a follower joint, whose value is factor q + offset at the leader's value q.

    Parameters
    ----------
    joint : int
        Number of the leader, from 1; it comes before its follower and follows nothing.
    factor, offset : float
        Of the line [rad or lengths, per rad or length of the leader].
    """

    joint: int
    factor: float
    offset: float = 0.0

    def __post_init__(self) -> None:
        """Check the documented ranges."""
        put(self, "joint", whole(self.joint, "joint"))
        put(self, "factor", number(self.factor, "factor"))
        put(self, "offset", number(self.offset, "offset"))


class Line(NamedTuple):
    """Value of a joint by a coordinate: factor q + offset."""

    coordinate: int
    """Index of the coordinate, from 0."""
    factor: float = 1.0
    offset: float = 0.0
    leads: bool = True
    """True for the joint that has the coordinate."""


class JointTree:
    """Tree of joints: each stands on an earlier frame, and some follow another joint by a line.

    Indices of joints count from 0 here, and frame k + 1 is that of joint k.
    """

    joints: tuple[Any, ...]

    def check_tree(self) -> None:
        """Refuse joints whose parent or leader does not come before them."""
        for k, joint in enumerate(self.joints):
            if joint.parent is not None and not 0 <= joint.parent <= k:
                reason = f"must be from 0 to {k}, a frame before the joint's (got {joint.parent})"
                raise SituationError(f"joints[{k}].parent", reason)
            leader, field = getattr(joint.follows, "joint", 1), f"joints[{k}].follows.joint"
            if joint.follows is not None and not 1 <= leader <= k:
                known = f"from 1 to {k}, a joint before it" if k else "a joint before it"
                raise SituationError(field, f"must be {known} (got {leader})")
            if joint.follows is not None and self.joints[leader - 1].follows is not None:
                reason = f"is a joint that follows another itself (got {leader})"
                raise SituationError(field, reason)

    def check_limits(self, field: str) -> None:
        """Refuse a limit that only some of the joints with a coordinate have."""
        limits = {k: getattr(j, field) for k, j in enumerate(self.joints) if j.follows is None}
        without = [k for k, limit in limits.items() if limit is None]
        if 0 < len(without) < len(limits):
            has = next(k for k in limits if k not in without)
            reason = f"is missing, but joints[{has}] has one: all have it or none"
            raise SituationError(f"joints[{without[0]}].{field}", reason)
        if field == "max_jerk" and not without and self.coordinates[0].max_acceleration is None:
            raise SituationError("joints[0].max_jerk", "is given without max_acceleration")

    def check_start(self, posture: Sequence[float]) -> None:
        """Refuse a posture (n,) that puts a follower outside its own range."""
        for k, (joint, line) in enumerate(zip(self.joints, self.lines, strict=True)):
            value = line.factor * posture[line.coordinate] + line.offset
            low, high = joint.range
            hairs = [HAIR * max(1.0, abs(end)) for end in joint.range]
            if not line.leads and not low - hairs[0] <= value <= high + hairs[1]:
                name = f"joints[{k}]" + (f" ({quote(joint.name)})" if joint.name else "")
                reason = f"puts its follower {name} at {value:.9g}, outside [{low}, {high}]"
                raise SituationError(f"posture[{line.coordinate}]", reason)

    @cached_property
    def coordinates(self) -> tuple[Any, ...]:
        """(n,) Joints that follow no other."""
        return tuple(joint for joint in self.joints if joint.follows is None)

    @property
    def dof(self) -> int:
        """Number n of coordinates."""
        return len(self.coordinates)

    @cached_property
    def serial(self) -> bool:
        """True if every joint has a coordinate and stands on the joint before it."""
        return all(joint.parent is None and joint.follows is None for joint in self.joints)

    @cached_property
    def lines(self) -> tuple[Line, ...]:
        """(m,) Values of the joints by the coordinates."""
        lines: list[Line] = []
        for joint in self.joints:
            if joint.follows is None:
                lines.append(Line(sum(known.leads for known in lines)))
            else:
                leader = lines[joint.follows.joint - 1].coordinate
                lines.append(Line(leader, joint.follows.factor, joint.follows.offset, False))
        return tuple(lines)

    @cached_property
    def factors(self) -> np.ndarray:
        """(m, n) Derivative of the joints' values by the coordinates."""
        factors = np.zeros((len(self.joints), self.dof))
        for k, line in enumerate(self.lines):
            factors[k, line.coordinate] = line.factor
        return factors

    def values(self, coordinates: np.ndarray) -> np.ndarray:
        """Return the joints' values (..., m) at coordinates (..., n)."""
        values: np.ndarray = coordinates @ self.factors.T + [line.offset for line in self.lines]
        return values

    def parent(self, k: int) -> int:
        """Return the number of the frame on which joint k stands."""
        given = self.joints[k].parent
        return k if given is None else int(given)

    def path(self, frame: int) -> tuple[int, ...]:
        """Return the joints that move a frame, from the base outwards."""
        return (*self.path(self.parent(frame - 1)), frame - 1) if frame > 0 else ()

    @cached_property
    def _bound(self) -> tuple[tuple[Any, Line], ...]:
        """Followers that move, and their lines."""
        both = zip(self.joints, self.lines, strict=True)
        return tuple((j, line) for j, line in both if not line.leads and line.factor != 0.0)

    @cached_property
    def ranges(self) -> tuple[tuple[float, float], ...]:
        """(n, 2) Ends of the coordinates between which followers are in their ranges, too."""
        ranges = [joint.range for joint in self.coordinates]
        for joint, line in self._bound:
            ends = sorted((end - line.offset) / line.factor for end in joint.range)
            low, high = ranges[line.coordinate]
            ranges[line.coordinate] = (max(low, ends[0]), min(high, ends[1]))
        return tuple(ranges)

    def limits(self, own: Sequence[float], field: str) -> tuple[float, ...]:
        """Return limits (n,) of coordinates: `own`, lowered where limits of followers need it."""
        limits = list(own)
        for joint, line in self._bound:
            limit = getattr(joint, field)
            if limit is not None:
                limits[line.coordinate] = min(limits[line.coordinate], limit / abs(line.factor))
        return tuple(limits)
