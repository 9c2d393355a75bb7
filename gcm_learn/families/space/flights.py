"""Balls in free flight: thrown over a shelf, falling among other bodies, or coming late."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from gcm_learn.arms import SPATIAL, SpatialArm
from gcm_learn.families import ranges
from gcm_learn.families.layout import TRIES
from gcm_learn.families.solids import UP, axes_along, flight, gap, solid, unit_vector
from gcm_learn.families.space import family
from gcm_learn.families.space.stage import SpaceStage, SpaceWay
from gcm_learn.situation import Body, Box, Situation

THIN = 0.03  # half the thickness of shelves [forearms]
SEEN = 0.15  # of a flight before the meeting, in which balls keep off a shelf [s]


@dataclass(frozen=True)
class ThrownFamily(family.SpatialFamily):
    """Base of families with a ball that is thrown from afar, and caught on its way down."""

    when: ranges.Range = ranges.span(0.5, 0.9, 0.1, 0.95)
    """Time of the meeting [horizons]."""
    thrown: ranges.Range = ranges.span(4.0, 12.0)
    """From how far, level [forearms]."""
    heading: ranges.Range = ranges.span(-0.8, 1.2, -3.15, 3.15)
    """Direction that it comes from, from ahead to the arm's side [rad]."""
    drop: ranges.Range = ranges.span(-3.0, 1.0, -100.0)
    """Height of the throw above the meeting [forearms]."""

    def thrown_ball(
        self, rng: np.random.Generator, stage: SpaceStage, meet: np.ndarray, when: float
    ) -> Body:
        """A ball that is at a place at a time, having been thrown at t = 0."""
        angle = ranges.pick(rng, self.heading)
        level = np.array([math.cos(angle), math.sin(angle), 0.0])
        away = ranges.pick(rng, self.thrown) * level + ranges.pick(rng, self.drop) * UP
        pull = -stage.build.gravity * UP
        velocity = -away / when - 0.5 * pull * when
        return self.ball(rng, meet, when, velocity, pull)


@dataclass(frozen=True)
class OverShelfSpace(ThrownFamily):
    """A ball thrown over a shelf above the arm, to be caught before the ball lands.

    The arm has to go round the shelf: past its end at the arm's side, or drawn in before its edge.
    """

    name = "over-shelf-space"
    summary = "a thrown ball to catch above a shelf that the arm is under"

    height: ranges.Range = ranges.span(-0.6, 0.5, -2.0, 2.0)
    """Of the shelf over the shoulder [forearms]."""
    edge: ranges.Range = ranges.span(0.15, 0.5, 0.01)
    """From the shoulder to the shelf's near edge [forearms]."""
    depth: ranges.Range = ranges.span(1.2, 2.2, 0.01)
    """Of the shelf [forearms]."""
    side: ranges.Range = ranges.span(0.6, 2.0, -1.0)
    """Extent to the arm's side [forearms]."""
    posts: float = ranges.number(0.6)
    """Share of shelves on a wall at that side, round which there is no way."""

    def story(self, rng: np.random.Generator, stage: SpaceStage) -> family.SpaceStory:
        """Draw a thrown ball, a shelf, and perhaps a wall at the shelf's side."""
        height = ranges.pick(rng, self.height)
        edge = ranges.pick(rng, self.edge) + (
            stage.thickness if abs(height) < 2 * stage.thickness else 0
        )
        shelf = self._shelf(rng, stage, height, edge)
        points, (_, hand) = stage.points(stage.joints), stage.limb(stage.joints)
        free = stage.room(stage.joints, shelf) > 0.0
        out = free & (hand[:, 0] > edge)
        under = out & (points[:, -3:, 2].max(axis=1) < height)
        over = out & (hand[:, 2] > height + stage.thickness)
        when = ranges.pick(rng, self.when) * stage.horizon
        for _ in range(TRIES):
            way = stage.way(rng, self.takes, under, over)
            ball = self.thrown_ball(rng, stage, way.meet, when)
            if _keeps_off(ball, shelf, when):
                break
        return family.SpaceStory(way, when, (ball, *shelf), _lands(ball, height, when))

    def _shelf(
        self, rng: np.random.Generator, stage: SpaceStage, height: float, edge: float
    ) -> tuple[Body, ...]:
        """Draw a shelf: a board, with or without a wall at its side."""
        depth, left, right = ranges.pick(rng, self.depth), ranges.pick(rng, self.side), -1.5
        place = (edge + 0.5 * depth, 0.5 * (left + right), height)
        board = solid("shelf", Box((0.5 * depth, 0.5 * (left - right), THIN)), place)
        if rng.random() >= self.posts:
            return (board,)
        side = (place[0], left + THIN, height)
        return board, solid("wall", Box((0.5 * depth, THIN, 0.5 * stage.reach)), side)


