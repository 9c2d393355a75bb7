"""Base of families for chains: stories with one way of the arm, and bodies aimed at that way."""

from __future__ import annotations

import json
from abc import abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np

from gcm_learn.arms import Chain, ChainModel
from gcm_learn.checks import show
from gcm_learn.errors import FamilyError, FileFormatError, SituationError
from gcm_learn.families import ranges
from gcm_learn.families.chain.bins import Bins
from gcm_learn.families.chain.measured import Measured
from gcm_learn.families.chain.stage import Stage, Way, stage_of
from gcm_learn.families.family import TINY, Family
from gcm_learn.families.holds import Holds
from gcm_learn.families.layout import TRIES
from gcm_learn.families.paper import EARTH
from gcm_learn.families.solids import axes_along, solid, triple, unit_vector
from gcm_learn.scene import pose
from gcm_learn.situation import (
    Approach,
    Body,
    Situation,
    Sphere,
    arm_from_json,
    read_arm,
    shipped_arm,
)


@lru_cache(maxsize=32)
def model_of(name: str) -> ChainModel:
    """Return the model of a shipped arm, of an arm file, or of such a file's text; cached.

    Raises
    ------
    FamilyError
        In one line that names the field, for an unknown name or a bad file.
    """
    try:
        if name.startswith("{"):
            return arm_from_json(json.loads(name))
        return read_arm(Path(name)) if name.endswith(".json") else shipped_arm(name)
    except (FileFormatError, SituationError) as error:
        raise FamilyError("model", str(error).removeprefix(": ")) from None


@dataclass(frozen=True)
class ChainArmRanges(ranges.Ranges):
    """Ranges of a chain and of the duration of situations; a reach is `Chain.reach`."""

    model: str = field(default="panda")
    """Name of an arm that ships, the path of an arm file, which ends in ``.json``, or its text."""
    metres: float = ranges.number(1.0, 1e-6, 1e6)
    """Length of the arm's unit [m]."""
    horizon: ranges.Range = ranges.span(1.0, 2.0, 1e-3)
    """Last moment at which a catch counts [s]."""
    grasp: ranges.Range = ranges.span(0.028, 0.028)
    """Distance at which the hand catches [reaches]."""
    hand_speed: ranges.Range = ranges.span(0.0, 0.0)
    """Limit of the hand's speed [reaches/s]; at 0 nothing limits it."""
    accelerations: tuple[float, ...] = ranges.positives()
    """Limits of the joints' accelerations; the model's when empty [rad/s^2 or lengths/s^2]."""
    jerks: tuple[float, ...] = ranges.positives()
    """Limits of their jerk, which count where targets are held; the model's when empty."""
    moving: float = ranges.number(0.0, most=0.99)
    """Largest rate of a joint at t = 0 where accelerations are limited [of its full speed]."""
    floor: float = ranges.number(1.0)
    """Share of arms that stand on a floor; arms that are mostly below it have none."""
    floor_height: ranges.Range = ranges.span(0.0, 0.0, -10.0, 10.0)
    """Height of the floor above the base [reaches]."""

    def __post_init__(self) -> None:
        """Check the fields, the model and the number of limits."""
        super().__post_init__()
        dof = model_of(self.model).dof
        for name in ("accelerations", "jerks"):
            limits = getattr(self, name)
            if limits and len(limits) != dof:
                reason = f"must have {dof} limits, one for each joint (got {show(limits)})"
                raise FamilyError(name, reason)

    @property
    def gravity(self) -> float:
        """Acceleration of falling bodies [lengths/s^2]."""
        return EARTH / self.metres

    def arm(self, rng: np.random.Generator) -> Chain:
        """Draw a chain in the middle of its joints' ranges, its base at the origin."""
        model = model_of(self.model)
        middle = tuple(0.5 * (low + high) for low, high in model.ranges)
        given: dict[str, Any] = {}
        if self.accelerations:
            given["max_joint_acceleration"] = self.accelerations
        if self.jerks:
            given["max_joint_jerk"] = self.jerks
        arm = Chain(model, middle, 0.0, **given)
        speed = ranges.pick(rng, self.hand_speed) * arm.reach
        return Chain(
            model,
            middle,
            ranges.pick(rng, self.grasp) * arm.reach,
            max_hand_speed=speed if speed > 0.0 else None,
            **given,
        )

    def rates(self, rng: np.random.Generator, arm: Chain) -> tuple[float, ...] | None:
        """Draw rates at t = 0 (n,) of an arm with limits of acceleration; else return None."""
        if arm.max_joint_acceleration is None:
            return None
        top = np.array(arm.max_joint_speed)
        return tuple((self.moving * top * rng.uniform(-1.0, 1.0, top.size)).tolist())


