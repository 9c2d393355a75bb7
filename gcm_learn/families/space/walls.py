"""A wall between arm and ball, with one opening: a window that closes or opens, or a door."""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gcm_learn.families import solids
from gcm_learn.families.ranges import Range, number, pick, pick_sign, span
from gcm_learn.families.space.family import SpaceStory, SpatialFamily, leaving, through
from gcm_learn.families.space.stage import SpaceStage, SpaceWay
from gcm_learn.situation import Body, Box, Pendulum

EXTENT = 2.5  # how far a wall goes on beyond its opening [forearms]
THICK = 0.03  # half the thickness of walls and what shuts them [forearms]
THROUGH = 0.5  # cosine between a wall's normal and forearms that may reach through it
WIDE_OPEN = 1.4  # angle at which a door counts as open [rad]
CREEPS = 4.0  # by how many times e its angle grows until then


class Wall(NamedTuple):
    """A plane with an opening."""

    middle: np.ndarray
    """Of the opening (3,) [forearms]."""
    axes: np.ndarray
    """Columns: across the opening, up along the wall, the normal away from the shoulder."""
    wide: float
    """Half the opening's width [forearms]."""
    high: float
    """Half its height."""

    def board(self, name: str, u: float, v: float, w: float, wide: float, high: float) -> Body:
        """Return a board parallel to the wall, its middle at (u, v, w) in the wall's axes."""
        place = self.middle + self.axes @ (u, v, w)
        return solids.solid(name, Box((wide, high, THICK)), place, self.axes)

    def boards(self) -> tuple[Body, ...]:
        """Return the wall's boards: to both sides of the opening, over and under it."""
        half = 0.5 * EXTENT
        u, v = self.wide + half, self.high + half
        return (
            self.board("wall left", -u, 0.0, 0.0, half, self.high + EXTENT),
            self.board("wall right", u, 0.0, 0.0, half, self.high + EXTENT),
            self.board("wall below", 0.0, -v, 0.0, self.wide, half),
            self.board("wall above", 0.0, v, 0.0, self.wide, half),
        )


@dataclass(frozen=True)
class WallFamily(SpatialFamily):
    """Base of families with a wall: the forearm has to go through its opening."""

    takes: Range = span(0.1, 0.3, most=0.9)
    """Duration of the straight way of the joints [horizons]."""
    distance: Range = span(0.45, 1.1, 0.05)
    """From the shoulder to the wall [forearms]."""
    slack: Range = span(0.15, 0.4, 0.01)
    """Between a forearm in the middle of the opening and its rim [forearms]."""
    heading: Range = span(-0.7, 1.2, -3.15)
    """Of the wall's normal, from ahead to the arm's side [rad]."""
    slope: Range = span(-0.4, 0.4, -1.5)
    """Of the normal against the horizontal [rad]."""
    drift: Range = span(0.0, 0.3)
    """Speed of the target along the wall [forearms/s]."""
    left: Range = span(0.6, 1.4, 0.1)
    """Time for which it is open before the horizon, in durations of the straight way."""

    def story(self, rng: np.random.Generator, stage: SpaceStage) -> SpaceStory:
        """A ball behind a wall."""
        radius = pick(rng, self.target)
        way, wall = self._wall(rng, stage, through(stage, radius))
        opens = way.opens(stage.horizon, pick(rng, self.left))
        shut, when = self.shut(rng, stage, wall, way, opens)
        drift = pick(rng, self.drift) * pick_sign(rng) * wall.axes[:, 0]
        target = self.ball(rng, way.meet, when, drift, radius=radius)
        return SpaceStory(way, when, (target, *wall.boards(), *shut))

    @abstractmethod
    def shut(
        self, rng: np.random.Generator, stage: SpaceStage, wall: Wall, way: SpaceWay, opens: float
    ) -> tuple[tuple[Body, ...], float]:
        """Return the bodies that shut the opening, and a time when the limb can be in it [s]."""

    def _wall(
        self, rng: np.random.Generator, stage: SpaceStage, past: float
    ) -> tuple[SpaceWay, Wall]:
        """Draw a way through a wall to a hand at least `past` behind it, and the wall."""
        heading, slope = pick(rng, self.heading), pick(rng, self.slope)
        level = np.array([math.cos(heading), math.sin(heading), 0.0])
        normal = math.cos(slope) * level + math.sin(slope) * solids.UP
        distance = max(pick(rng, self.distance), stage.thickness + 2.0 * THICK)
        heights = stage.points(stage.joints) @ normal - distance
        elbow, hand = stage.limb(stage.joints)
        before = heights.max(axis=1) < -stage.thickness - 2.0 * THICK
        behind = (hand @ normal > distance + past) & (elbow @ normal < distance - stage.thickness)
        behind &= (hand - elbow) @ normal > THROUGH
        way = stage.way(rng, self.takes, before, behind)
        elbow, _ = stage.limb(way.end)
        bone = way.meet - elbow
        middle = elbow + bone * (distance - elbow @ normal) / (bone @ normal)
        axes = solids.axes_along(normal, np.cross(solids.UP, normal))
        lean = np.abs(bone @ axes[:, :2]) / abs(bone @ normal)
        wide, high = (
            stage.thickness * math.hypot(1.0, s) + s * THICK + pick(rng, self.slack) for s in lean
        )
        return way, Wall(middle, axes, wide, high)


