"""Families made of balls and bars, each in the plane and, as a sibling, in space."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

from gcm_learn.arms import Arm
from gcm_learn.families import layout
from gcm_learn.families.family import TINY, PlanarFamily
from gcm_learn.families.pieces import (
    UPRIGHT,
    PlanarPiece,
    SpaceRanges,
    Vector,
    planar_body,
    solid_body,
)
from gcm_learn.families.ranges import (
    Range,
    Ranges,
    number,
    pick,
    pick_angle,
    pick_count,
    pick_sign,
    span,
)
from gcm_learn.situation import Body, Plane, Situation


@dataclass(frozen=True)
class Sizes(Ranges):
    """Sizes of balls and bars [forearms]."""

    target: Range = span(0.04, 0.12, TINY)
    """Radius of the target."""
    radius: Range = span(0.06, 0.2, TINY)
    """Radius of an obstacle that is a ball."""
    half_length: Range = span(0.15, 0.45, TINY)
    """Half the length of a bar."""
    half_width: Range = span(0.02, 0.08, TINY)
    """Half the width of a bar."""
    bars: float = number(0.5)
    """Share of bars among the obstacles, where a family leaves the choice."""

    def ball_to_catch(self, rng: np.random.Generator) -> tuple[float, ...]:
        """Size of a target."""
        return (pick(rng, self.target),)

    def ball(self, rng: np.random.Generator) -> tuple[float, ...]:
        """Size of a ball in the way."""
        return (pick(rng, self.radius),)

    def bar(self, rng: np.random.Generator) -> tuple[float, ...]:
        """Size of a bar in the way."""
        return pick(rng, self.half_length), pick(rng, self.half_width)

    def any(self, rng: np.random.Generator) -> tuple[float, ...]:
        """Size of a ball or of a bar."""
        return self.bar(rng) if rng.random() < self.bars else self.ball(rng)


@dataclass(frozen=True)
class PieceFamily(PlanarFamily):
    """Base of families whose bodies are balls and bars."""

    plane: ClassVar[Plane | None] = None

    sizes: Sizes = field(default_factory=Sizes)
    """Of what has no range of its own."""

    def sketch(self, rng: np.random.Generator, name: str) -> Situation:
        """Draw once, the limb free or not."""
        arm, horizon = self.arm.draw(rng)
        bodies = tuple(self.body(rng, piece, arm) for piece in self.pieces(rng, arm, horizon))
        return Situation(name, horizon, arm, bodies, self.plane)

    @abstractmethod
    def pieces(self, rng: np.random.Generator, arm: Arm, horizon: float) -> tuple[PlanarPiece, ...]:
        """The target, then the obstacles, in the arm's plane."""

    @abstractmethod
    def obstacle(
        self, rng: np.random.Generator, arm: Arm, event: layout.Event, k: int
    ) -> PlanarPiece:
        """Obstacle number k, counted from 0."""

    def fitting(
        self, rng: np.random.Generator, arm: Arm, event: layout.Event, count: int
    ) -> tuple[PlanarPiece, ...]:
        """Draw obstacles that leave the limb free at its start and at the meeting."""
        pieces = []
        for k in range(count):
            for _ in range(layout.TRIES):
                piece = self.obstacle(rng, arm, event, k)
                if layout.leaves_room(piece, arm, event):
                    break
            pieces.append(piece)
        return tuple(pieces)

    def body(self, rng: np.random.Generator, piece: PlanarPiece, arm: Arm) -> Body:
        """Make a piece's body."""
        return planar_body(piece)


@dataclass(frozen=True)
class EventFamily(PieceFamily):
    """Base of families that aim obstacles at the straight way to where the target may be met."""

    way: layout.WayRanges = field(default_factory=layout.WayRanges)
    aimed: float = number(0.5)
    """Share of obstacles that are aimed at the limb's straight way; the others pass anywhere within
    reach at any time. The more are aimed, the fewer targets can be caught at all."""
    share: Range = span(0.2, 0.9, most=1.0)
    """Places of aimed obstacles on the straight way, as shares of it."""
    inside: float = number(0.15)
    """Share of places nearer to the shoulder than the elbow; see `layout.on_the_way`."""

    def pieces(self, rng: np.random.Generator, arm: Arm, horizon: float) -> tuple[PlanarPiece, ...]:
        """The target, then the obstacles, in the arm's plane."""
        event = self.event(rng, arm, horizon)
        return event.target, *self.fitting(rng, arm, event, pick_count(rng, self.obstacles))

    @abstractmethod
    def event(self, rng: np.random.Generator, arm: Arm, horizon: float) -> layout.Event:
        """Draw the target, and a place and time for the hand to meet it."""

    def goal(self, rng: np.random.Generator, arm: Arm, horizon: float) -> Vector:
        """Draw a place at which the hand may meet the target."""
        return self.way.end(rng, arm, horizon, self.arm.radii(arm.upper_arm))

    def aim(self, rng: np.random.Generator, arm: Arm, event: layout.Event) -> tuple[Vector, float]:
        """Draw the place where an obstacle is to be, and when [s]."""
        if rng.random() < self.aimed:
            return layout.on_the_way(rng, arm, event, self.share, self.inside)
        return layout.anywhere(rng, arm, self.inside), event.horizon * rng.random()

    def ball_at_rest(self, rng: np.random.Generator, arm: Arm, horizon: float) -> layout.Event:
        """A resting target, met as early as can be."""
        meet = self.goal(rng, arm, horizon)
        target = PlanarPiece("target", "target", self.sizes.ball_to_catch(rng), meet)
        return layout.Event(target, meet, layout.way_time(arm, meet), horizon, pick_sign(rng))

    def moving_ball(
        self, rng: np.random.Generator, arm: Arm, horizon: float, speed: Range, wait: Range
    ) -> layout.Event:
        """A target that flies in any direction at a speed from a range [hand speeds]."""
        meet = self.goal(rng, arm, horizon)
        when = layout.meeting_time(rng, arm, meet, wait, horizon)
        velocity = layout.polar(pick(rng, speed) * arm.max_hand_speed, pick_angle(rng))
        target = PlanarPiece(
            "target", "target", self.sizes.ball_to_catch(rng), meet, when, velocity
        )
        return layout.Event(target, meet, when, horizon, pick_sign(rng))


@dataclass(frozen=True)
class InSpace:
    """Makes the 3D sibling of a family of pieces; the first base of a class."""

    plane: ClassVar[Plane | None] = UPRIGHT

    space: SpaceRanges = field(default_factory=SpaceRanges)

    def body(self, rng: np.random.Generator, piece: PlanarPiece, arm: Arm) -> Body:
        """Make a piece's body."""
        return solid_body(rng, piece, self.space, arm.max_hand_speed)
