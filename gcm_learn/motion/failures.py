"""Reasons for a missing catch: an enumeration to count, with a sentence for each reason."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from enum import Enum


class Failure(Enum):
    """Reason for a missing catch; the value is a sentence with numbers in braces."""

    START_BLOCKED = "{first} and {second} overlap by {depth} at t = 0"
    OUT_OF_REACH = "no target comes within reach before the horizon"
    NO_INTERCEPTION = "the front meets no target within the horizon"
    NO_ENDING = "no target can be met from where the front made contact"
    NO_STRAIGHT_LINE = "no straight line meets a target in time"
    NO_FIELD_LINE = "the field leads to no target in time"
    NO_TREE = "the trees do not meet in the time that they have"
    NO_MEMORY = "nothing is known"
    NO_VALID_MEMORY = "none of {count} remembered ways holds"
    NO_VALID_ROLLOUT = "none of {count} tried ways catches"
    IMPOSSIBLE = "certainly unreachable: no movement meets a target within the horizon"
    OUT_OF_TIME = "no catch was found by the deadline"
    OUT_OF_WORK = "no catch was found within the limit of work"
    UNDECIDED = "no verified catch was found, though none is ruled out from {since:.3f} s on"
    TOO_SLOW = "not with accelerations up to {limit:g}: {reason}"
    LATE = "the catch at {when:.3f} s comes after the horizon"
    WRONG_START = "the path does not start at the hand"
    OUTSIDE = "the path leaves the reachable ring"
    SINGULAR = "the arm would have to turn round within no time near the shoulder"
    HAND_SPEED = "the hand would have to be faster than max_hand_speed"
    JOINT_SPEED = "a joint would have to be faster than max_joint_speed"
    JOINT_RANGE = "a joint would have to leave its range"
    JOINT_ACCELERATION = "a joint would have to exceed max_joint_acceleration"
    JOINT_JERK = "a joint would have to exceed max_joint_jerk"
    NOT_HELD = "the hand leaves the target before the end of the hold"
    TOO_FAST = "the target is too fast for joint {joint}: {rate} of {most}"
    SLIPS = "the hand is faster than relative_speed allows in the hold"
    TURNS_AWAY = "the hand leaves the approach before the end of the hold"
    MISPLACED = "the target is not carried to its place"
    NO_CARRY = "{target} is held, but no way to its place was found: {reason}"
    NOT_AT_REST = "the arm does not rest at the end"
    ENDS_LATE = "the movement ends at {when:.3f} s, later than it may"
    ACCELERATION_UNTAKEN = "accelerations are limited, which this planner cannot keep"
    END_UNTAKEN = "this planner ends with a touch, and keeps no hold, rest or limits of jerk"
    SEVERAL_UNTAKEN = "all of {count} targets have to be caught, and this planner catches one"
    ASTRAY = "joints that are linear between samples lead the hand astray"
    MISSED = "the hand misses the target"
    NO_TARGET_MET = "no target is met in time"
    COLLISION = "the limb is touched at t = {when:.3f} s"

    def with_numbers(self, **numbers: object) -> Reason:
        """Return the reason with the numbers for its braces."""
        return Reason(self, numbers)

    @classmethod
    def of(cls, message: str) -> Failure | None:
        """Return the failure that a message states; None for the message of a catch."""
        if message == _BLOCKED_BEFORE:
            return cls.START_BLOCKED
        for failure in cls:
            pieces = re.split(r"\{[^}]*\}", failure.value)
            if re.fullmatch(".*".join(map(re.escape, pieces)), message):
                return failure
        return None


_BLOCKED_BEFORE = "the limb touches an obstacle at t = 0"  # in records of earlier versions


@dataclass(frozen=True)
class Reason:
    """A failure with its numbers; `str` gives the sentence."""

    failure: Failure
    numbers: dict[str, object] = field(default_factory=dict)

    def __str__(self) -> str:
        return self.failure.value.format(**self.numbers)