@dataclass(frozen=True)
class LateTargetSpace(ThrownFamily):
    """A thrown ball within reach for a moment, at a place that another body leaves just before.

    The arm has to be near in time and to go in late: it cannot wait where the ball will be.
    """

    name = "late-target-space"
    summary = "a thrown ball within reach for a moment, where something has just left"

    sentries: float = ranges.number(0.75)
    """Share of balls whose place is taken at first."""
    leaves: ranges.Range = ranges.span(0.8, 0.98, 0.05, 1.0)
    """Instant at which it is free, as shares of the time until the ball is there."""
    sentry: ranges.Range = ranges.span(0.4, 0.9, 1e-3)
    """Radius of what takes it [forearms]."""
    obstacles: ranges.Counts = ranges.counts(1, 3)
    """Number of other obstacles, which rest across the way."""
    share: ranges.Range = ranges.span(0.25, 0.8, most=1.0)
    """Places on the way at which they stand, as shares of it."""

    def story(self, rng: np.random.Generator, stage: SpaceStage) -> family.SpaceStory:
        """Draw a thrown ball, perhaps a body that leaves the ball's place, and other obstacles."""
        way, when = stage.way(rng, self.takes), ranges.pick(rng, self.when) * stage.horizon
        bodies = [self.thrown_ball(rng, stage, way.meet, when)]
        if rng.random() < self.sentries:
            gone = ranges.pick(rng, self.leaves) * when
            bodies.append(family.sentry(rng, stage, way, self.sentry, gone))
        for k in range(ranges.pick_count(rng, self.obstacles)):
            bodies.append(
                family.aimed(rng, stage, way, family.Things(), self.share, f"{k + 1}", when)
            )
        return family.SpaceStory(way, when, tuple(bodies))


@dataclass(frozen=True)
class FallingSpace(family.SpatialFamily):
    """A ball falls past shelves, among boards, bars and balls that fall as well.

    It asks for a way round the shelves in the time that a fall takes, between what falls.
    """

    name = "falling-space"
    summary = "a falling ball among falling bodies, and shelves at rest"

    obstacles: ranges.Counts = ranges.counts(2, 4)
    """Number of obstacles."""
    shelves: float = ranges.number(0.6)
    """Share of obstacles that are shelves at rest."""
    falls: ranges.Range = ranges.span(0.05, 0.3)
    """Time that a body has fallen when it is in its place [s]."""
    drift: ranges.Range = ranges.span(0.0, 1.0)
    """Level speeds [forearms/s]."""
    when: ranges.Range = ranges.span(0.35, 0.8, 0.1, 0.95)
    """Time of the meeting [horizons]."""
    share: ranges.Range = ranges.span(0.25, 0.85, most=1.0)
    """Places of obstacles on the way, as shares of it."""
    things: family.Things = field(default_factory=lambda: family.Things(boards=0.4, bars=0.4))

    def story(self, rng: np.random.Generator, stage: SpaceStage) -> family.SpaceStory:
        """Draw a falling ball, with shelves and falling bodies."""
        way, when = stage.way(rng, self.takes), ranges.pick(rng, self.when) * stage.horizon
        velocity, pull = self._toss(rng, stage, when)
        bodies = [self.ball(rng, way.meet, when, velocity, pull)]
        for k in range(ranges.pick_count(rng, self.obstacles)):
            make = self._shelf if rng.random() < self.shelves else self._faller
            for _ in range(TRIES):
                body = make(rng, stage, way, when, f"{k + 1}")
                if family.fits(stage, way, when, (body,)):
                    break
            bodies.append(body)
        return family.SpaceStory(way, when, tuple(bodies))

    def _toss(
        self, rng: np.random.Generator, stage: SpaceStage, when: float
    ) -> tuple[np.ndarray, np.ndarray]:
        """Draw velocity (3,) at t = 0 and acceleration (3,) of a body that is falling at `when`."""
        angle, speed = ranges.pick_angle(rng), ranges.pick(rng, self.drift)
        pull = -stage.build.gravity * UP
        level = speed * np.array([math.cos(angle), math.sin(angle), 0.0])
        return level + (ranges.pick(rng, self.falls) - when) * pull, pull

    def _shelf(
        self, rng: np.random.Generator, stage: SpaceStage, way: SpaceWay, when: float, name: str
    ) -> Body:
        """A level board across the way."""
        place, axes = family.across(rng, stage, way, ranges.pick(rng, self.share))
        sizes = (ranges.pick(rng, self.things.length), ranges.pick(rng, self.things.width), THIN)
        return solid(f"shelf {name}", Box(sizes), place, axes_along(UP, axes[:, 2]))

    def _faller(
        self, rng: np.random.Generator, stage: SpaceStage, way: SpaceWay, when: float, name: str
    ) -> Body:
        """Something that falls through the way when the limb is there, or until the ball comes."""
        kind, shape = self.things.shape(rng)
        share = ranges.pick(rng, self.share)
        place, axes = family.across(rng, stage, way, share)
        at = share * way.takes + rng.random() * (when - share * way.takes)
        velocity, pull = self._toss(rng, stage, at)
        return solid(f"{kind} {name}", shape, place, axes, when=at, velocity=velocity, pull=pull)