Maker = Callable[[np.random.Generator, Stage, Way, int], Body]
STORIES = 30  # that are drawn at most until both ends of the way are free
INNER = 0.6  # share of a limb's points, carried least by a way, at which no body is aimed
EARLY, LATE = 0.25, 0.95  # places on the way at which bodies are aimed, as shares of it


class Story(NamedTuple):
    """Bodies of a situation, and one way of the arm to a catch."""

    way: Way
    bodies: tuple[Body, ...]
    """Targets and obstacles, without the floor [the arm's unit]."""
    catch: str = "any"
    """Targets to be caught: any, all or most."""
    under: tuple[str, ...] = ()
    """Obstacles on which targets lie."""


@dataclass(frozen=True)
class ChainFamily(Family):
    """Base of families for chains.

    A random posture is the start, another one meets the target. Both are free when the arm is
    there. Nothing is rejected for being easy.
    """

    kind: ClassVar[str] = "chain"

    arm: ChainArmRanges = field(default_factory=ChainArmRanges)
    takes: ranges.Range = ranges.span(0.15, 0.6, most=0.9)
    """Duration of the straight way of the joints at full speed [horizons]."""
    when: ranges.Range = ranges.span(0.55, 0.95, 0.05, 0.97)
    """Time of the meeting [horizons]; later if the straight way takes longer."""
    target: ranges.Range = ranges.span(0.007, 0.02, TINY)
    """Radius of targets [reaches]."""
    directed: float = ranges.number(0.0)
    """Share of situations whose targets prescribe an approach: the hand's direction on its way."""
    within: ranges.Range = ranges.span(0.436, 0.436, most=3.14)
    """Angle that the hand may be off the approach [rad]."""
    strays: ranges.Counts = ranges.counts(0, 1)
    """Number of balls that fly across the way."""
    stray: ranges.Range = ranges.span(0.045, 0.085, TINY)
    """Radius of these balls [reaches]."""
    speed: ranges.Range = ranges.span(0.2, 0.8)
    """Their speed [reaches/s]."""
    holds: Holds = field(default_factory=Holds)
    bins: Bins = field(default_factory=Bins)
    measured: Measured = field(default_factory=Measured)

    def sketch(self, rng: np.random.Generator, name: str) -> Situation[Chain]:
        """Draw once."""
        arm, horizon = self.arm.arm(rng), ranges.pick(rng, self.arm.horizon)
        floor = None
        if rng.random() < self.arm.floor:
            floor = ranges.pick(rng, self.arm.floor_height) * arm.reach
        stage = stage_of(rng, arm, horizon, self.arm.gravity, floor)
        directed = rng.random() < self.directed
        for _ in range(STORIES):
            story = self.story(rng, stage)
            if stage.fits(story.way, story.bodies):
                break
        else:
            story = story._replace(bodies=_kept(stage, story))
        way = story.way
        strays = aimed(rng, stage, way, self._stray, ranges.pick_count(rng, self.strays))
        shown = self.measured.of(rng, stage, way, (*story.bodies, *strays))
        bodies = (*shown, *stage.floor)
        start: Any = tuple(way.start.tolist())
        arm = replace(stage.arm, joints=start, joint_rates=self.arm.rates(rng, stage.arm))
        situation = Situation(name, horizon, arm, bodies, catch=story.catch)
        situation = self._directed(rng, situation, way) if directed else situation
        situation = self.holds.ask(rng, situation, arm.reach)
        held = situation.targets[0].hold is not None
        if held and rng.random() < self.bins.share:
            situation = self.bins.ask(rng, stage, way, situation, story.under)
        return situation

    @abstractmethod
    def story(self, rng: np.random.Generator, stage: Stage) -> Story:
        """Draw one story."""

    def way(
        self,
        rng: np.random.Generator,
        stage: Stage,
        may_end: Callable[[np.ndarray, np.ndarray], np.ndarray] | None = None,
    ) -> Way:
        """Draw a way.

        Parameters
        ----------
        rng : numpy.random.Generator
        stage : Stage
        may_end : callable, optional
            Of hands (k, 3) and their axes (k, 3): the postures that may be the end (k,).
        """
        ends = None if may_end is None else may_end(*stage.hands())
        return stage.way(rng, self.takes, self.when, ends)

    def ball(
        self,
        rng: np.random.Generator,
        stage: Stage,
        place: np.ndarray,
        when: float,
        velocity: Any = (0.0, 0.0, 0.0),
        pull: Any = (0.0, 0.0, 0.0),
    ) -> Body:
        """The target: a ball that is at a place (3,) at a time, with a velocity at t = 0."""
        shape = Sphere(stage.size(rng, self.target))
        return solid("target", shape, place, when=when, velocity=velocity, pull=pull)

    def _stray(self, rng: np.random.Generator, stage: Stage, way: Way, k: int) -> Body:
        """A ball that flies through a place on the way when the arm is there."""
        place, when = on_the_way(rng, stage, way)
        course = stage.size(rng, self.speed) * unit_vector(rng.normal(size=3))
        shape = Sphere(stage.size(rng, self.stray))
        return solid(f"ball {k + 1}", shape, place, when=when, velocity=course)

    def _directed(
        self, rng: np.random.Generator, situation: Situation[Chain], way: Way
    ) -> Situation[Chain]:
        """The situation with the hand's direction at the way's end as approach of all targets."""
        within, bodies = ranges.pick(rng, self.within), []
        for k, body in enumerate(situation.bodies):
            if body.role == "target":
                _, turn = pose(situation, k, way.when)
                approach = Approach(triple(turn.T @ way.axis), within)
                body = replace(body, approach=(approach,))
            bodies.append(body)
        return replace(situation, bodies=tuple(bodies))


