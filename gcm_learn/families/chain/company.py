"""Others at work: a second arm that moves through the way, and a giver that hands over."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from gcm_learn.arms import Base, hands_along
from gcm_learn.families.chain.family import ChainFamily, Story, aimed, facing, on_the_way
from gcm_learn.families.chain.motions import arriving, shifted
from gcm_learn.families.chain.stage import Stage, Way
from gcm_learn.families.layout import TRIES
from gcm_learn.families.ranges import (
    Counts,
    Range,
    counts,
    number,
    pick,
    pick_angle,
    pick_count,
    span,
)
from gcm_learn.families.solids import UP, axes_along, solid, unit_vector
from gcm_learn.motion import Movement, as_obstacles
from gcm_learn.situation import Body, Box, Capsule, Cylinder, Margin

ERROR = 0.01  # by which links of the second arm are thicker [reaches]


@dataclass(frozen=True)
class OtherArmChain(ChainFamily):
    """A second arm of the same model moves its hand through the way; the target drifts."""

    name = "other-arm-chain"
    summary = "a drifting ball beside a second arm, which moves through the arm's way"

    away: Range = span(0.5, 0.95, 0.05)
    """From base to base [reaches]."""
    drift: Range = span(0.0, 0.3)
    """Speed of the target [reaches/s]."""
    effort: Range = span(0.3, 0.9, 0.01, 1.0)
    """Rates of the second arm's joints, at most [of their full speed]."""

    def story(self, rng: np.random.Generator, stage: Stage) -> Story:
        """Draw a ball and a second arm; no arm if all draws of it block an end of the way."""
        way = self.way(rng, stage)
        course = stage.size(rng, self.drift) * unit_vector(rng.normal(size=3))
        ball = self.ball(rng, stage, way.meet, way.when, course)
        for _ in range(TRIES):
            links = self._links(rng, stage, way)
            if stage.fits(way, links):
                return Story(way, (ball, *links))
        return Story(way, (ball,))

    def _links(self, rng: np.random.Generator, stage: Stage, way: Way) -> tuple[Body, ...]:
        """Draw a second arm's links, its hand at a place on the way when the first arm is there."""
        place, when = on_the_way(rng, stage, way)
        side, turn = pick_angle(rng), pick_angle(rng)
        far = stage.size(rng, self.away)
        rotation = (math.cos(0.5 * turn), 0.0, 0.0, math.sin(0.5 * turn))
        base = Base((far * math.cos(side), far * math.sin(side), 0.0), rotation)
        arm = replace(stage.arm, base=base, ignore=())
        hands, _ = hands_along(arm, stage.joints)
        passing = stage.joints[int(np.argmin(np.linalg.norm(hands - place, axis=1)))]
        effort = pick(rng, self.effort) * np.array(arm.max_joint_speed)
        times, knots = [0.0, when, max(stage.horizon, when + 0.1)], [passing]
        for span_ in (when, times[2] - when):
            other = stage.joints[int(rng.integers(len(stage.joints)))]
            most = effort * span_
            knots.append(passing + np.clip(other - passing, -most, most))
        joints = np.stack([knots[1], knots[0], knots[2]])
        movement = Movement(arm, np.array(times), joints)
        return as_obstacles(movement, "arm", ERROR * arm.reach)


