"""A ball on a cord that swings past the arm, among other pendulums and boards."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from gcm_learn.families import ranges
from gcm_learn.families.pendulum import ball_on_cord, swing_through
from gcm_learn.families.solids import triple
from gcm_learn.families.space.family import SpaceStory, SpatialFamily, Things, across, aimed, sentry
from gcm_learn.families.space.stage import SpaceStage
from gcm_learn.situation import Body


@dataclass(frozen=True)
class PendulumSpace(SpatialFamily):
    """A target ball on a cord, which is an obstacle; heavy balls on cords swing across the way.

    The hand has to meet the ball from below or beside, with the limb off the cord. The arm has to
    go round the other bodies, or after them.
    """

    name = "pendulum-space"
    summary = "a ball on a cord, which must not be touched, among other pendulums and boards"

    length: ranges.Range = ranges.span(1.5, 5.0, 0.1)
    """From pivot to ball [forearms]."""
    amplitude: ranges.Range = ranges.span(0.2, 0.9, 0.01, 1.5)
    """Largest angle of swings [rad]."""
    phase: ranges.Range = ranges.span(-0.9, 0.9, -0.99, 0.99)
    """Angle at the place of a ball's meeting [amplitudes]."""
    when: ranges.Range = ranges.span(0.5, 0.9, 0.05, 0.95)
    """Time of the meeting [horizons]."""
    cord: ranges.Range = ranges.span(0.01, 0.03, 1e-3)
    """Radius of cords [forearms]."""
    heavy: ranges.Counts = ranges.counts(0, 1)
    """Number of other pendulums."""
    bob: ranges.Range = ranges.span(0.2, 0.45, 1e-3)
    """Radius of their balls [forearms]."""
    sentries: float = ranges.number(0.6)
    """Share of balls whose place is taken by something until shortly before."""
    sentry: ranges.Range = ranges.span(0.3, 0.7, 1e-3)
    """Radius of what takes it [forearms]."""
    leaves: ranges.Range = ranges.span(0.8, 0.98, 0.05, 1.0)
    """Instant at which it is free, as shares of the time until the ball is there."""
    boards: ranges.Counts = ranges.counts(0, 2)
    """Number of bodies at rest across the way."""
    things: Things = field(default_factory=Things)
    share: ranges.Range = ranges.span(0.25, 0.85, most=1.0)
    """Places of obstacles on the way, as shares of it."""

    def story(self, rng: np.random.Generator, stage: SpaceStage) -> SpaceStory:
        """Draw a ball on a cord, other pendulums, and obstacles in the way."""
        way, when = stage.way(rng, self.takes), ranges.pick(rng, self.when) * stage.horizon
        bodies = list(
            self._pair(rng, stage, way.meet, when, ranges.pick(rng, self.target), "target", "")
        )
        for k in range(ranges.pick_count(rng, self.heavy)):
            share, radius = ranges.pick(rng, self.share), ranges.pick(rng, self.bob)
            place, _ = across(rng, stage, way, share)
            bodies += self._pair(rng, stage, place, share * when, radius, "bob", f" {k + 1}")
        if rng.random() < self.sentries:
            gone = ranges.pick(rng, self.leaves) * when
            bodies.append(sentry(rng, stage, way, self.sentry, gone))
        for k in range(ranges.pick_count(rng, self.boards)):
            bodies.append(aimed(rng, stage, way, self.things, self.share, f"{k + 1}", when))
        return SpaceStory(way, when, tuple(bodies))

    def _pair(
        self,
        rng: np.random.Generator,
        stage: SpaceStage,
        place: np.ndarray,
        when: float,
        radius: float,
        name: str,
        number: str,
    ) -> tuple[Body, Body]:
        """Draw a ball that is at a place (3,) at time `when`, and its cord."""
        length, amplitude = ranges.pick(rng, self.length), ranges.pick(rng, self.amplitude)
        angle, heading = ranges.pick(rng, self.phase) * amplitude, ranges.pick_angle(rng)
        stiffness = stage.build.gravity / length
        rate = ranges.pick_sign(rng) * math.sqrt(
            2.0 * stiffness * (math.cos(angle) - math.cos(amplitude))
        )
        along = (math.cos(heading), math.sin(heading), 0.0)
        motion = swing_through(
            triple(place), along, when, stage.build.gravity, length, (angle, rate)
        )
        return ball_on_cord(motion, radius, ranges.pick(rng, self.cord), name, number)
