"""Records of a conversion, and functions that all converters share."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, ClassVar, Protocol

import numpy as np

from gcm_learn.arms import Base, Chain, ChainModel, hands_along, off_segment
from gcm_learn.errors import FileFormatError, GcmError, SituationError
from gcm_learn.motion import Movement, rules_of, start_clearance, verify
from gcm_learn.scene import gap, pack, pose
from gcm_learn.situation import (
    Approach,
    Body,
    Situation,
    SolidQuadratic,
    Sphere,
    read_arm,
    shipped_arm,
)

REST = (0.0, 0.0, 0.0)
UNTURNED = (1.0, 0.0, 0.0, 0.0)
TARGET = 0.01
"""Radius of a target that stands for a goal posture [m]."""
GRASP = 0.01
"""Default distance of hand and target at which it is caught [m]."""
FINGERS = 0.01
"""Largest distance of the hand in its goal posture to the object that it grasps [m]."""
HELD = 0.25
"""Largest bounding radius of an object that a hand grasps, or that a belt carries [m]."""
WITHIN = 0.35
"""Default angle between the hand's axis and that of the goal posture, 20 degrees [rad]."""


@dataclass
class Converted:
    """Result of a conversion: situations, and counts of remarks on the problems."""

    situations: list[Situation[Chain]] = field(default_factory=list)
    counts: dict[str, int] = field(default_factory=dict)
    """Sentence to how many problems it applies to."""

    asked: dict[str, int] = field(default_factory=dict)
    """Sentence to how many problems it might apply to."""
    left_out: list[GcmError] = field(default_factory=list)
    """Reasons of the problems that cannot be taken, in their order."""

    def count(self, sentence: str, applies: bool) -> bool:
        """Count a problem under `sentence` if that applies; return `applies`."""
        self.counts[sentence] = self.counts.get(sentence, 0) + bool(applies)
        self.asked[sentence] = self.asked.get(sentence, 0) + 1
        return applies

    @contextmanager
    def leaving_out(self) -> Iterator[None]:
        """Note the error of a problem that cannot be taken, and go on."""
        try:
            yield
        except (FileFormatError, SituationError) as error:
            self.left_out.append(error)

    def notes(self) -> Iterator[str]:
        """Yield lines such as ``3 of 700: the start is blocked``."""
        for sentence, count in self.counts.items():
            yield f"{count} of {self.asked[sentence]}: {sentence}"
        if self.left_out:
            taken = max([len(self.situations), *self.asked.values()])
            count = len(self.left_out)
            yield f"{count} of {count + taken} left out: {'; '.join(self._reasons())}"

    def _reasons(self) -> Iterator[str]:
        """Yield a reason of each kind with the number of others that differ in numbers only."""
        alike: dict[str, list[str]] = {}
        for error in self.left_out:
            _, _, reason = str(error).partition(": ")
            alike.setdefault(re.sub(r"[-\d.]*\d[\de+-]*", "", reason), []).append(str(error))
        for first, *others in alike.values():
            yield f"{first} (and {len(others)} like it)" if others else first

    def at_least_one(self) -> Converted:
        """Return itself; raise the first reason if every problem was left out."""
        if self.left_out and not self.situations:
            raise self.left_out[0]
        return self


class Converter(Protocol):
    """Record of the settings of a conversion, one class for each suite."""

    summary: ClassVar[str]

    def convert(self, sources: Sequence[Path]) -> Converted:
        """Return the situations of files or folders; problems that cannot be taken are counted."""


def model_named(arm: str) -> ChainModel:
    """Return the arm model in a file named ``*.json``, or the shipped arm of that name.

    Raises
    ------
    FileFormatError, SituationError
    """
    if arm.endswith(".json"):
        return read_arm(arm)
    try:
        return shipped_arm(arm)
    except SituationError as error:
        raise SituationError("arm", error.reason) from None


def resting_target(arm: Chain, goal: Sequence[float], within: float) -> Body:
    """Return a small ball at the place that the hand has in a goal posture.

    Parameters
    ----------
    arm : Chain
    goal : (n,) sequence of float
    within : float
        Largest angle between the hand's axis and its axis in that posture [rad].
    """
    (hand,), (axis,) = hands_along(arm, [goal])
    place = SolidQuadratic(tuple(hand.tolist()), REST, REST)
    approach = Approach(tuple((axis / np.linalg.norm(axis)).tolist()), within)
    return Body("target", "goal", Sphere(TARGET), place, (approach,))


def is_blocked(situation: Situation[Chain]) -> bool:
    """Return whether the arm at t = 0 touches an obstacle or itself."""
    return start_clearance(pack(situation)) <= 0.0


def goal_is_blocked(situation: Situation[Chain], goal: Sequence[float]) -> bool:
    """Return whether a goal posture is out of range, or touches at t = 0."""
    try:
        there = replace(situation.arm, joints=tuple(goal))
    except SituationError:
        return True
    return is_blocked(replace(situation, arm=there))


def stays_free(situation: Situation[Chain]) -> bool:
    """Return whether the resting arm stays free of collisions up to the horizon."""
    arm: Any = situation.arm
    posture = np.array([arm.joints, arm.joints])
    (hand,), _ = hands_along(arm, posture[:1])
    place = SolidQuadratic(tuple(hand.tolist()), REST, REST)
    held = Body("target", situation.targets[0].name, Sphere(TARGET), place)
    resting = replace(situation, bodies=(held, *situation.obstacles), catch="any")
    scene = pack(resting)
    movement = Movement(arm, np.array([0.0, resting.horizon]), posture)
    return verify(scene, rules_of(scene), movement, 0).good


def grasping(situation: Situation[Chain], goal: Sequence[float]) -> Situation[Chain]:
    """Return the situation in which the fingers may touch the object that they grasp.

    An open gripper around an object is a goal of the original problem, but our fingers are one
    capsule, which would be inside the object.  So pairs of the links around the hand's point and
    the object nearest to it in the goal posture are ignored.
    """
    arm = replace(situation.arm, base=Base())
    (hand,), _ = hands_along(arm, [goal])
    scene, near = pack(situation), (FINGERS, "")
    for k, body in enumerate(situation.bodies):
        if body.role == "obstacle" and body.shape.bounding_radius <= HELD:
            centre, turn = pose(situation, k, 0.0)
            away = gap(scene.bodies, k, *(turn.T @ (hand - centre)).tolist())
            near = min(near, (away, body.name))
    if not near[1]:
        return situation
    pairs = tuple((k, near[1]) for k in fingers(arm.model))
    return replace(situation, arm=replace(situation.arm, ignore=(*situation.arm.ignore, *pairs)))


def fingers(model: ChainModel) -> list[int]:
    """Return the links of a model in which the hand's point is."""
    return [
        k
        for k, link in enumerate(model.links)
        if link.joint == model.hand.joint
        and off_segment(np.array([model.hand.point]), link.start, link.end)[0] <= link.radius
    ]