def _lands(ball: Body, height: float, when: float) -> float:
    """Return when a ball that is over a height at a time, and comes down, is down there [s]."""
    motion, radius = flight(ball), ball.shape.bounding_radius
    pull, rate = motion.acceleration[2], motion.velocity[2]
    above = max(motion.position[2] + when * (rate + 0.5 * pull * when) - height - radius, 0.0)
    falls = rate + pull * when
    return when + (falls + math.sqrt(falls * falls - 2.0 * pull * above)) / -pull


def _keeps_off(ball: Body, bodies: tuple[Body, ...], when: float) -> bool:
    """Return whether a ball is clear of all resting bodies shortly before its meeting."""
    times = np.linspace(max(when - SEEN, 0.0), when, 12)[:, None]
    motion = flight(ball)
    p, v, a = (np.array(x) for x in (motion.position, motion.velocity, motion.acceleration))
    places = p + v * times + 0.5 * a * times**2
    return all(gap(places, body, 0.0).min() > ball.shape.bounding_radius for body in bodies)


@dataclass(frozen=True)
class SequenceSpace(family.SpatialFamily):
    """Several balls fly by among boards, bars and balls at rest; as many as possible are wanted.

    It asks for an order: each ball is within reach for its own time, and each way takes time.
    """

    name = "sequence-space"
    summary = "three to five balls that fly by, as many as possible to be caught in one movement"
    several = True

    targets: ranges.Counts = ranges.counts(3, 5, 1)
    """Number of balls."""
    when: ranges.Range = ranges.span(0.15, 0.9, 0.05, 0.95)
    """Times at which they are at places that the hand can reach [horizons]."""
    speed: ranges.Range = ranges.span(0.2, 1.2)
    """Of the balls [forearms/s]."""
    obstacles: ranges.Counts = ranges.counts(2, 4)
    """Number of obstacles, which rest across the way to the first ball."""
    things: family.Things = field(default_factory=family.Things)
    share: ranges.Range = ranges.span(0.25, 0.8, most=1.0)
    """Places on that way at which they stand, as shares of it."""

    def story(self, rng: np.random.Generator, stage: SpaceStage) -> family.SpaceStory:
        """Draw all balls, each with its own place to be caught, and obstacles in the way."""
        way = stage.way(rng, self.takes)
        bodies = [self._passing(rng, stage, way, way.takes)]
        for k in range(1, ranges.pick_count(rng, self.targets)):
            when = ranges.pick(rng, self.when) * stage.horizon
            other = self._passing(rng, stage, stage.way(rng, self.takes), when)
            bodies.append(replace(other, name=f"target {k + 1}"))
        for k in range(ranges.pick_count(rng, self.obstacles)):
            bodies.append(
                family.aimed(rng, stage, way, self.things, self.share, f"{k + 1}", way.takes)
            )
        return family.SpaceStory(way, way.takes, tuple(bodies))

    def sketch(self, rng: np.random.Generator, name: str) -> Situation[SpatialArm]:
        """Draw once, the limb free or not; most of the balls are wanted."""
        drawn = super().sketch(rng, name)
        catch = "most" if len(drawn.targets) > 1 else "any"
        return replace(drawn, catch=catch, format=SPATIAL.formats[1])

    def _passing(
        self, rng: np.random.Generator, stage: SpaceStage, way: SpaceWay, when: float
    ) -> Body:
        """A ball at the end of a way at a time, in steady flight."""
        velocity = ranges.pick(rng, self.speed) * unit_vector(rng.normal(size=3))
        return self.ball(rng, way.meet, when, velocity)
