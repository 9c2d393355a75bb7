"""A target that comes within reach late: the hand must be there then, and not before."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gcm_learn.arms import Arm
from gcm_learn.families.layout import Event, polar
from gcm_learn.families.piece_family import EventFamily, InSpace
from gcm_learn.families.pieces import Piece, ball_through
from gcm_learn.families.ranges import Range, number, pick, pick_angle, pick_sign, span
from gcm_learn.situation import Body

RIM = 0.97  # the hand may wait for the target at this share of its reach


@dataclass(frozen=True)
class LateTarget(EventFamily):
    """The target flies in from outside; before its entry no hand, wherever it is, can catch it.

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
        """A ball that touches the disc of what the hand can catch at its entry, from outside."""
        entry, size = pick(rng, self.entry) * horizon, self.sizes.ball_to_catch(rng)
        x, y = self.goal(rng, arm, horizon)
        course = math.atan2(y, x)
        place = polar(arm.reach + arm.grasp + size[0], course)
        speed = pick(rng, self.speed) * arm.max_hand_speed
        velocity = polar(speed, course + math.pi + pick(rng, self.aside))
        target = Piece("target", "target", size, place, entry, velocity)
        return Event(target, polar(RIM * arm.reach, course), entry, horizon, pick_sign(rng))

    def obstacle(self, rng: np.random.Generator, arm: Arm, event: Event, k: int) -> Piece:
        """A body on the way to where the target comes in."""
        place, at = self.aim(rng, arm, event)
        size, angle, velocity = self.sizes.any(rng), pick_angle(rng), (0.0, 0.0)
        if rng.random() < self.moving:
            velocity = polar(pick(rng, self.others) * arm.max_hand_speed, pick_angle(rng))
        return Piece("obstacle", f"obstacle {k + 1}", size, place, at, velocity, angle=angle)


@dataclass(frozen=True)
class LateTargetSolid(InSpace, LateTarget):
    """In space the target may appear anywhere: it comes through the plane late.

    At its entry it touches the plane; before, its cut with the plane is empty.
    """

    name = "late-target-solid"
    summary = "a ball that comes through the arm's plane only after a good part of the horizon"

    approach: Range = span(0.05, 0.3, 1e-3)
    """Speed at which the target comes through the plane [hand speeds]."""

    def event(self, rng: np.random.Generator, arm: Arm, horizon: float) -> Event:
        """A ball that touches the plane at its entry, anywhere in the ring."""
        entry, size = pick(rng, self.entry) * horizon, self.sizes.ball_to_catch(rng)
        meet = self.goal(rng, arm, horizon)
        velocity = polar(pick(rng, self.speed) * arm.max_hand_speed, pick_angle(rng))
        target = Piece("target", "target", size, meet, entry, velocity)
        return Event(target, meet, entry, horizon, pick_sign(rng))

    def body(self, rng: np.random.Generator, piece: Piece, arm: Arm) -> Body:
        """Make a piece's body; the target is one radius off the plane at its entry."""
        if piece.role == "obstacle":
            return super().body(rng, piece, arm)
        through = pick_sign(rng) * pick(rng, self.approach) * arm.max_hand_speed
        return ball_through(piece, through, piece.when + piece.size[0] / abs(through))
