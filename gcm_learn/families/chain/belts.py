"""Parts that are carried past: on a belt behind posts, or on a turntable."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from gcm_learn.arms import quaternion_of
from gcm_learn.families import ranges
from gcm_learn.families.chain.family import ChainFamily, Story, level
from gcm_learn.families.chain.motions import circling, orbiting
from gcm_learn.families.chain.stage import Stage, Way
from gcm_learn.families.solids import UP, axes_along, crossed, flight, solid, triple
from gcm_learn.situation import Body, Box, Capsule, Cylinder, Sphere

STEEP = 0.35  # height of directions from which parts are picked: at most a little upwards


def downward(hands: np.ndarray, axes: np.ndarray) -> np.ndarray:
    """Return which hands (k, 3) reach level or down, by their axes (k, 3)."""
    return axes[:, 2] < STEEP


@dataclass(frozen=True)
class ConveyorChain(ChainFamily):
    """Parts on a belt behind a row of posts, among boxes; the arm picks one or several parts."""

    name = "conveyor-chain"
    summary = "parts on a belt among boxes, behind a row of posts"

    directed: float = ranges.number(1.0)
    """Share of situations whose targets prescribe an approach: the hand's direction on its way."""
    pace: ranges.Range = ranges.span(0.1, 0.5)
    """Speed of the belt [reaches/s]."""
    slant: ranges.Range = ranges.span(-0.5, 0.5, -1.5, 1.5)
    """Direction of the belt, from across the way out [rad]."""
    parts: ranges.Counts = ranges.counts(1, 3, 1)
    """Number of targets; all or most of several are to be caught."""
    sides: ranges.Range = ranges.span(0.0, 0.0)
    """Half the sides of parts that are boxes and lie on the belt; balls at 0 [reaches]."""
    spacing: ranges.Range = ranges.span(0.08, 0.2, 0.01)
    """Between things on the belt [reaches]."""
    boxes: ranges.Counts = ranges.counts(1, 3)
    """Number of boxes on the belt."""
    box: ranges.Range = ranges.span(0.03, 0.065, 1e-3)
    """Half their sides [reaches]."""
    posts: ranges.Counts = ranges.counts(3, 5)
    """Number of posts."""
    gap: ranges.Range = ranges.span(0.095, 0.12, 0.01)
    """Half the distance between neighbouring posts [reaches]."""
    before: ranges.Range = ranges.span(0.06, 0.14, 0.01)
    """From the belt's middle to the posts [reaches]."""
    post: ranges.Range = ranges.span(0.014, 0.028, 1e-3)
    """Radius of posts [reaches]."""
    tall: ranges.Range = ranges.span(0.14, 0.32, 0.01)
    """Half their height [reaches]."""

    def story(self, rng: np.random.Generator, stage: Stage) -> Story:
        """Parts, boxes, the belt, posts."""
        way = self.way(rng, stage, downward)
        out, angle = level(way.meet), ranges.pick(rng, self.slant)
        along = math.cos(angle) * crossed(UP, out) + math.sin(angle) * out
        axes, pace = axes_along(UP, along), ranges.pick_sign(rng) * stage.size(rng, self.pace)
        course = pace * axes[:, 0]
        parts = self._parts(rng, stage, way, course)
        lying = self._lying(rng, stage)
        if lying is not None:
            turn = quaternion_of(axes)
            laws = (replace(flight(part), orientation=turn) for part in parts)
            parts = [replace(p, shape=lying, motion=m) for p, m in zip(parts, laws, strict=True)]
        goods = self._boxes(rng, stage, way, axes, course, lying)
        catch = "any" if len(parts) == 1 else ranges.choose(rng, ("all", "most"))
        posts = self._posts(rng, stage, way, axes, out)
        under = () if lying is None else ("belt",)
        return Story(way, (*parts, *goods, *posts), catch, under)

    def _lying(self, rng: np.random.Generator, stage: Stage) -> Box | None:
        """Draw the box that all parts are, if they are boxes."""
        if self.sides[1] == 0.0:
            return None
        return Box(triple([stage.size(rng, self.sides) for _ in range(3)]))

    def _parts(
        self, rng: np.random.Generator, stage: Stage, way: Way, course: np.ndarray
    ) -> list[Body]:
        """Draw the targets: one at the meeting, the others behind it on the belt."""
        parts = [self.ball(rng, stage, way.meet, way.when, course)]
        along, far = course / max(float(np.linalg.norm(course)), 1e-9), 0.0
        for k in range(1, ranges.pick_count(rng, self.parts)):
            far += stage.size(rng, self.spacing)
            other = self.ball(rng, stage, way.meet - far * along, way.when, course)
            parts.append(replace(other, name=f"part {k + 1}"))
        return parts

    def _boxes(
        self, rng: np.random.Generator, stage: Stage, way: Way, axes: np.ndarray,
        course: np.ndarray, lying: Box | None,
    ) -> list[Body]:  # fmt: skip
        """Draw the belt and the boxes on it, before and after the meeting's place."""
        reach = stage.arm.reach
        belt = Box((0.42 * reach, 0.056 * reach, 0.014 * reach))
        low = 0.07 * reach if lying is None else lying.half_extents[2] + belt.half_extents[2]
        bodies = [solid("belt", belt, way.meet - low * UP, axes)]
        for k in range(ranges.pick_count(rng, self.boxes)):
            x, y, z = (stage.size(rng, self.box) for _ in range(3))
            far = ranges.pick_sign(rng) * (x + stage.size(rng, self.spacing))
            beside = rng.uniform(-0.03, 0.03) * reach
            place = way.meet + far * axes[:, 0] + beside * axes[:, 1]
            box = Box((x, y, z))
            bodies.append(solid(f"box {k + 1}", box, place, axes, when=way.when, velocity=course))
        return bodies

    def _posts(
        self, rng: np.random.Generator, stage: Stage, way: Way, axes: np.ndarray, out: np.ndarray
    ) -> list[Body]:
        """A row of posts between arm and belt, with a gap before the meeting's place."""
        count, gap = ranges.pick_count(rng, self.posts), 2.0 * stage.slot(rng, self.gap)
        nearer = -axes[:, 1] * math.copysign(1.0, float(axes[:, 1] @ out))
        row = way.meet + stage.size(rng, self.before) * nearer
        first = -(count // 2) + 0.5
        bodies = []
        for k in range(count):
            half = stage.size(rng, self.tall)
            shape = Capsule(stage.size(rng, self.post), half)
            high = rng.uniform(-0.5, 0.5) * half
            place = row + (first + k) * gap * axes[:, 0] + high * UP
            bodies.append(solid(f"post {k + 1}", shape, place))
        return bodies


@dataclass(frozen=True)
class TurntableChain(ChainFamily):
    """A part rides round on a turntable, among pegs that turn with it."""

    name = "turntable-chain"
    summary = "a part on a turntable, among pegs and a fin that turn with it"

    directed: float = ranges.number(0.5)
    """Share of situations whose targets prescribe an approach: the hand's direction on its way."""
    rate: ranges.Range = ranges.span(0.5, 3.0)
    """Rate of the turntable, either way [rad/s]."""
    radius: ranges.Range = ranges.span(0.08, 0.22, 0.01)
    """From its axis to the part [reaches]."""
    pegs: ranges.Counts = ranges.counts(2, 5)
    """Number of pegs."""
    peg: ranges.Range = ranges.span(0.014, 0.03, 1e-3)
    """Radius of pegs [reaches]."""
    tall: ranges.Range = ranges.span(0.06, 0.16, 1e-3)
    """Half their height [reaches]."""
    fins: float = ranges.number(0.4)
    """Share of turntables with a fin across the middle."""

    def story(self, rng: np.random.Generator, stage: Stage) -> Story:
        """A part, the turntable, pegs, a fin."""
        way, angle = self.way(rng, stage, downward), ranges.pick_angle(rng)
        radius, rate = (
            stage.size(rng, self.radius),
            ranges.pick_sign(rng) * ranges.pick(rng, self.rate),
        )
        side = np.array([math.cos(angle), math.sin(angle), 0.0])
        middle, reach = way.meet - radius * side, stage.arm.reach
        low, thin = 0.05 * reach, 0.012 * reach
        part = solid("target", Sphere(stage.size(rng, self.target)), way.meet)
        table = Cylinder(1.4 * radius, thin)
        if self.holds.share > 0.0:  # samples end at the horizon, holds may go on
            part = orbiting(part, middle, rate, way.when)
        else:
            part = circling(part, middle, rate, way.when, stage.horizon)
        bodies = [part, solid("turntable", table, middle - low * UP)]
        foot = middle - low * UP
        for k in range(ranges.pick_count(rng, self.pegs)):
            there = angle + rng.uniform(0.7, 2.0 * math.pi - 0.7)
            far, half = radius * rng.uniform(0.5, 1.3), stage.size(rng, self.tall)
            place = foot + far * np.array([math.cos(there), math.sin(there), 0.0]) + half * UP
            peg = solid(f"peg {k + 1}", Capsule(stage.size(rng, self.peg), half), place)
            bodies.append(circling(peg, middle, rate, way.when, stage.horizon))
        if rng.random() < self.fins:
            first = angle + rng.uniform(0.9, math.pi - 0.9) - rate * way.when
            axes = axes_along(UP, (math.cos(first), math.sin(first), 0.0))
            shape = Box((1.2 * radius, 0.008 * stage.arm.reach, stage.size(rng, self.tall)))
            bodies.append(solid("fin", shape, middle, axes, spin=(0.0, 0.0, rate)))
        return Story(way, tuple(bodies))
