"""A swarm that crosses the way in one direction, as people cross a street."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gcm_learn.arms import Arm
from gcm_learn.families.layout import Event, polar
from gcm_learn.families.piece_family import EventFamily, InSpace
from gcm_learn.families.pieces import Piece
from gcm_learn.families.ranges import Counts, Range, counts, pick, pick_angle, span


@dataclass(frozen=True)
class CrossingSwarm(EventFamily):
    """Balls and bars with nearly the same heading, spread over the way and over time.

    The common heading is at right angles to the straight way, give or take `spread`.
    """

    name = "crossing-swarm"
    summary = "a stream of bodies across the limb's way, the target moving too"

    obstacles: Counts = counts(2, 5)
    """Number of obstacles."""
    speed: Range = span(0.15, 0.6)
    """Of the swarm [hand speeds]."""
    spread: Range = span(-0.5, 0.5, -3.15)
    """Headings of the swarm's members about their common one [rad]."""
    delay: Range = span(-0.2, 0.2, -1.0, 1.0)
    """Of members against the limb on its straight way [horizons]."""
    spin: Range = span(-1.5, 1.5, -100.0)
    """Of bars [hand speeds per forearm]."""
    target_speed: Range = span(0.0, 0.3)
    """[hand speeds]"""
    wait: Range = span(1.0, 1.8, 1.0)
    """Time of the meeting, in times that the hand needs for the way there."""

    def event(self, rng: np.random.Generator, arm: Arm, horizon: float) -> Event:
        """A ball that moves in any direction."""
        return self.moving_ball(rng, arm, horizon, self.target_speed, self.wait)

    def obstacle(self, rng: np.random.Generator, arm: Arm, event: Event, k: int) -> Piece:
        """A member of the swarm."""
        place, at = self.aim(rng, arm, event)
        (x, y), (mx, my), hand = arm.hand, event.meet, arm.max_hand_speed
        across = math.atan2(my - y, mx - x) + event.side * math.pi / 2
        heading = across + pick(rng, self.spread)
        velocity = polar(pick(rng, self.speed) * hand, heading)
        when = max(at + pick(rng, self.delay) * event.horizon, 0.0)
        size, angle, spin = self.sizes.any(rng), pick_angle(rng), pick(rng, self.spin) * hand
        name = f"member {k + 1}"
        return Piece("obstacle", name, size, place, when, velocity, (0.0, 0.0), angle, spin)


@dataclass(frozen=True)
class CrossingSwarmSolid(InSpace, CrossingSwarm):
    """Swarms of solids that also come through the plane."""

    name = "crossing-swarm-solid"
    summary = "a stream of solids across the limb's way and through the plane"
