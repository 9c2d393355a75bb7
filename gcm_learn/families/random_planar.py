"""Random planar situations: the same laws as the pilot measurements, one to five moving bodies."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from gcm_learn.arms import Arm
from gcm_learn.errors import SituationError
from gcm_learn.families import ranges
from gcm_learn.families.family import TINY, ArmRanges, PlanarFamily
from gcm_learn.situation import Body, Disc, PlanarQuadratic, Polygon, Shape, Situation

SPEED = 3.3  # largest hand speed [forearm lengths / s]: kappa is about 1/400 s on 80 cells
HORIZON = 1.2  # [s], about 480 tau
ATTEMPTS = 100


def pilot_arm() -> ArmRanges:
    """Return the ranges of the pilot measurements' arms: one hand speed, one horizon."""
    return ArmRanges(hand_speed=(SPEED, SPEED), horizon=(HORIZON, HORIZON))


@dataclass(frozen=True)
class RandomPlanar(PlanarFamily):
    """One target, obstacles anywhere, most bodies moving; nothing is aimed."""

    name = "random-planar"
    summary = "discs, bars and polygons anywhere in the plane, most of them moving"

    arm: ArmRanges = field(default_factory=pilot_arm)
    obstacles: ranges.Counts = ranges.counts(0, 4)
    """Number of obstacles."""
    view: float = ranges.number(2.0, 0.1, 100.0)
    """Bodies start in a square of this half width about the shoulder [forearms]."""
    still: float = ranges.number(0.3)
    """Share of bodies that rest."""
    speed: ranges.Range = ranges.span(0.0, 1.2)
    """Of the others [hand speeds]."""
    fall: ranges.Range = ranges.span(0.0, 6.0 / SPEED**2)
    """Downward acceleration of half of the others [squared hand speeds per forearm]."""
    spin: ranges.Range = ranges.span(-8.0 / SPEED, 8.0 / SPEED, -100.0)
    """Of the others [hand speeds per forearm]."""
    target: ranges.Range = ranges.span(0.04, 0.12, TINY)
    """Radius of the target [forearms]."""
    radius: ranges.Range = ranges.span(0.05, 0.25, TINY)
    """Of discs [forearms]."""
    half_length: ranges.Range = ranges.span(0.1, 0.5, TINY)
    """Of bars [forearms]."""
    half_width: ranges.Range = ranges.span(0.02, 0.1, TINY)
    """Of bars [forearms]."""
    corners: ranges.Range = ranges.span(0.08, 0.3, TINY)
    """Distance of a polygon's three to seven corners from its origin [forearms]."""

    def sketch(self, rng: np.random.Generator, name: str) -> Situation:
        """Draw once, the limb free or not."""
        count = ranges.pick_count(rng, self.obstacles)
        arm, horizon = self.arm.draw(rng)
        bodies = [
            Body("target", "target", Disc(ranges.pick(rng, self.target)), self._motion(rng, arm))
        ]
        for k in range(1, count + 1):
            shape = self._shape(rng)
            bodies.append(Body("obstacle", f"obstacle {k}", shape, self._motion(rng, arm)))
        return Situation(name, horizon, arm, tuple(bodies))

    def _motion(self, rng: np.random.Generator, arm: Arm) -> PlanarQuadratic:
        """Start anywhere in the drawn area; half of the bodies that move accelerate."""
        hand, ends = arm.max_hand_speed, (-self.view, self.view)
        position = (ranges.pick(rng, ends), ranges.pick(rng, ends))
        if rng.random() < self.still:
            return PlanarQuadratic(position, (0.0, 0.0), (0.0, 0.0), math.pi * rng.random(), 0.0)
        heading, speed = ranges.pick_angle(rng), ranges.pick(rng, self.speed) * hand
        velocity = (speed * math.cos(heading), speed * math.sin(heading))
        falls = rng.random() < 0.5
        acceleration = (0.0, -ranges.pick(rng, self.fall) * hand**2) if falls else (0.0, 0.0)
        spin = ranges.pick(rng, self.spin) * hand
        return PlanarQuadratic(position, velocity, acceleration, math.pi * rng.random(), spin)

    def _shape(self, rng: np.random.Generator) -> Shape:
        """A disc, a bar or an irregular polygon."""
        kind = rng.integers(3)
        if kind == 0:
            return Disc(ranges.pick(rng, self.radius))
        if kind == 1:
            length, width = ranges.pick(rng, self.half_length), ranges.pick(rng, self.half_width)
            return Polygon(((-length, -width), (length, -width), (length, width), (-length, width)))
        for _ in range(ATTEMPTS):
            angles = sorted(ranges.pick_angle(rng) for _ in range(rng.integers(3, 8)))
            radii = [ranges.pick(rng, self.corners) for _ in angles]
            pairs = zip(radii, angles, strict=True)
            try:
                return Polygon(tuple((r * math.cos(a), r * math.sin(a)) for r, a in pairs))
            except SituationError:
                continue  # clockwise or crossing: draw again
        raise SituationError("vertices", f"no simple polygon in {ATTEMPTS} draws")


def random_planar(
    rng: np.random.Generator, bodies: tuple[int, int] = (1, 5), name: str = "random planar"
) -> Situation:
    """Draw a planar situation: one target, obstacles anywhere, most bodies moving.

    Parameters
    ----------
    rng : numpy.random.Generator
    bodies : (int, int)
        Smallest and largest number of bodies, the target included.
    name : str
        Of the situation; names must be unique in a file.

    Returns
    -------
    Situation
        Valid by construction; the limb may touch an obstacle at t = 0, and the target may never
        come within reach.
    """
    return RandomPlanar(obstacles=(bodies[0] - 1, bodies[1] - 1)).sketch(rng, name)
