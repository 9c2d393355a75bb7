"""Targets and obstacles in flight: falling, coming late, spinning."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gcm_learn.arms import Arm
from gcm_learn.families.layout import Event, meeting_time, polar
from gcm_learn.families.piece_family import EventFamily, InSpace
from gcm_learn.families.pieces import PlanarPiece, Vector, ball_through
from gcm_learn.families.ranges import Range, number, pick, pick_angle, pick_sign, span
from gcm_learn.situation import Body, Cylinder, SolidQuadratic

SLOPE = 0.3  # shelves lie at most this far from level [rad]


@dataclass(frozen=True)
class Falling(EventFamily):
    """A ball is thrown up or let go and falls; obstacles fall too, or are shelves that rest.

    Down is the negative y axis of the arm's plane.
    """

    name = "falling"
    summary = "a falling ball to catch among falling balls and bars, and shelves"

    gravity: Range = span(0.15, 0.6)
    """Acceleration of all bodies of a scene [squared hand speeds per forearm]."""
    drift: Range = span(-0.25, 0.25, -100.0)
    """Horizontal speeds [hand speeds]."""
    throw: Range = span(-0.1, 0.5, -100.0)
    """Upward speeds at t = 0 [hand speeds]."""
    wait: Range = span(1.0, 1.8, 1.0)
    """Time of the meeting, in times that the hand needs for the way there."""
    shelves: float = number(0.35)
    """Share of obstacles that are resting bars."""
    spin: Range = span(-1.5, 1.5, -100.0)
    """Of falling bars [hand speeds per forearm]."""

    def event(self, rng: np.random.Generator, arm: Arm, horizon: float) -> Event:
        """A ball in free flight."""
        meet, hand = self.goal(rng, arm, horizon), arm.max_hand_speed
        when = meeting_time(rng, arm, meet, self.wait, horizon)
        size = self.sizes.ball_to_catch(rng)
        pull = (0.0, -pick(rng, self.gravity) * hand * hand)
        target = PlanarPiece("target", "ball", size, meet, when, self._toss(rng, hand), pull)
        return Event(target, meet, when, horizon, pick_sign(rng))

    def obstacle(self, rng: np.random.Generator, arm: Arm, event: Event, k: int) -> PlanarPiece:
        """Something that falls, or a shelf."""
        place, at = self.aim(rng, arm, event)
        if rng.random() < self.shelves:
            lying = SLOPE * (2.0 * rng.random() - 1.0)
            return PlanarPiece(
                "obstacle", f"shelf {k + 1}", self.sizes.bar(rng), place, angle=lying
            )
        size, hand = self.sizes.any(rng), arm.max_hand_speed
        spin, angle, toss = pick(rng, self.spin) * hand, pick_angle(rng), self._toss(rng, hand)
        name, pull = f"{'ball' if len(size) == 1 else 'bar'} {k + 1}", event.target.acceleration
        return PlanarPiece("obstacle", name, size, place, at, toss, pull, angle, spin)

    def _toss(self, rng: np.random.Generator, hand: float) -> Vector:
        """A velocity at t = 0."""
        return pick(rng, self.drift) * hand, pick(rng, self.throw) * hand


@dataclass(frozen=True)
class FallingSolid(InSpace, Falling):
    """Falling solids: the arm's plane is vertical, and falling bodies also come through it."""

    name = "falling-solid"
    summary = "a falling ball among falling solids and shelves, in a vertical plane"


RIM = 0.97  # the hand may wait for the target at this share of its reach


