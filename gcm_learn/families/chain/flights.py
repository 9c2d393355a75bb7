"""Balls in flight: thrown to the arm, among a swarm, one after the other, or off a table."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from gcm_learn.families import ranges
from gcm_learn.families.chain.family import ChainFamily, Story, aimed, on_the_way
from gcm_learn.families.chain.motions import staged
from gcm_learn.families.chain.stage import Stage, Way
from gcm_learn.families.solids import UP, axes_along, solid, unit_vector
from gcm_learn.situation import Body, Box, Capsule, Sphere


@dataclass(frozen=True)
class ThrowChain(ChainFamily):
    """A thrown ball flies past the hand's place, among balls that fly or hang in the way."""

    name = "throw-chain"
    summary = "a thrown ball, among balls that cross the arm's way or rest in it"

    level: ranges.Range = ranges.span(0.4, 1.3)
    """Horizontal speed of the ball [reaches/s]."""
    rise: ranges.Range = ranges.span(-3.0, 0.5, -100.0, 100.0)
    """Its vertical speed at the meeting [reaches/s]."""
    strays: ranges.Counts = ranges.counts(2, 5)
    """Number of balls that fly across the way."""
    resting: ranges.Counts = ranges.counts(0, 2)
    """Number of balls at rest in the way."""
    heavy: ranges.Range = ranges.span(0.07, 0.12, 1e-3)
    """Radius of these [reaches]."""

    def story(self, rng: np.random.Generator, stage: Stage) -> Story:
        """Draw a thrown ball, and resting obstacles in the way."""
        way, angle = self.way(rng, stage), ranges.pick_angle(rng)
        course = np.array([math.cos(angle), math.sin(angle), 0.0])
        pull = -stage.gravity * UP
        velocity = stage.size(rng, self.level) * course + stage.size(rng, self.rise) * UP
        bodies = [self.ball(rng, stage, way.meet, way.when, velocity - way.when * pull, pull)]
        bodies += aimed(rng, stage, way, self._heavy, ranges.pick_count(rng, self.resting))
        return Story(way, tuple(bodies))

    def _heavy(self, rng: np.random.Generator, stage: Stage, way: Way, k: int) -> Body:
        place, _ = on_the_way(rng, stage, way)
        return solid(f"heavy ball {k + 1}", Sphere(stage.size(rng, self.heavy)), place)


@dataclass(frozen=True)
class SwarmChain(ChainFamily):
    """A swarm of balls crosses the way from all sides, while the target drifts."""

    name = "swarm-chain"
    summary = "a drifting ball behind a swarm of balls that cross the arm's way"

    strays: ranges.Counts = ranges.counts(6, 10)
    """Number of balls in the swarm."""
    drift: ranges.Range = ranges.span(0.08, 0.42)
    """Speed of the target [reaches/s]."""

    def story(self, rng: np.random.Generator, stage: Stage) -> Story:
        """A ball that drifts."""
        way = self.way(rng, stage)
        course = stage.size(rng, self.drift) * unit_vector(rng.normal(size=3))
        return Story(way, (self.ball(rng, stage, way.meet, way.when, course),))


@dataclass(frozen=True)
class SequenceChain(SwarmChain):
    """Several balls drift by while others cross the way; as many as possible are wanted.

    It asks for an order: each ball is within reach for its own time, and each way takes time.
    """

    name = "sequence-chain"
    summary = "three to five balls that drift by, as many as possible to be caught in one movement"
    several = True

    targets: ranges.Counts = ranges.counts(3, 5, 1)
    """Number of targets."""
    passes: ranges.Range = ranges.span(0.15, 0.9, 0.05, 0.97)
    """Times at which the hand could meet those after the first [horizons]."""
    drift: ranges.Range = ranges.span(0.1, 0.6)
    """Speed of the targets [reaches/s]."""
    strays: ranges.Counts = ranges.counts(3, 6)
    """Number of balls that fly across the way to the first."""

    def story(self, rng: np.random.Generator, stage: Stage) -> Story:
        """A ball at the end of the way, and others at places that the hand can reach."""
        way, bodies = super().story(rng, stage)[:2]
        hands, _ = stage.hands()
        for k in range(1, ranges.pick_count(rng, self.targets)):
            meet, when = (
                hands[rng.integers(len(hands))],
                ranges.pick(rng, self.passes) * stage.horizon,
            )
            course = stage.size(rng, self.drift) * unit_vector(rng.normal(size=3))
            other = self.ball(rng, stage, meet, when, course)
            bodies = (*bodies, replace(other, name=f"target {k + 1}"))
        return Story(way, bodies, "most" if len(bodies) > 1 else "any")


