"""A table before the robot: the arm hangs down, the ball rolls on the table."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gcm_learn.families import ranges
from gcm_learn.families.layout import TRIES
from gcm_learn.families.solids import STILL, solid
from gcm_learn.families.space.family import SpaceStory, SpatialFamily, fits
from gcm_learn.families.space.stage import SpaceStage, SpaceWay
from gcm_learn.situation import Body, Box, Cylinder, Sphere

THIN = 0.05  # half the thickness of the table's top [forearms]


@dataclass(frozen=True)
class BenchSpace(SpatialFamily):
    """A hand under a table, and a ball on the table behind boxes and cans, some of which slide.

    The arm has to come out from under the table, and then reach over or past the boxes and cans.
    """

    name = "bench-space"
    summary = "a ball that rolls on a table, among boxes and cans, the hand under the table"

    takes: ranges.Range = ranges.span(0.12, 0.6, most=0.9)
    """Duration of the straight way of the joints [horizons]."""
    height: ranges.Range = ranges.span(-0.9, -0.3, -2.0, 1.0)
    """Of the table's top, from the shoulder [forearms]."""
    edge: ranges.Range = ranges.span(0.25, 0.6, 0.01)
    """From the shoulder to the table's edge [forearms]."""
    below: float = ranges.number(0.75)
    """Share of hands that are under the table at first."""
    roll: ranges.Range = ranges.span(0.0, 1.0)
    """Speed of the ball [forearms/s]."""
    goods: ranges.Counts = ranges.counts(1, 4)
    """Number of boxes and cans."""
    size: ranges.Range = ranges.span(0.1, 0.35, 1e-3)
    """Half their widths [forearms]."""
    tall: ranges.Range = ranges.span(0.15, 0.6, 1e-3)
    """Half their heights [forearms]."""
    sliding: float = ranges.number(0.4)
    """Share of boxes and cans that slide."""
    slides: ranges.Range = ranges.span(0.5, 2.5)
    """Their speeds [forearms/s]."""

    def story(self, rng: np.random.Generator, stage: SpaceStage) -> SpaceStory:
        """A table, a ball and goods."""
        top, edge = ranges.pick(rng, self.height), ranges.pick(rng, self.edge)
        if top > -2.0 * stage.thickness:
            edge += stage.thickness
        table = solid("table", Box((1.25, 2.0, THIN)), (edge + 1.25, 0.3, top - THIN))
        way, target = self._way(rng, stage, table, top, edge)
        bodies = [target, table]
        for k in range(ranges.pick_count(rng, self.goods)):
            for _ in range(TRIES):
                good = self._good(rng, way, top, f"{k + 1}")
                if fits(stage, way, way.takes, (good,)):
                    break
            bodies.append(good)
        return SpaceStory(way, way.takes, tuple(bodies))

    def _way(
        self, rng: np.random.Generator, stage: SpaceStage, table: Body, top: float, edge: float
    ) -> tuple[SpaceWay, Body]:
        """Draw a way that starts under or over the table, and a ball on the table at its end."""
        _, hand = stage.limb(stage.joints)
        free = stage.room(stage.joints, (table,)) > 0.0
        out = free & (hand[:, 0] > edge)
        under = out & (hand[:, 2] < top) if rng.random() < self.below else free
        near = self.target[1] + 0.7 * stage.grasp
        on = out & (hand[:, 2] > top) & (hand[:, 2] < top + 2.0 * self.target[1] + near)
        way = stage.way(rng, self.takes, under, on)
        angle, speed = ranges.pick_angle(rng), ranges.pick(rng, self.roll)
        course = speed * np.array([math.cos(angle), math.sin(angle), 0.0])
        radius = ranges.pick(rng, self.target)
        place = np.array([way.meet[0], way.meet[1], top + radius])
        return way, solid("target", Sphere(radius), place, when=way.takes, velocity=course)

    def _good(self, rng: np.random.Generator, way: SpaceWay, top: float, name: str) -> Body:
        """Draw a box or a can that stands before or beside the ball, or slides past the ball."""
        size, high = ranges.pick(rng, self.size), ranges.pick(rng, self.tall)
        towards = way.meet * rng.uniform(0.4, 1.0) + rng.normal(size=3) * 0.3
        place = np.array([towards[0], towards[1], top + high])
        can = Cylinder(size, high) if rng.random() < 0.5 else None
        shape = can or Box((size, ranges.pick(rng, self.size), high))
        velocity = STILL
        if rng.random() < self.sliding:
            angle = ranges.pick_angle(rng)
            velocity = ranges.pick(rng, self.slides) * np.array(
                [math.cos(angle), math.sin(angle), 0.0]
            )
        return solid(f"{shape.kind} {name}", shape, place, when=way.takes, velocity=velocity)
