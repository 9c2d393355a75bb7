"""Several balls that fly by, to be caught in one movement."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from gcm_learn.arms import SPATIAL, SpatialArm
from gcm_learn.families.ranges import Counts, Range, counts, pick, pick_count, span
from gcm_learn.families.space.family import SpatialFamily, Story, Things, aimed
from gcm_learn.families.space.solids import unit_vector
from gcm_learn.families.space.stage import Stage, Way
from gcm_learn.situation import Body, Situation


@dataclass(frozen=True)
class SequenceSpace(SpatialFamily):
    """Several balls fly by among boards, bars and balls at rest; as many as possible are wanted.

    It asks for an order: each ball is within reach for its own time, and each way takes time.
    """

    name = "sequence-space"
    summary = "three to five balls that fly by, as many as possible to be caught in one movement"
    several = True

    targets: Counts = counts(3, 5, 1)
    """Number of balls."""
    when: Range = span(0.15, 0.9, 0.05, 0.95)
    """Times at which they are at places that the hand can reach [horizons]."""
    speed: Range = span(0.2, 1.2)
    """Of the balls [forearms/s]."""
    obstacles: Counts = counts(2, 4)
    """Number of obstacles, which rest across the way to the first ball."""
    things: Things = field(default_factory=Things)
    share: Range = span(0.25, 0.8, most=1.0)
    """Places on that way at which they stand, as shares of it."""

    def story(self, rng: np.random.Generator, stage: Stage) -> Story:
        """All balls, each with a place of its own to be caught, and what stands in the way."""
        way = stage.way(rng, self.takes)
        bodies = [self._passing(rng, stage, way, way.takes)]
        for k in range(1, pick_count(rng, self.targets)):
            when = pick(rng, self.when) * stage.horizon
            other = self._passing(rng, stage, stage.way(rng, self.takes), when)
            bodies.append(replace(other, name=f"target {k + 1}"))
        for k in range(pick_count(rng, self.obstacles)):
            bodies.append(aimed(rng, stage, way, self.things, self.share, f"{k + 1}", way.takes))
        return Story(way, way.takes, tuple(bodies))

    def sketch(self, rng: np.random.Generator, name: str) -> Situation[SpatialArm]:
        """Draw once, the limb free or not; most of the balls are wanted."""
        drawn = super().sketch(rng, name)
        catch = "most" if len(drawn.targets) > 1 else "any"
        return replace(drawn, catch=catch, format=SPATIAL.formats[-1])

    def _passing(self, rng: np.random.Generator, stage: Stage, way: Way, when: float) -> Body:
        """A ball at the end of a way at a time, in steady flight."""
        velocity = pick(rng, self.speed) * unit_vector(rng.normal(size=3))
        return self.ball(rng, way.meet, when, velocity)
