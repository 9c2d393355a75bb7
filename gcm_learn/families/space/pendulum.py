"""A ball on a cord that swings past the arm, among other pendulums and boards."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from gcm_learn.families.pendulum import swing_through
from gcm_learn.families.ranges import (
    Counts,
    Range,
    counts,
    number,
    pick,
    pick_angle,
    pick_count,
    pick_sign,
    span,
)
from gcm_learn.families.space.family import SpatialFamily, Story, Things, across, aimed, sentry
from gcm_learn.families.space.solids import triple
from gcm_learn.families.space.stage import Stage
from gcm_learn.situation import Body, Capsule, Pendulum, Sphere


@dataclass(frozen=True)
class PendulumSpace(SpatialFamily):
    """The ball is the target, its cord an obstacle; heavy balls on cords swing across the way.

    It asks for a hand that meets the ball from below or beside, with the limb off the cord. It
    also asks for a way round the other bodies, or after them.
    """

    name = "pendulum-space"
    summary = "a ball on a cord, which must not be touched, among other pendulums and boards"

    length: Range = span(1.5, 5.0, 0.1)
    """From pivot to ball [forearms]."""
    amplitude: Range = span(0.2, 0.9, 0.01, 1.5)
    """Largest angle of swings [rad]."""
    phase: Range = span(-0.9, 0.9, -0.99, 0.99)
    """Angle at the place of a ball's meeting [amplitudes]."""
    when: Range = span(0.5, 0.9, 0.05, 0.95)
    """Time of the meeting [horizons]."""
    cord: Range = span(0.01, 0.03, 1e-3)
    """Radius of cords [forearms]."""
    heavy: Counts = counts(0, 1)
    """Number of other pendulums."""
    bob: Range = span(0.2, 0.45, 1e-3)
    """Radius of their balls [forearms]."""
    sentries: float = number(0.6)
    """Share of balls whose place is taken by something until shortly before."""
    sentry: Range = span(0.3, 0.7, 1e-3)
    """Radius of what takes it [forearms]."""
    leaves: Range = span(0.8, 0.98, 0.05, 1.0)
    """Instant at which it is free, as shares of the time until the ball is there."""
    boards: Counts = counts(0, 2)
    """Number of bodies at rest across the way."""
    things: Things = field(default_factory=Things)
    share: Range = span(0.25, 0.85, most=1.0)
    """Places of obstacles on the way, as shares of it."""

    def story(self, rng: np.random.Generator, stage: Stage) -> Story:
        """A ball on a cord, other pendulums, what is in the way."""
        way, when = stage.way(rng, self.takes), pick(rng, self.when) * stage.horizon
        bodies = list(self._pair(rng, stage, way.meet, when, pick(rng, self.target), "target", ""))
        for k in range(pick_count(rng, self.heavy)):
            share, radius = pick(rng, self.share), pick(rng, self.bob)
            place, _ = across(rng, stage, way, share)
            bodies += self._pair(rng, stage, place, share * when, radius, "bob", f" {k + 1}")
        if rng.random() < self.sentries:
            gone = pick(rng, self.leaves) * when
            bodies.append(sentry(rng, stage, way, self.sentry, gone))
        for k in range(pick_count(rng, self.boards)):
            bodies.append(aimed(rng, stage, way, self.things, self.share, f"{k + 1}", when))
        return Story(way, when, tuple(bodies))

    def _pair(
        self,
        rng: np.random.Generator,
        stage: Stage,
        place: np.ndarray,
        when: float,
        radius: float,
        name: str,
        number: str,
    ) -> tuple[Body, Body]:
        """A ball that is at a place (3,) at a time, and its cord."""
        length, amplitude = pick(rng, self.length), pick(rng, self.amplitude)
        angle, heading = pick(rng, self.phase) * amplitude, pick_angle(rng)
        stiffness = stage.build.gravity / length
        rate = pick_sign(rng) * math.sqrt(2.0 * stiffness * (math.cos(angle) - math.cos(amplitude)))
        along = (math.cos(heading), math.sin(heading), 0.0)
        motion = swing_through(
            triple(place), along, when, stage.build.gravity, length, (angle, rate)
        )
        return ball_on_cord(motion, radius, pick(rng, self.cord), name, number)


def ball_on_cord(
    motion: Pendulum, radius: float, thin: float, name: str, number: str = ""
) -> tuple[Body, Body]:
    """A ball, the target if that is its name, and the cord down to it."""
    free = motion.length - radius
    role = "target" if name == "target" else "obstacle"
    return (
        Body(role, f"{name}{number}", Sphere(radius), motion),
        Body(
            "obstacle",
            f"cord{number}",
            Capsule(thin, 0.5 * free),
            replace(motion, hang=0.5 * free),
        ),
    )
