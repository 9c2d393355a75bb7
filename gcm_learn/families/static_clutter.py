"""A resting target among resting balls and bars."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gcm_learn.families.layout import Event, anywhere, on_the_way
from gcm_learn.families.piece_family import EventFamily, InSpace
from gcm_learn.families.pieces import Piece
from gcm_learn.families.ranges import Range, number, pick_angle, span
from gcm_learn.situation import Arm


@dataclass(frozen=True)
class StaticClutter(EventFamily):
    """Nothing moves; most obstacles stand where the straight way would lead the limb."""

    name = "static-clutter"
    summary = "a resting target among resting balls and bars"

    in_the_way: float = number(0.7)
    """Share of obstacles on the limb's straight way; the others stand anywhere within reach."""
    share: Range = span(0.2, 0.8, most=1.0)
    """Where on the straight way those stand, as shares of it."""

    def event(self, rng: np.random.Generator, arm: Arm, horizon: float) -> Event:
        """A ball at rest."""
        return self.ball_at_rest(rng, arm, horizon)

    def obstacle(self, rng: np.random.Generator, arm: Arm, event: Event, k: int) -> Piece:
        """A ball or bar at rest."""
        if rng.random() < self.in_the_way:
            place, _ = on_the_way(rng, arm, event, self.share)
        else:
            place = anywhere(rng, arm)
        size, angle = self.sizes.any(rng), pick_angle(rng)
        return Piece("obstacle", f"obstacle {k + 1}", size, place, angle=angle)


@dataclass(frozen=True)
class StaticClutterSolid(InSpace, StaticClutter):
    """The same with spheres, posts and leaning bars in a vertical arm plane."""

    name = "static-clutter-solid"
    summary = "a resting ball among resting solids"
