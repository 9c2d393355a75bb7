"""A resting target among resting balls and bars."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gcm_learn.arms import Arm
from gcm_learn.families.layout import Event
from gcm_learn.families.piece_family import EventFamily, InSpace
from gcm_learn.families.pieces import Piece
from gcm_learn.families.ranges import pick_angle


@dataclass(frozen=True)
class StaticClutter(EventFamily):
    """Bodies at rest; most obstacles stand where the limb's straight way leads."""

    name = "static-clutter"
    summary = "a resting target among resting balls and bars"

    def event(self, rng: np.random.Generator, arm: Arm, horizon: float) -> Event:
        """A ball at rest."""
        return self.ball_at_rest(rng, arm, horizon)

    def obstacle(self, rng: np.random.Generator, arm: Arm, event: Event, k: int) -> Piece:
        """A ball or bar at rest."""
        place, _ = self.aim(rng, arm, event)
        size, angle = self.sizes.any(rng), pick_angle(rng)
        return Piece("obstacle", f"obstacle {k + 1}", size, place, angle=angle)


@dataclass(frozen=True)
class StaticClutterSolid(InSpace, StaticClutter):
    """Resting spheres, posts and leaning bars in a vertical arm plane."""

    name = "static-clutter-solid"
    summary = "a resting ball among resting solids"
