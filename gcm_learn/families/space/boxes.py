"""A ball in a box: in a crate with a lid, or on a tray that moves under a cover."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from gcm_learn.families.ranges import Range, number, pick, pick_angle, span
from gcm_learn.families.solids import UP, axes_along, moved, solid
from gcm_learn.families.space.family import SpaceStory, SpatialFamily, leaving, through
from gcm_learn.families.space.stage import SpaceStage, SpaceWay
from gcm_learn.situation import Body, Box, Cylinder

THICK = 0.03  # half the thickness of walls [forearms]
STEEP = 0.75  # of a forearm's direction: boxes for steeper ones open upwards
SIDES = ((0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0))


@dataclass(frozen=True)
class CrateSpace(SpatialFamily):
    """A ball in a crate that is open above or to one side, or opens when its lid slides off.

    The arm has to go round the crate's walls and in with the forearm ahead. At a lid it has to
    wait.
    """

    name = "crate-space"
    summary = "a ball in a crate, open to one side, or shut by a lid that slides off"

    takes: Range = span(0.1, 0.3, most=0.9)
    """Duration of the straight way of the joints [horizons]."""
    lids: float = number(0.75)
    """Share of crates with a lid."""
    left: Range = span(0.7, 1.5, 0.1)
    """Time for which it is open before the horizon, in durations of the straight way."""
    slack: Range = span(0.2, 0.5, 0.01)
    """Between a forearm in the middle and the walls [forearms]."""
    depth: Range = span(0.25, 0.55, 0.05)
    """From the lid to the ball [forearms]."""

    def story(self, rng: np.random.Generator, stage: SpaceStage) -> SpaceStory:
        """A ball in a crate."""
        way = stage.way(rng, self.takes, None, reaching(stage))
        axes = entrance(stage, way)
        radius = pick(rng, self.target)
        apart = through(stage, radius)
        wide, high = (max(stage.thickness + pick(rng, self.slack), apart) for _ in range(2))
        depth, behind = max(pick(rng, self.depth), apart), max(stage.thickness + THICK, apart)
        crate = crate_of(way.meet, axes, (wide, high, depth), behind)
        target = self.ball(rng, way.meet, radius=radius)
        if rng.random() >= self.lids:
            return SpaceStory(way, way.takes, (target, *crate))
        gone = way.opens(stage.horizon, pick(rng, self.left))
        k, side = SIDES[int(rng.integers(4))]
        size = (wide + 2.0 * THICK, high + 2.0 * THICK, THICK)
        lid = solid("lid", Box(size), way.meet + (depth + 3.0 * THICK) * axes[:, 2], axes)
        lid = leaving(stage, way, lid, side * axes[:, k], gone)
        return SpaceStory(way, gone, (target, *crate, lid))


@dataclass(frozen=True)
class TraySpace(SpatialFamily):
    """A tray is carried past and hands over a ball, which stands under a cover or a roof.

    A cover is lifted late: it asks to go along with the tray, or to be there, and to wait. Under a
    roof on a wall the ball can be had from the sides only.
    """

    name = "tray-space"
    summary = "a ball on a moving tray, under a cover that is lifted late, or under a roof"

    takes: Range = span(0.1, 0.3, most=0.9)
    """Duration of the straight way of the joints [horizons]."""
    covers: float = number(0.75)
    """Share of trays with a cover; the others have a roof."""
    speed: Range = span(0.3, 1.5)
    """Of the tray [forearms/s]."""
    left: Range = span(0.7, 1.5, 0.1)
    """Time for which it is uncovered before the horizon, in durations of the straight way."""
    radius: Range = span(0.25, 0.45, 1e-3)
    """Of covers beyond the limb's thickness, and half the width of trays [forearms]."""
    headroom: Range = span(0.15, 0.4, 0.01)
    """Between a hand at the ball and the roof [forearms]."""

    def story(self, rng: np.random.Generator, stage: SpaceStage) -> SpaceStory:
        """Draw a tray with a ball, and a cover or a roof over the tray."""
        way = stage.way(rng, self.takes, None, reaching(stage))
        covered = rng.random() < self.covers
        when = way.opens(stage.horizon, pick(rng, self.left)) if covered else 1.5 * way.takes
        angle, radius = pick_angle(rng), stage.thickness + pick(rng, self.radius)
        course = pick(rng, self.speed) * np.array([math.cos(angle), math.sin(angle), 0.0])
        ball = self.ball(rng, way.meet, when, course)
        low = max(ball.shape.bounding_radius, stage.thickness) + 2.0 * THICK
        tray = solid("tray", Box((radius, radius, THICK)), way.meet - low * UP)
        over = (self._cover if covered else self._roof)(rng, stage, way, radius, low, when)
        carried = (moved(body, when, course) for body in (tray, *over))
        bodies = [ball, *carried]
        if covered:
            bodies[-1] = leaving(stage, way, bodies[-1], UP, when)
        return SpaceStory(way, when, tuple(bodies))

    @staticmethod
    def _cover(
        rng: np.random.Generator,
        stage: SpaceStage,
        way: SpaceWay,
        radius: float,
        low: float,
        when: float,
    ) -> tuple[Body, ...]:
        """A dome over the ball."""
        half = low + 0.5 * radius
        shape = Cylinder(radius, half) if rng.random() < 0.5 else Box((radius, radius, half))
        return (solid("cover", shape, way.meet + (half - low + 3.0 * THICK) * UP),)

    def _roof(
        self,
        rng: np.random.Generator,
        stage: SpaceStage,
        way: SpaceWay,
        radius: float,
        low: float,
        when: float,
    ) -> tuple[Body, ...]:
        """A roof, and a wall on the side that the forearm does not come from."""
        high = stage.thickness + pick(rng, self.headroom)
        roof = solid("roof", Box((radius, radius, THICK)), way.meet + high * UP)
        elbow, _ = stage.limb(way.end)
        away = (way.meet - elbow) * (1.0, 1.0, 0.0)
        axes = axes_along(UP, away)
        half = 0.5 * (low + high)
        middle = way.meet + radius * axes[:, 0] + (half - low) * UP
        return roof, solid("back", Box((THICK, radius, half)), middle, axes)


