"""The paper's Fig. 6, varied: a spinning bar to catch, spinning bars and discs to avoid."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gcm_learn.arms import Arm
from gcm_learn.families.layout import Event, polar
from gcm_learn.families.piece_family import EventFamily, InSpace
from gcm_learn.families.pieces import Piece
from gcm_learn.families.ranges import Range, number, pick, pick_angle, pick_sign, span
from gcm_learn.situation import Body, Cylinder, SolidQuadratic


@dataclass(frozen=True)
class Spinning(EventFamily):
    """Bars that turn about their middle while they fly, or about a hinge at their end."""

    name = "spinning"
    summary = "a spinning bar to catch among bars that spin about their middle or a hinge"

    spin: Range = span(0.5, 2.5)
    """Angular speeds, to either side [hand speeds per forearm]."""
    speed: Range = span(0.0, 0.4)
    """Of bars that fly [hand speeds]."""
    wait: Range = span(1.0, 1.8, 1.0)
    """Time of the meeting, in times that the hand needs for the way there."""
    hinged: float = number(0.5)
    """Share of obstacles that turn about a hinge at their end."""
    target_half_length: Range = span(0.1, 0.3, 1e-3)
    """Of the bar to catch [forearms]."""

    def event(self, rng: np.random.Generator, arm: Arm, horizon: float) -> Event:
        """A bar to catch."""
        ball = self.moving_ball(rng, arm, horizon, self.speed, self.wait)
        size = (pick(rng, self.target_half_length), pick(rng, self.sizes.half_width))
        spin = self._turning(rng, arm.max_hand_speed)
        target = ball.target._replace(name="bar", size=size, angle=pick_angle(rng), spin=spin)
        return ball._replace(target=target)

    def obstacle(self, rng: np.random.Generator, arm: Arm, event: Event, k: int) -> Piece:
        """A bar that has some part of itself on the way when the limb is there."""
        place, at = self.aim(rng, arm, event)
        hand, size, angle = arm.max_hand_speed, self.sizes.bar(rng), pick_angle(rng)
        spin = self._turning(rng, hand)
        bar = Piece("obstacle", f"bar {k + 1}", size, place, at, angle=angle, spin=spin)
        if rng.random() >= self.hinged:
            return bar._replace(velocity=polar(pick(rng, self.speed) * hand, pick_angle(rng)))
        x, y = polar(2.0 * size[0] * rng.random(), angle)
        return bar._replace(place=(place[0] - x, place[1] - y), offset=size[0])

    def _turning(self, rng: np.random.Generator, hand: float) -> float:
        """An angular velocity."""
        return pick_sign(rng) * pick(rng, self.spin) * hand


@dataclass(frozen=True)
class SpinningSolid(InSpace, Spinning):
    """Spinning solids, with flat discs that tumble through the plane in place of some bars."""

    name = "spinning-solid"
    summary = "a spinning bar to catch among spinning bars and tumbling discs in space"

    discs: float = number(0.5)
    """Share of discs among the obstacles that fly."""
    disc_radius: Range = span(0.2, 0.45, 1e-3)
    """[forearms]"""
    disc_half_height: Range = span(0.02, 0.05, 1e-3)
    """[forearms]"""

    def body(self, rng: np.random.Generator, piece: Piece, arm: Arm) -> Body:
        """Make a piece's body."""
        body = super().body(rng, piece, arm)
        flies = piece.role == "obstacle" and isinstance(body.motion, SolidQuadratic)
        if not flies or rng.random() >= self.discs:
            return body
        shape = Cylinder(pick(rng, self.disc_radius), pick(rng, self.disc_half_height))
        return Body(body.role, f"disc{piece.name[3:]}", shape, body.motion)