@dataclass(frozen=True)
class FallingChain(ChainFamily):
    """A ball falls onto a table and is caught after it bounced; bars fall beside it."""

    name = "falling-chain"
    summary = "a ball that bounces off a table, among falling bars"

    bounce: ranges.Range = ranges.span(0.12, 0.35, 0.01)
    """Time from the bounce to the meeting [s]; a shorter one if that is sooner."""
    height: ranges.Range = ranges.span(0.08, 0.3, 0.01)
    """From the table to the meeting [reaches]."""
    elastic: ranges.Range = ranges.span(0.6, 0.9, 0.1, 1.0)
    """Speed after the bounce, as a share of that before."""
    level: ranges.Range = ranges.span(0.0, 0.3)
    """Horizontal speed [reaches/s]."""
    table: ranges.Range = ranges.span(0.08, 0.2, 0.01)
    """Half the table's sides [reaches]."""
    falling: ranges.Counts = ranges.counts(1, 4)
    """Number of falling bars."""
    bar: ranges.Range = ranges.span(0.02, 0.04, 1e-3)
    """Radius of bars [reaches]."""
    length: ranges.Range = ranges.span(0.06, 0.2, 1e-3)
    """Half their length [reaches]."""
    fall: ranges.Range = ranges.span(0.3, 2.0)
    """Speed with which they fall through the way [reaches/s]."""
    spin: float = ranges.number(2.0, most=50.0)
    """Largest rate at which they turn [rad/s]."""

    def story(self, rng: np.random.Generator, stage: Stage) -> Story:
        """Draw a ball that bounces, its table, and falling bars."""
        way = self.way(rng, stage)
        bodies = list(self._bounced(rng, stage, way))
        bodies += aimed(rng, stage, way, self._bar, ranges.pick_count(rng, self.falling))
        return Story(way, tuple(bodies))

    def _bounced(self, rng: np.random.Generator, stage: Stage, way: Way) -> tuple[Body, Body]:
        """Draw a ball that bounces before the meeting, and the table on which it bounces."""
        since = min(ranges.pick(rng, self.bounce), 0.5 * way.when)
        high, angle = stage.size(rng, self.height), ranges.pick_angle(rng)
        pull, first = -stage.gravity * UP, way.when - since
        up = (high + 0.5 * stage.gravity * since**2) / since
        course = stage.size(rng, self.level) * np.array([math.cos(angle), math.sin(angle), 0.0])
        struck = way.meet - since * course - high * UP
        down = course - (up / ranges.pick(rng, self.elastic)) * UP - first * pull
        begin = struck - down * first - 0.5 * pull * first**2
        ball = self.ball(rng, stage, begin, 0.0)
        ball = staged(ball, [(0.0, down, pull), (first, course + up * UP, pull)])
        sides = (stage.size(rng, self.table), stage.size(rng, self.table), 0.01 * stage.arm.reach)
        low = ball.shape.bounding_radius + sides[2]
        return ball, solid("table", Box(sides), struck - low * UP)

    def _bar(self, rng: np.random.Generator, stage: Stage, way: Way, k: int) -> Body:
        place, when = on_the_way(rng, stage, way)
        pull = -stage.gravity * UP
        velocity = -stage.size(rng, self.fall) * UP - when * pull
        shape = Capsule(stage.size(rng, self.bar), stage.size(rng, self.length))
        axes, spin = axes_along(rng.normal(size=3)), self.spin * rng.uniform(-1.0, 1.0, 3)
        name = f"bar {k + 1}"
        return solid(name, shape, place, axes, when=when, velocity=velocity, pull=pull, spin=spin)
