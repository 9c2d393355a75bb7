"""The paper's Fig. 4, varied: points that cross the way to a resting or slow target."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gcm_learn.arms import Arm
from gcm_learn.families.layout import Event, polar
from gcm_learn.families.piece_family import EventFamily, InSpace
from gcm_learn.families.pieces import Piece
from gcm_learn.families.ranges import Range, number, pick, pick_angle, span


@dataclass(frozen=True)
class MovingPoint(EventFamily):
    """Points small enough to be all edge: where they pass, the limb must have gone or must wait."""

    name = "moving-point"
    summary = "points that cross the limb's way to a resting or slow target"

    point: Range = span(0.01, 0.03, 1e-3)
    """Radius of the points [forearms]."""
    speed: Range = span(0.1, 0.9)
    """Of the points [hand speeds]."""
    still: float = number(0.5)
    """Share of targets that rest."""
    target_speed: Range = span(0.05, 0.3)
    """Of the other targets [hand speeds]."""
    wait: Range = span(1.0, 1.8, 1.0)
    """Time of the meeting, in times that the hand needs for the way there."""

    def event(self, rng: np.random.Generator, arm: Arm, horizon: float) -> Event:
        """A ball that rests or is slow."""
        if rng.random() < self.still:
            return self.ball_at_rest(rng, arm, horizon)
        return self.moving_ball(rng, arm, horizon, self.target_speed, self.wait)

    def obstacle(self, rng: np.random.Generator, arm: Arm, event: Event, k: int) -> Piece:
        """A point."""
        place, at = self.aim(rng, arm, event)
        velocity = polar(pick(rng, self.speed) * arm.max_hand_speed, pick_angle(rng))
        size = (pick(rng, self.point),)
        return Piece("obstacle", f"point {k + 1}", size, place, at, velocity)


@dataclass(frozen=True)
class MovingPointSolid(InSpace, MovingPoint):
    """Small spheres and thin posts that come through the plane."""

    name = "moving-point-solid"
    summary = "points and thin posts that come through the plane on the limb's way"
