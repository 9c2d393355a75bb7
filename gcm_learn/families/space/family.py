"""Base of families in space: stories with one way of the arm, and bodies aimed at that way."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar, NamedTuple

import numpy as np

from gcm_learn.arms import SpatialArm
from gcm_learn.families import solids
from gcm_learn.families.family import TINY, Family
from gcm_learn.families.holds import Holds
from gcm_learn.families.layout import TRIES
from gcm_learn.families.ranges import Range, Ranges, number, pick, pick_angle, span
from gcm_learn.families.space.arms import SpatialArmRanges
from gcm_learn.families.space.stage import CHECKS, SpaceStage, SpaceWay, stage_of
from gcm_learn.situation import Body, Box, Capsule, Cylinder, Situation, SolidShape, Sphere

STORIES = 20  # that are drawn at most; the last one is taken then
BETWEEN = 40  # random postures, and as many beside the end, by which a way may lead
BESIDE = 0.15  # of a joint's range: how far beside it
BEYOND = 0.05  # how far a wall keeps the hand, at least, from catching through it [forearms]
STEP = 0.02  # of a way, over which its direction is taken
INNER, OUTER = 3, 10  # places on the limb at which bodies are aimed: past the half of the upper arm
FARTHEST, SEARCHED = 5.0, 0.1  # how far a body goes to leave a place, in steps [forearms]


class SpaceStory(NamedTuple):
    """Bodies of a situation, and one way of the arm to a catch."""

    way: SpaceWay
    when: float
    """From when on the end of the way is free [s]."""
    bodies: tuple[Body, ...]
    """The target and the obstacles [forearms]."""
    until: float | None = None
    """End of the story, if that is before the horizon [s]."""


@dataclass(frozen=True)
class Things(Ranges):
    """Bodies in the way: boards, bars and balls [forearms]."""

    boards: float = number(0.6)
    """Share of boards: thin boxes across the way."""
    bars: float = number(0.25)
    """Share of bars across it; the rest are balls."""
    length: Range = span(0.5, 1.3, TINY)
    """Half the length of boards, across the limb, and of bars."""
    width: Range = span(0.3, 0.8, TINY)
    """Half the width of boards, along the limb."""
    thin: Range = span(0.02, 0.05, TINY)
    """Half the thickness of boards."""
    radius: Range = span(0.06, 0.15, TINY)
    """Of bars; balls have twice that."""
    lean: Range = span(0.0, 0.5, most=1.5)
    """Angle by which boards and bars are out of the square [rad]."""

    def shape(self, rng: np.random.Generator) -> tuple[str, SolidShape]:
        """Draw a body: the name of its kind, and a shape with its length along z."""
        kind, radius = rng.random(), pick(rng, self.radius)
        if kind < self.boards:
            sizes = (pick(rng, self.width), pick(rng, self.thin), pick(rng, self.length))
            return "board", Box(sizes)
        if kind < self.boards + self.bars:
            made = Capsule if rng.random() < 0.5 else Cylinder
            return "bar", made(radius, pick(rng, self.length))
        return "ball", Sphere(2.0 * radius)


@dataclass(frozen=True)
class SpatialFamily(Family):
    """Base of families in space; a story is drawn anew until both ends of its way are free."""

    kind: ClassVar[str] = "spatial"

    arm: SpatialArmRanges = field(default_factory=SpatialArmRanges)
    takes: Range = span(0.12, 0.45, most=0.9)
    """Duration of the straight way of the joints [horizons]."""
    easy: float = number(0.25)
    """Share of situations in which the straight way may be free from the start."""
    target: Range = span(0.1, 0.28, TINY)
    """Radius of the target [forearms]."""
    holds: Holds = field(default_factory=Holds)

    def sketch(self, rng: np.random.Generator, name: str) -> Situation[SpatialArm]:
        """Draw once, the limb free or not."""
        build, horizon = self.arm.build(rng), pick(rng, self.arm.horizon)
        limits = self.arm.limits(rng, build)
        stage = stage_of(rng, build, horizon, rng.random() < self.arm.torso)
        easy = rng.random() < self.easy
        for _ in range(STORIES):
            story = self.story(rng, stage)
            if worth_planning(rng, stage, story, easy):
                break
        stage = stage._replace(horizon=min(story.until or horizon, horizon))
        situation = stage.situation(rng, name, story.way.start, story.bodies, limits)
        return self.holds.ask(rng, situation, build.unit)

    @abstractmethod
    def story(self, rng: np.random.Generator, stage: SpaceStage) -> SpaceStory:
        """Draw one story."""

    def ball(
        self,
        rng: np.random.Generator,
        meet: np.ndarray,
        when: float = 0.0,
        velocity: np.ndarray = solids.STILL,
        pull: np.ndarray = solids.STILL,
        radius: float | None = None,
    ) -> Body:
        """Draw a target ball that is at `meet` (3,) at `when`; `velocity` counts at t = 0."""
        size = pick(rng, self.target) if radius is None else radius
        return solids.solid("target", Sphere(size), meet, when=when, velocity=velocity, pull=pull)


def through(stage: SpaceStage, radius: float) -> float:
    """Return the distance behind a wall at which no hand before it catches a ball [forearms]."""
    return max(radius + stage.grasp - stage.thickness, 0.0) + BEYOND


def worth_planning(
    rng: np.random.Generator, stage: SpaceStage, story: SpaceStory, easy: bool
) -> bool:
    """Return whether a way by one posture in between is free while the straight way is blocked.

    A good guess: bodies are where they are at the start for the first half of the way, and where
    they are at the end for the second.
    """
    way, when, bodies, _ = story
    if not fits(stage, way, when, bodies):
        return False
    shares = np.linspace(0.0, 1.0, CHECKS)
    if not easy and all(stage.room(way.at(s), bodies, s * way.takes) > 0.0 for s in shares):
        return False
    low, high = np.array(stage.build.joint_range).T
    near = way.end + BESIDE * (high - low) * rng.normal(size=(BETWEEN, len(low)))
    vias = np.concatenate([stage.joints[:BETWEEN], np.clip(near, low, high)])
    vias = vias[stage.room(vias, bodies, when) > 0.0]
    vias = vias[stage.lines(vias, way.end, bodies, when)]
    return bool(stage.lines(way.start, vias, bodies, 0.0).any())


def fits(stage: SpaceStage, way: SpaceWay, when: float, bodies: Sequence[Body]) -> bool:
    """Estimate whether a way's start is free of bodies at t = 0, and its end at time `when`."""
    if stage.room(way.start, bodies) <= 0.0:
        return False
    return bool(stage.room(way.end, bodies, when) > 0.0)


