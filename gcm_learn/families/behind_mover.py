"""A target that a mover hides: whatever the target does, the mover stays in between."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gcm_learn.arms import Arm
from gcm_learn.families import ranges
from gcm_learn.families.layout import Event, polar
from gcm_learn.families.piece_family import EventFamily, InSpace
from gcm_learn.families.pieces import Piece


@dataclass(frozen=True)
class BehindMover(EventFamily):
    """The mover is on the line from the hand's start to the target at every moment.

    Its speed is the target's times its share of the distance, so it covers the target all the
    time.  The hand has to come from behind or from the side.
    """

    name = "behind-mover"
    summary = "a moving target that a mover covers from the hand at every moment"

    obstacles: ranges.Counts = ranges.counts(1, 3, 1)
    """Number of obstacles, the covering mover included."""
    speed: ranges.Range = ranges.span(0.05, 0.4)
    """Of the target [hand speeds]."""
    wait: ranges.Range = ranges.span(1.0, 1.8, 1.0)
    """Time of the meeting, in times that the hand needs for the way there."""
    cover: ranges.Range = ranges.span(0.5, 0.85, 0.05, 0.95)
    """Place of the mover on the line from the hand's start to the target, as a share of it."""
    half_length: ranges.Range = ranges.span(0.2, 0.45, 1e-3)
    """Half the width of its shade where it is a bar, its radius is half of that [forearms]."""
    bar: float = ranges.number(0.6)
    """Share of covers that are bars across the line; the others are balls."""
    others: ranges.Range = ranges.span(0.1, 0.8)
    """Speeds of the other obstacles [hand speeds]."""

    def event(self, rng: np.random.Generator, arm: Arm, horizon: float) -> Event:
        """A ball that moves in any direction."""
        return self.moving_ball(rng, arm, horizon, self.speed, self.wait)

    def obstacle(self, rng: np.random.Generator, arm: Arm, event: Event, k: int) -> Piece:
        """First the cover, then bodies that move across the way."""
        if k == 0:
            return self._cover(rng, arm, event)
        place, at = self.aim(rng, arm, event)
        velocity = polar(ranges.pick(rng, self.others) * arm.max_hand_speed, ranges.pick_angle(rng))
        size, angle = self.sizes.any(rng), ranges.pick_angle(rng)
        return Piece("obstacle", f"obstacle {k}", size, place, at, velocity, angle=angle)

    def _cover(self, rng: np.random.Generator, arm: Arm, event: Event) -> Piece:
        """The mover between the hand's start and the target."""
        s, half = ranges.pick(rng, self.cover), ranges.pick(rng, self.half_length)
        (x, y), (mx, my), (vx, vy) = arm.hand, event.meet, event.target.velocity
        place, velocity = (x + s * (mx - x), y + s * (my - y)), (s * vx, s * vy)
        size: tuple[float, ...] = (0.5 * half,)
        if rng.random() < self.bar:
            size = (half, ranges.pick(rng, self.sizes.half_width))
        across = math.atan2(my - y, mx - x) + math.pi / 2
        return Piece("obstacle", "cover", size, place, event.when, velocity, angle=across)


@dataclass(frozen=True)
class BehindMoverSolid(InSpace, BehindMover):
    """Solid targets and movers; a cover that comes through the plane covers for a while only."""

    name = "behind-mover-solid"
    summary = "a ball in space that a solid covers while both come through the plane"
