"""A ball on a cord that swings past the arm, among other balls on cords and boxes."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gcm_learn.families import ranges
from gcm_learn.families.chain.family import ChainFamily, Story, aimed, on_the_way
from gcm_learn.families.chain.stage import Stage, Way
from gcm_learn.families.pendulum import ball_on_cord, swing_through
from gcm_learn.families.solids import axes_along, solid, triple
from gcm_learn.situation import Body, Box, Pendulum, Sphere


@dataclass(frozen=True)
class PendulumChain(ChainFamily):
    """The target swings on a cord; heavier balls swing through the way, and boxes stand in it."""

    name = "pendulum-chain"
    summary = "a ball on a cord, among heavier balls on cords and boxes at rest"

    length: ranges.Range = ranges.span(0.2, 0.65, 0.01)
    """From pivot to ball [reaches]."""
    amplitude: ranges.Range = ranges.span(0.2, 0.9, 0.01, 1.5)
    """Largest angle of swings [rad]."""
    phase: ranges.Range = ranges.span(-0.9, 0.9, -0.99, 0.99)
    """Angle at the place of a ball's meeting [amplitudes]."""
    cords: float = ranges.number(0.4)
    """Share of targets whose cord must not be touched."""
    cord: ranges.Range = ranges.span(0.004, 0.008, 1e-4)
    """Radius of cords [reaches]."""
    heavy: ranges.Counts = ranges.counts(1, 3)
    """Number of other balls."""
    bob: ranges.Range = ranges.span(0.045, 0.09, 1e-3)
    """Radius of these [reaches]."""
    boxes: ranges.Counts = ranges.counts(1, 2)
    """Number of boxes at rest."""
    box: ranges.Range = ranges.span(0.04, 0.12, 1e-3)
    """Half their sides [reaches]."""

    def story(self, rng: np.random.Generator, stage: Stage) -> Story:
        """A ball on a cord, other balls, boxes."""
        way = self.way(rng, stage)
        swing = self._swing(rng, stage, way.meet, way.when)
        ball, cord = ball_on_cord(
            swing, stage.size(rng, self.target), stage.size(rng, self.cord), "target"
        )
        bodies = [ball, cord] if rng.random() < self.cords else [ball]
        bodies += aimed(rng, stage, way, self._box, ranges.pick_count(rng, self.boxes))
        bodies += aimed(rng, stage, way, self._bob, ranges.pick_count(rng, self.heavy))
        return Story(way, tuple(bodies))

    def _swing(
        self, rng: np.random.Generator, stage: Stage, place: np.ndarray, when: float
    ) -> Pendulum:
        """The swing of a body that is at a place (3,) at a time [s]."""
        length, amplitude = stage.size(rng, self.length), ranges.pick(rng, self.amplitude)
        angle, heading = ranges.pick(rng, self.phase) * amplitude, ranges.pick_angle(rng)
        stiffness = stage.gravity / length
        rate = ranges.pick_sign(rng) * math.sqrt(
            2.0 * stiffness * (math.cos(angle) - math.cos(amplitude))
        )
        along = (math.cos(heading), math.sin(heading), 0.0)
        return swing_through(triple(place), along, when, stage.gravity, length, (angle, rate))

    def _bob(self, rng: np.random.Generator, stage: Stage, way: Way, k: int) -> Body:
        place, when = on_the_way(rng, stage, way)
        swing = self._swing(rng, stage, place, when)
        return Body("obstacle", f"bob {k + 1}", Sphere(stage.size(rng, self.bob)), swing)

    def _box(self, rng: np.random.Generator, stage: Stage, way: Way, k: int) -> Body:
        place, _ = on_the_way(rng, stage, way)
        x, y, z = (stage.size(rng, self.box) for _ in range(3))
        angle = ranges.pick_angle(rng)
        axes = axes_along((0.0, 0.0, 1.0), (math.cos(angle), math.sin(angle), 0.0))
        return solid(f"box {k + 1}", Box((x, y, z)), place, axes)