def across(
    rng: np.random.Generator, stage: SpaceStage, way: SpaceWay, share: float
) -> tuple[np.ndarray, np.ndarray]:
    """Draw a place that the limb sweeps, with axes along the limb, along its motion, across both.

    Parameters
    ----------
    rng : numpy.random.Generator
    stage : SpaceStage
    way : SpaceWay
    share : float
        Of the way.

    Returns
    -------
    place : (3,) ndarray
        [forearms]
    axes : (3, 3) ndarray
        Columns.
    """
    limbs = stage.points(np.stack([way.at(share), way.at(share + STEP)]))
    k = int(rng.integers(INNER, OUTER + 1))
    place, motion = limbs[0, k], limbs[1, k] - limbs[0, k]
    along = solids.unit_vector(place)
    return place, solids.axes_along(solids.crossed(along, motion), along)


def leaning(rng: np.random.Generator, axes: np.ndarray, angle: float) -> np.ndarray:
    """Return axes (3, 3) with the z axis tilted by an angle [rad] to a random side."""
    side = pick_angle(rng)
    sideways = np.cos(side) * axes[:, 0] + np.sin(side) * axes[:, 1]
    return solids.axes_along(np.cos(angle) * axes[:, 2] + np.sin(angle) * sideways, axes[:, 0])


def aimed(
    rng: np.random.Generator,
    stage: SpaceStage,
    way: SpaceWay,
    things: Things,
    share: Range,
    name: str,
    when: float,
) -> Body:
    """Draw a body at rest across a way, where the limb would be; boards turn a face to the limb.

    It is drawn again where it touches the limb at the start, or at the end at `when`.
    """
    for _ in range(TRIES):
        kind, shape = things.shape(rng)
        place, axes = across(rng, stage, way, pick(rng, share))
        body = solids.solid(
            f"{kind} {name}", shape, place, leaning(rng, axes, pick(rng, things.lean))
        )
        if fits(stage, way, when, (body,)):
            break
    return body


def leaving(
    stage: SpaceStage,
    way: SpaceWay,
    body: Body,
    course: np.ndarray,
    when: float,
    least: float = 0.0,
) -> Body:
    """Return a body that sets out just fast enough that the way's end is free of it at `when`.

    Parameters
    ----------
    stage : SpaceStage
    way : SpaceWay
    body : Body
        Of constant velocity; it is drawn off this course.
    course : (3,) ndarray
        Unit vector: where to.
    when : float
        [s]
    least : float
        How far it goes at least until then [forearms].
    """
    for far in np.arange(least + SEARCHED, least + FARTHEST, SEARCHED):
        moving = solids.moved(body, 0.0, solids.flight(body).velocity, 2.0 * far / when**2 * course)
        if stage.room(way.end, (moving,), when) > 0.0:
            break
    return moving


def sentry(
    rng: np.random.Generator, stage: SpaceStage, way: SpaceWay, radius: Range, when: float
) -> Body:
    """Draw a ball or block at the end of the hand's way that leaves that place by time `when`."""
    for _ in range(TRIES):
        size = pick(rng, radius)
        shape = Sphere(size) if rng.random() < 0.5 else Box((size, size, size))
        place = way.meet + 0.3 * size * solids.unit_vector(rng.normal(size=3))
        body = solids.solid("block", shape, place, solids.axes_along(rng.normal(size=3)))
        if stage.room(way.start, (body,)) > 0.0:
            break
    return leaving(stage, way, body, solids.unit_vector(rng.normal(size=3)), when)
