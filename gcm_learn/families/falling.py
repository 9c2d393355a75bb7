"""The paper's Fig. 5, varied: balls and bars that fall, past shelves, under one gravity."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gcm_learn.arms import Arm
from gcm_learn.families.layout import Event, meeting_time
from gcm_learn.families.piece_family import EventFamily, InSpace
from gcm_learn.families.pieces import Piece, Vector
from gcm_learn.families.ranges import Range, number, pick, pick_angle, pick_sign, span

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
        target = Piece("target", "ball", size, meet, when, self._toss(rng, hand), pull)
        return Event(target, meet, when, horizon, pick_sign(rng))

    def obstacle(self, rng: np.random.Generator, arm: Arm, event: Event, k: int) -> Piece:
        """Something that falls, or a shelf."""
        place, at = self.aim(rng, arm, event)
        if rng.random() < self.shelves:
            lying = SLOPE * (2.0 * rng.random() - 1.0)
            return Piece("obstacle", f"shelf {k + 1}", self.sizes.bar(rng), place, angle=lying)
        size, hand = self.sizes.any(rng), arm.max_hand_speed
        spin, angle, toss = pick(rng, self.spin) * hand, pick_angle(rng), self._toss(rng, hand)
        name, pull = f"{'ball' if len(size) == 1 else 'bar'} {k + 1}", event.target.acceleration
        return Piece("obstacle", name, size, place, at, toss, pull, angle, spin)

    def _toss(self, rng: np.random.Generator, hand: float) -> Vector:
        """A velocity at t = 0."""
        return pick(rng, self.drift) * hand, pick(rng, self.throw) * hand


@dataclass(frozen=True)
class FallingSolid(InSpace, Falling):
    """Falling solids: the arm's plane is vertical, and what falls also comes through it."""

    name = "falling-solid"
    summary = "a falling ball among falling solids and shelves, in a vertical plane"