@dataclass(frozen=True)
class HandoverChain(ChainFamily):
    """Somebody brings a part, slows down and holds it out between two fingers."""

    name = "handover-chain"
    summary = "a part that is brought and held out between two fingers"

    directed: float = number(1.0)
    """Share of situations whose targets prescribe an approach: the hand's direction on its way."""
    arrives: Range = span(0.5, 1.0, 0.05, 1.0)
    """Instant at which it is held still [times of the meeting]."""
    brought: Range = span(0.2, 1.0)
    """Speed at t = 0 [reaches/s]."""
    fingers: Range = span(0.06, 0.1, 0.01)
    """Between a finger and the part [reaches]."""
    palm: Range = span(0.07, 0.12, 0.01)
    """From the part to the palm [reaches]."""
    forearm: Range = span(0.1, 0.25, 0.01)
    """Half the length of the giver's forearm [reaches]."""
    drift: Range = span(0.0, 0.0)
    """Speed with which the giver goes straight on then [reaches/s]."""

    def story(self, rng: np.random.Generator, stage: Stage) -> Story:
        """Draw a part, two fingers, a palm and a forearm, all moving together."""
        way, reach = self.way(rng, stage), stage.arm.reach
        speed, ahead = stage.size(rng, self.brought), unit_vector(rng.normal(size=3))
        held = pick(rng, self.arrives) * way.when
        bodies = (self.ball(rng, stage, way.meet, 0.0), *self._giver(rng, stage, way, reach))
        drift = stage.size(rng, self.drift) * ahead + 0.0  # no negative zeros
        there = (shifted(body, (held - way.when) * drift) for body in bodies)
        return Story(way, tuple(arriving(body, held, speed * ahead, drift) for body in there))

    def _giver(
        self, rng: np.random.Generator, stage: Stage, way: Way, reach: float
    ) -> tuple[Body, ...]:
        """A giver that reaches against the hand."""
        axes, far = facing(way), stage.size(rng, self.palm)
        apart, half = stage.slot(rng, self.fingers), stage.size(rng, self.forearm)
        along = axes_along(axes[:, 0])
        finger = Capsule(0.012 * reach, 0.5 * far)
        beside = 0.6 * far * axes[:, 0]
        wrist = way.meet + (far + 0.04 * reach) * axes[:, 0]
        lean = unit_vector(axes[:, 0] + 0.4 * rng.normal(size=3))
        return (
            solid("finger 1", finger, way.meet + beside + apart * axes[:, 1], along),
            solid("finger 2", finger, way.meet + beside - apart * axes[:, 1], along),
            solid("palm", Box((0.02 * reach, apart, 0.04 * reach)), wrist, axes),
            solid("forearm", Capsule(0.035 * reach, half), wrist + half * lean, axes_along(lean)),
        )


@dataclass(frozen=True)
class PersonChain(ChainFamily):
    """Persons who walk past a part on a stand; the later, the less their place is known."""

    name = "person-chain"
    summary = "a part on a stand, and persons who walk past, with margins that grow"

    persons: Counts = counts(2, 3, 1)
    """Number of persons."""
    walk: Range = span(0.4, 1.5)
    """Their speed [reaches/s]."""
    stout: Range = span(0.18, 0.26, 0.01)
    """Their radius [reaches]."""
    tall: Range = span(0.7, 0.85, 0.01)
    """Half the height of their shoulders, less the radius [reaches]."""
    now: Range = span(0.02, 0.05)
    """Margins at t = 0 [reaches]."""
    growth: Range = span(0.02, 0.1)
    """Rates of margins [reaches/s]."""
    stand: Range = span(0.03, 0.06, 0.01)
    """Radius of the stand [reaches]."""

    def story(self, rng: np.random.Generator, stage: Stage) -> Story:
        """A part, a stand, persons."""
        way = self.way(rng, stage, lambda hands, axes: axes[:, 2] < 0.0)
        part = self.ball(rng, stage, way.meet, 0.0)
        thin = 0.012 * stage.arm.reach
        low = way.meet - (part.shape.bounding_radius + thin) * UP
        stand = solid("stand", Cylinder(stage.size(rng, self.stand), thin), low)
        persons = aimed(rng, stage, way, self._person, pick_count(rng, self.persons))
        return Story(way, (part, stand, *persons), under=("stand",))

    def _person(self, rng: np.random.Generator, stage: Stage, way: Way, k: int) -> Body:
        """Draw a person who walks through a place on the way when the arm is there."""
        place, when = on_the_way(rng, stage, way)
        angle, pace = pick_angle(rng), stage.size(rng, self.walk)
        radius, half = stage.size(rng, self.stout), stage.size(rng, self.tall)
        course = pace * np.array([math.cos(angle), math.sin(angle), 0.0])
        there = np.array([place[0], place[1], radius + half])
        body = solid(f"person {k + 1}", Capsule(radius, half), there, when=when, velocity=course)
        margin = Margin(stage.size(rng, self.now), stage.size(rng, self.growth))
        return replace(body, margin=margin)