@dataclass(frozen=True)
class LateTarget(EventFamily):
    """A target that flies in from outside; before its entry no hand at any place can catch it.

    At its entry it is one grasp away from the ring's outer rim.
    """

    name = "late-target"
    summary = "a target that comes within reach only after a good part of the horizon"

    entry: Range = span(0.4, 0.75, most=0.95)
    """Instant at which the target comes within reach [horizons]."""
    speed: Range = span(0.2, 0.8, 1e-3)
    """Of the target [hand speeds]."""
    aside: Range = span(-0.7, 0.7, -1.4, 1.4)
    """Angle between the target's course and the way to the shoulder [rad]."""
    moving: float = number(0.7)
    """Share of obstacles that move; the others rest on the way."""
    others: Range = span(0.1, 0.6)
    """Speeds of those that move [hand speeds]."""

    def event(self, rng: np.random.Generator, arm: Arm, horizon: float) -> Event:
        """Draw a ball that at its entry touches, from outside, the disc of places for a catch."""
        entry, size = pick(rng, self.entry) * horizon, self.sizes.ball_to_catch(rng)
        x, y = self.goal(rng, arm, horizon)
        course = math.atan2(y, x)
        place = polar(arm.reach + arm.grasp + size[0], course)
        speed = pick(rng, self.speed) * arm.max_hand_speed
        velocity = polar(speed, course + math.pi + pick(rng, self.aside))
        target = PlanarPiece("target", "target", size, place, entry, velocity)
        return Event(target, polar(RIM * arm.reach, course), entry, horizon, pick_sign(rng))

    def obstacle(self, rng: np.random.Generator, arm: Arm, event: Event, k: int) -> PlanarPiece:
        """A body on the way to where the target comes in."""
        place, at = self.aim(rng, arm, event)
        size, angle, velocity = self.sizes.any(rng), pick_angle(rng), (0.0, 0.0)
        if rng.random() < self.moving:
            velocity = polar(pick(rng, self.others) * arm.max_hand_speed, pick_angle(rng))
        return PlanarPiece("obstacle", f"obstacle {k + 1}", size, place, at, velocity, angle=angle)


@dataclass(frozen=True)
class LateTargetSolid(InSpace, LateTarget):
    """A ball that comes through the arm's plane late, anywhere in the ring that the hand reaches.

    At its entry it touches the plane; before, its cut with the plane is empty.
    """

    name = "late-target-solid"
    summary = "a ball that comes through the arm's plane only after a good part of the horizon"

    approach: Range = span(0.05, 0.3, 1e-3)
    """Speed at which the target comes through the plane [hand speeds]."""

    def event(self, rng: np.random.Generator, arm: Arm, horizon: float) -> Event:
        """Draw a ball that touches the plane at its entry, anywhere in the ring."""
        entry, size = pick(rng, self.entry) * horizon, self.sizes.ball_to_catch(rng)
        meet = self.goal(rng, arm, horizon)
        velocity = polar(pick(rng, self.speed) * arm.max_hand_speed, pick_angle(rng))
        target = PlanarPiece("target", "target", size, meet, entry, velocity)
        return Event(target, meet, entry, horizon, pick_sign(rng))

    def body(self, rng: np.random.Generator, piece: PlanarPiece, arm: Arm) -> Body:
        """Make a piece's body; the target is one radius off the plane at its entry."""
        if piece.role == "obstacle":
            return super().body(rng, piece, arm)
        through = pick_sign(rng) * pick(rng, self.approach) * arm.max_hand_speed
        return ball_through(piece, through, piece.when + piece.size[0] / abs(through))


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

    def obstacle(self, rng: np.random.Generator, arm: Arm, event: Event, k: int) -> PlanarPiece:
        """A bar that has some part of itself on the way when the limb is there."""
        place, at = self.aim(rng, arm, event)
        hand, size, angle = arm.max_hand_speed, self.sizes.bar(rng), pick_angle(rng)
        spin = self._turning(rng, hand)
        bar = PlanarPiece("obstacle", f"bar {k + 1}", size, place, at, angle=angle, spin=spin)
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

    def body(self, rng: np.random.Generator, piece: PlanarPiece, arm: Arm) -> Body:
        """Make a piece's body."""
        body = super().body(rng, piece, arm)
        flies = piece.role == "obstacle" and isinstance(body.motion, SolidQuadratic)
        if not flies or rng.random() >= self.discs:
            return body
        shape = Cylinder(pick(rng, self.disc_radius), pick(rng, self.disc_half_height))
        return Body(body.role, f"disc{piece.name[3:]}", shape, body.motion)
