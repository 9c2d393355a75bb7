"""Targets among resting, passing and hiding bodies: four families of the plane."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gcm_learn.arms import Arm
from gcm_learn.families import ranges
from gcm_learn.families.layout import Event, polar
from gcm_learn.families.piece_family import EventFamily, InSpace
from gcm_learn.families.pieces import PlanarPiece
from gcm_learn.families.ranges import Counts, Range, counts, number, pick, pick_angle, span


@dataclass(frozen=True)
class StaticClutter(EventFamily):
    """Bodies at rest; most obstacles stand where the limb's straight way leads."""

    name = "static-clutter"
    summary = "a resting target among resting balls and bars"

    def event(self, rng: np.random.Generator, arm: Arm, horizon: float) -> Event:
        """A ball at rest."""
        return self.ball_at_rest(rng, arm, horizon)

    def obstacle(self, rng: np.random.Generator, arm: Arm, event: Event, k: int) -> PlanarPiece:
        """A ball or bar at rest."""
        place, _ = self.aim(rng, arm, event)
        size, angle = self.sizes.any(rng), pick_angle(rng)
        return PlanarPiece("obstacle", f"obstacle {k + 1}", size, place, angle=angle)


@dataclass(frozen=True)
class StaticClutterSolid(InSpace, StaticClutter):
    """Resting spheres, posts and leaning bars in a vertical arm plane."""

    name = "static-clutter-solid"
    summary = "a resting ball among resting solids"


@dataclass(frozen=True)
class MovingPoint(EventFamily):
    """Points small enough to be all edge: where they pass, the limb must have gone or must wait."""

    name = "moving-point"
    summary = "points that cross the limb's way to a resting or slow target"

    point: Range = span(0.01, 0.03, 1e-3)
    """Radius of the points [forearms]."""
    speed: Range = span(0.1, 0.9)
    """Of the points [hand speeds]."""
    still: float = number(0.5)
    """Share of targets that rest."""
    target_speed: Range = span(0.05, 0.3)
    """Of the other targets [hand speeds]."""
    wait: Range = span(1.0, 1.8, 1.0)
    """Time of the meeting, in times that the hand needs for the way there."""

    def event(self, rng: np.random.Generator, arm: Arm, horizon: float) -> Event:
        """A ball that rests or is slow."""
        if rng.random() < self.still:
            return self.ball_at_rest(rng, arm, horizon)
        return self.moving_ball(rng, arm, horizon, self.target_speed, self.wait)

    def obstacle(self, rng: np.random.Generator, arm: Arm, event: Event, k: int) -> PlanarPiece:
        """A point."""
        place, at = self.aim(rng, arm, event)
        velocity = polar(pick(rng, self.speed) * arm.max_hand_speed, pick_angle(rng))
        size = (pick(rng, self.point),)
        return PlanarPiece("obstacle", f"point {k + 1}", size, place, at, velocity)


@dataclass(frozen=True)
class MovingPointSolid(InSpace, MovingPoint):
    """Small spheres and thin posts that come through the plane."""

    name = "moving-point-solid"
    summary = "points and thin posts that come through the plane on the limb's way"


@dataclass(frozen=True)
class CrossingSwarm(EventFamily):
    """Balls and bars with nearly the same heading, spread over the way and over time.

    The common heading is at right angles to the straight way, give or take `spread`.
    """

    name = "crossing-swarm"
    summary = "a stream of bodies across the limb's way, the target moving too"

    obstacles: Counts = counts(2, 5)
    """Number of obstacles."""
    speed: Range = span(0.15, 0.6)
    """Of the swarm [hand speeds]."""
    spread: Range = span(-0.5, 0.5, -3.15)
    """Headings of the swarm's members about their common one [rad]."""
    delay: Range = span(-0.2, 0.2, -1.0, 1.0)
    """Of members against the limb on its straight way [horizons]."""
    spin: Range = span(-1.5, 1.5, -100.0)
    """Of bars [hand speeds per forearm]."""
    target_speed: Range = span(0.0, 0.3)
    """[hand speeds]"""
    wait: Range = span(1.0, 1.8, 1.0)
    """Time of the meeting, in times that the hand needs for the way there."""

    def event(self, rng: np.random.Generator, arm: Arm, horizon: float) -> Event:
        """A ball that moves in any direction."""
        return self.moving_ball(rng, arm, horizon, self.target_speed, self.wait)

    def obstacle(self, rng: np.random.Generator, arm: Arm, event: Event, k: int) -> PlanarPiece:
        """A member of the swarm."""
        place, at = self.aim(rng, arm, event)
        (x, y), (mx, my), hand = arm.hand, event.meet, arm.max_hand_speed
        across = math.atan2(my - y, mx - x) + event.side * math.pi / 2
        heading = across + pick(rng, self.spread)
        velocity = polar(pick(rng, self.speed) * hand, heading)
        when = max(at + pick(rng, self.delay) * event.horizon, 0.0)
        size, angle, spin = self.sizes.any(rng), pick_angle(rng), pick(rng, self.spin) * hand
        name = f"member {k + 1}"
        return PlanarPiece("obstacle", name, size, place, when, velocity, (0.0, 0.0), angle, spin)


@dataclass(frozen=True)
class CrossingSwarmSolid(InSpace, CrossingSwarm):
    """Swarms of solids that also come through the plane."""

    name = "crossing-swarm-solid"
    summary = "a stream of solids across the limb's way and through the plane"


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

    def obstacle(self, rng: np.random.Generator, arm: Arm, event: Event, k: int) -> PlanarPiece:
        """First the cover, then bodies that move across the way."""
        if k == 0:
            return self._cover(rng, arm, event)
        place, at = self.aim(rng, arm, event)
        velocity = polar(ranges.pick(rng, self.others) * arm.max_hand_speed, ranges.pick_angle(rng))
        size, angle = self.sizes.any(rng), ranges.pick_angle(rng)
        return PlanarPiece("obstacle", f"obstacle {k}", size, place, at, velocity, angle=angle)

    def _cover(self, rng: np.random.Generator, arm: Arm, event: Event) -> PlanarPiece:
        """The mover between the hand's start and the target."""
        s, half = ranges.pick(rng, self.cover), ranges.pick(rng, self.half_length)
        (x, y), (mx, my), (vx, vy) = arm.hand, event.meet, event.target.velocity
        place, velocity = (x + s * (mx - x), y + s * (my - y)), (s * vx, s * vy)
        size: tuple[float, ...] = (0.5 * half,)
        if rng.random() < self.bar:
            size = (half, ranges.pick(rng, self.sizes.half_width))
        across = math.atan2(my - y, mx - x) + math.pi / 2
        return PlanarPiece("obstacle", "cover", size, place, event.when, velocity, angle=across)


@dataclass(frozen=True)
class BehindMoverSolid(InSpace, BehindMover):
    """Solid targets and movers; a cover that comes through the plane covers for a while only."""

    name = "behind-mover-solid"
    summary = "a ball in space that a solid covers while both come through the plane"
