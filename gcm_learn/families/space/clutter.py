"""Boards, bars and balls across the arm's way: at rest, crossing, or running before the target."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from gcm_learn.families.layout import TRIES
from gcm_learn.families.ranges import Counts, Range, counts, number, pick, pick_count, span
from gcm_learn.families.solids import UP, axes_along, flight, moved, solid, unit_vector
from gcm_learn.families.space import family
from gcm_learn.families.space.stage import SpaceStage, SpaceWay
from gcm_learn.situation import Body, Box, Capsule


@dataclass(frozen=True)
class StaticClutterSpace(family.SpatialFamily):
    """Bodies at rest: boards, bars and balls stand across the arm's straight way.

    It asks for a way round: over an edge of a board, or with the arm drawn in.
    """

    name = "static-clutter-space"
    summary = "a resting ball among boards, bars and balls that stand across the arm's way"

    obstacles: Counts = counts(2, 5)
    """Number of obstacles."""
    things: family.Things = field(default_factory=family.Things)
    share: Range = span(0.25, 0.8, most=1.0)
    """Places on the way at which they stand, as shares of it."""

    def story(self, rng: np.random.Generator, stage: SpaceStage) -> family.SpaceStory:
        """Draw a ball at rest, and obstacles in the way."""
        way = stage.way(rng, self.takes)
        bodies = [self.ball(rng, way.meet)]
        for k in range(pick_count(rng, self.obstacles)):
            bodies.append(
                family.aimed(rng, stage, way, self.things, self.share, f"{k + 1}", way.takes)
            )
        return family.SpaceStory(way, way.takes, tuple(bodies))


@dataclass(frozen=True)
class CrossingSwarmSpace(family.SpatialFamily):
    """Long bars and boards cross the way with one heading, each at its own time.

    It asks for a gap in the stream: go before, after or between, or stand still until it has
    passed.
    """

    name = "crossing-swarm-space"
    summary = "a stream of long bars and boards across the arm's way, the target moving too"

    obstacles: Counts = counts(3, 6)
    """Number of obstacles."""
    things: family.Things = field(default_factory=lambda: family.Things(boards=0.5, bars=0.4))
    share: Range = span(0.25, 0.9, most=1.0)
    """Places on the way at which they cross, as shares of it."""
    speed: Range = span(0.4, 1.6)
    """Of the swarm, in ways of one forearm within the time that the way takes."""
    spread: Range = span(-0.4, 0.4, -3.15)
    """Headings of the members about their common one [rad]."""
    delay: Range = span(-0.15, 0.5, -1.0, 1.0)
    """Of members against the limb on its way [horizons]."""
    drift: Range = span(0.0, 0.4)
    """Speed of the target [forearms/s]."""

    def story(self, rng: np.random.Generator, stage: SpaceStage) -> family.SpaceStory:
        """A ball that drifts, and the swarm."""
        way = stage.way(rng, self.takes)
        drift = pick(rng, self.drift) * unit_vector(rng.normal(size=3))
        bodies = [self.ball(rng, way.meet, way.takes, drift)]
        _, axes = family.across(rng, stage, way, 0.5)
        heading = unit_vector(axes[:, 1] + 0.7 * rng.normal(size=3))
        for k in range(pick_count(rng, self.obstacles)):
            for _ in range(TRIES):
                member = self._member(rng, stage, way, heading, f"{k + 1}")
                if family.fits(stage, way, way.takes, (member,)):
                    break
            bodies.append(member)
        return family.SpaceStory(way, way.takes, tuple(bodies))

    def _member(
        self,
        rng: np.random.Generator,
        stage: SpaceStage,
        way: SpaceWay,
        heading: np.ndarray,
        name: str,
    ) -> Body:
        """Something that crosses the way when the limb is there, or a little later."""
        kind, shape = self.things.shape(rng)
        share = pick(rng, self.share)
        place, axes = family.across(rng, stage, way, share)
        when = share * way.takes + pick(rng, self.delay) * stage.horizon
        sideways = unit_vector(np.cross(heading, rng.normal(size=3)))
        angle = pick(rng, self.spread)
        course = math.cos(angle) * heading + math.sin(angle) * sideways
        velocity = pick(rng, self.speed) / way.takes * course
        return solid(f"{kind} {name}", shape, place, axes, when=when, velocity=velocity)


@dataclass(frozen=True)
class BehindPostSpace(family.SpatialFamily):
    """A tall post between hand and ball that moves with the ball, or on past the ball.

    A post that goes on past the ball is at first where the arm must be, so the arm has to wait
    behind it. Round a post that stays in between, the arm has to be drawn in, or lifted over it.
    """

    name = "behind-post-space"
    summary = "a ball behind a tall post that moves with it, or on past it"

    takes: Range = span(0.1, 0.3, most=0.9)
    """Duration of the straight way of the joints [horizons]."""
    passing: float = number(0.8)
    """Share of posts that go on past the ball."""
    left: Range = span(0.6, 1.4, 0.1)
    """Time for which the arm that catches is free of it before the horizon, in durations of the
    straight way."""
    near: Range = span(0.3, 0.7, 0.05)
    """Distance of the post's inner side from the shoulder [forearms]."""
    slabs: float = number(0.7)
    """Share of posts that are slabs, standing radially about the shoulder."""
    radius: Range = span(0.08, 0.2, 1e-3)
    """Of round posts; slabs are half as thick [forearms]."""
    depth: Range = span(0.8, 1.8, 1e-3)
    """Of slabs, away from the shoulder [forearms]."""
    height: Range = span(0.8, 2.2, 1e-3)
    """Half the height [forearms]."""
    drift: Range = span(0.0, 0.6)
    """Speed of the target [forearms/s]."""
    things: family.Things = field(default_factory=family.Things)
    others: Counts = counts(0, 2)
    """Number of other bodies, at rest across the way."""

    def story(self, rng: np.random.Generator, stage: SpaceStage) -> family.SpaceStory:
        """The ball, the post, others."""
        way = stage.way(rng, self.takes)
        _, start = stage.limb(way.start)
        passes = rng.random() < self.passing
        when = way.opens(stage.horizon, pick(rng, self.left)) if passes else way.takes
        drift = pick(rng, self.drift) * unit_vector(rng.normal(size=3) * (1.0, 1.0, 0.3))
        target = self.ball(rng, way.meet, when, drift)
        post = self._post(rng, start, way.meet)
        if passes:
            course = unit_vector(way.meet - start)
            ahead = float(course @ (way.meet - flight(post).position))
            post = family.leaving(stage, way, post, course, when, max(ahead, 0.0))
        else:
            post = moved(post, 0.0, 0.5 * drift)
        bodies = [target, post]
        for k in range(pick_count(rng, self.others)):
            bodies.append(family.aimed(rng, stage, way, self.things, (0.2, 0.9), f"{k + 1}", when))
        return family.SpaceStory(way, when, tuple(bodies))

    def _post(self, rng: np.random.Generator, start: np.ndarray, meet: np.ndarray) -> Body:
        """A post between the directions of two hands."""
        middle = unit_vector(unit_vector(start) + unit_vector(meet))
        normal = unit_vector(np.cross(np.cross(start, meet), middle))
        axis = UP if abs(middle[2]) < 0.7 else np.cross(middle, normal)
        radius, near = pick(rng, self.radius), pick(rng, self.near)
        half, height = 0.5 * pick(rng, self.depth), pick(rng, self.height)
        if rng.random() < self.slabs:
            place, axes = (near + half) * middle, axes_along(axis, middle)
            return solid("slab", Box((half, 0.5 * radius, height)), place, axes)
        return solid("post", Capsule(radius, height), (near + radius) * middle, axes_along(axis))