def on_the_way(rng: np.random.Generator, stage: Stage, way: Way) -> tuple[np.ndarray, float]:
    """Draw a point (3,) on a link along a way, and the time at which the link is there [s].

    Points that the way carries far are preferred: others cannot be elsewhere at that time.
    """
    share = ranges.pick(rng, (EARLY, LATE))
    first, there, last = stage.points(np.stack([way.start, way.at(share), way.end]))
    carried = np.minimum(
        np.linalg.norm(there - first, axis=1), np.linalg.norm(last - first, axis=1)
    )
    far = np.flatnonzero(carried >= np.quantile(carried, INNER))
    return there[int(rng.choice(far))], share * way.when


def aimed(rng: np.random.Generator, stage: Stage, way: Way, make: Maker, count: int) -> list[Body]:
    """Draw bodies that fit the way, each in up to ten draws; leave out bodies that never fit.

    Parameters
    ----------
    rng : numpy.random.Generator
    stage : Stage
    way : Way
    make : callable
        ``make(rng, stage, way, k)`` draws body k.
    count : int
        Number of bodies that are tried.
    """
    found = []
    for k in range(count):
        for _ in range(TRIES):
            body = make(rng, stage, way, k)
            if stage.fits(way, (body,)):
                found.append(body)
                break
    return found


def level(v: np.ndarray) -> np.ndarray:
    """The unit vector (3,) of the horizontal part of a vector."""
    return unit_vector(v * (1.0, 1.0, 0.0))


def facing(way: Way) -> np.ndarray:
    """Axes (3, 3), as columns: the hand's way in, sideways, and as near to up as can be."""
    frame = axes_along(way.axis)
    return np.column_stack([frame[:, 2], -frame[:, 1], frame[:, 0]])


def _kept(stage: Stage, story: Story) -> tuple[Body, ...]:
    """Return the bodies of a story without obstacles that block an end of its way."""
    bodies: Sequence[Body] = story.bodies
    return tuple(b for b in bodies if b.role == "target" or stage.fits(story.way, (b,)))