@dataclass(frozen=True)
class WindowSpace(WallFamily):
    """A ball behind a wall with a window; a shutter closes the window, or opens it late.

    The forearm has to go through the window in time, or to stay before it until the shutter has
    gone, which no first arrival does.
    """

    name = "window-space"
    summary = "a ball behind a wall with one window, which a shutter closes or opens"

    opening: float = number(0.65)
    """Share of shutters that open."""
    closing: float = number(0.25)
    """Share of those that close; the other windows have none."""
    closes: Range = span(2.0, 5.0, 0.1)
    """Instant at which a window is closed, in durations of the straight way."""

    def shut(
        self, rng: np.random.Generator, stage: SpaceStage, wall: Wall, way: SpaceWay, opens: float
    ) -> tuple[tuple[Body, ...], float]:
        """A board that slides sideways, or up and down, on the far side of the wall."""
        kind = rng.random()
        if kind >= self.opening + self.closing:
            return (), way.takes
        k = int(rng.integers(2))
        slide, size = pick_sign(rng) * wall.axes[:, k], (wall.wide, wall.high)[k]
        shutter = wall.board("shutter", 0, 0, 3 * THICK, wall.wide + THICK, wall.high + THICK)
        if kind < self.opening:
            return (leaving(stage, way, shutter, slide, opens),), opens
        closed, way_off = pick(rng, self.closes) * way.takes, 2.0 * (size + THICK)
        return (solids.moved(shutter, closed, velocity=way_off / closed * slide),), way.takes


@dataclass(frozen=True)
class DoorSpace(WallFamily):
    """A ball behind a wall with a doorway; its door swings open, away from the arm.

    The arm has to wait: it cannot get through before the door is half open.
    """

    name = "door-space"
    summary = "a ball behind a door that swings open, away from the arm"

    def shut(
        self, rng: np.random.Generator, stage: SpaceStage, wall: Wall, way: SpaceWay, opens: float
    ) -> tuple[tuple[Body, ...], float]:
        """Draw a door on a hinge at one side of the doorway, slow at first like a damped spring.

        Its angle a follows a' = k sin(a), like a strongly damped pendulum that starts upside down;
        it stops at half a turn.
        """
        k, side = int(rng.integers(2)), pick_sign(rng)
        sizes = (wall.wide + THICK, wall.high + THICK)
        across = side * wall.axes[:, k]
        # Turned about `axis` the door's free edge goes along the normal, away from the arm.
        axis = solids.unit_vector(np.cross(across, wall.axes[:, 2]))
        rate, first = CREEPS / opens, math.tan(0.5 * WIDE_OPEN) * math.exp(-CREEPS)
        damping = 6.0 * rate
        motion = Pendulum(
            pivot=solids.triple(wall.middle + 3.0 * THICK * wall.axes[:, 2] - sizes[k] * across),
            axis=solids.triple(axis),
            down=solids.triple(axis * (axis @ across) - across),
            length=sizes[k],
            gravity=rate * damping * sizes[k],
            angle=2.0 * math.atan(first) - math.pi,
            rate=rate * math.sin(2.0 * math.atan(first)),
            damping=damping,
        )
        door = Body("obstacle", "door", Box((THICK, sizes[1 - k], sizes[k])), motion)
        return (door,), opens