def reaching(stage: SpaceStage) -> np.ndarray:
    """Return which postures reach level or down (n,)."""
    elbow, hand = stage.limb(stage.joints)
    return (hand - elbow)[:, 2] < 0.3


def entrance(stage: SpaceStage, way: SpaceWay) -> np.ndarray:
    """Return axes of a box that the forearm enters: z points out of the box, upwards or level."""
    elbow, _ = stage.limb(way.end)
    out = elbow - way.meet
    if out[2] > STEEP * float(np.linalg.norm(out)):
        return axes_along(UP, out)
    return axes_along(out * (1.0, 1.0, 0.0), UP)


def crate_of(
    middle: np.ndarray, axes: np.ndarray, inner: tuple[float, float, float], behind: float
) -> tuple[Body, ...]:
    """Walls and bottom of a box about a place.

    Parameters
    ----------
    middle : (3,) ndarray
        [forearms]
    axes : (3, 3) ndarray
        Columns; the box is open along the third.
    inner : (3,) tuple of float
        From the place to the walls, and to the entrance [forearms].
    behind : float
        From the place to the bottom [forearms].
    """
    half = 0.5 * (inner[2] + behind)
    rise = (half - behind) * axes[:, 2]
    walls: list[Body] = []
    for k, side in SIDES:
        size = [inner[0], inner[1], half]
        size[k], size[1 - k] = THICK, inner[1 - k] + 2.0 * THICK
        place = middle + side * (inner[k] + THICK) * axes[:, k] + rise
        walls.append(solid(f"wall {len(walls) + 1}", Box((size[0], size[1], size[2])), place, axes))
    bottom = Box((inner[0], inner[1], THICK))
    return (*walls, solid("bottom", bottom, middle - behind * axes[:, 2], axes))
