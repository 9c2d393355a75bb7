"""Random 3D situations: solids of all kinds fly, spin and swing through the arm's plane."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gcm_learn import situation
from gcm_learn.arms import Arm, rotation_of
from gcm_learn.families.family import TINY, PlanarFamily
from gcm_learn.families.layout import polar
from gcm_learn.families.ranges import Counts, Range, number, pick, pick_angle, pick_count, span

Vector3 = tuple[float, float, float]


@dataclass(frozen=True)
class RandomSolid(PlanarFamily):
    """An arm's plane anywhere in space, which every body crosses within reach at some time.

    Half of the pendulums are cords; all other bodies fly, and most of them spin.
    """

    name = "random-solid"
    summary = "spheres, boxes, capsules and cylinders that fly, spin and swing through the plane"

    target: Range = span(0.06, 0.15, TINY)
    """Sizes of the target [forearms]."""
    size: Range = span(0.04, 0.3, TINY)
    """Sizes of obstacles: radii, half lengths, half extents [forearms]."""
    speed: Range = span(-0.3, 0.3, -100.0)
    """Components of velocities in the plane when it is crossed [hand speeds]."""
    crossing: Range = span(-0.18, 0.18, -100.0)
    """Components along its normal [hand speeds]."""
    acceleration: Range = span(-0.18, 0.18, -100.0)
    """Components, for half of those that fly [squared hand speeds per forearm]."""
    spin: Range = span(-1.8, 1.8, -100.0)
    """Components, for 70 % of those that fly [hand speeds per forearm]."""
    swinging: float = number(0.3)
    """Share of pendulums."""
    length: Range = span(0.3, 1.5, 0.01)
    """Of pendulums [forearms]."""
    gravity: Range = span(0.0, 3.6)
    """Of pendulums [squared hand speeds per forearm]."""

    def sketch(self, rng: np.random.Generator, name: str) -> situation.Situation:
        """Draw once, the limb free or not."""
        frame, centre = random_rotation(rng), rng.uniform(-1.0, 1.0, 3)
        plane = situation.Plane(_triple(centre), _triple(frame[0]), _triple(frame[1]))
        arm, horizon = self.arm.draw(rng)
        sizes = [("target", self.target)]
        for k in range(pick_count(rng, self.obstacles)):
            sizes.append((f"obstacle {k + 1}", self.size))
        bodies = []
        for title, ends in sizes:
            x, y = polar(pick(rng, self.arm.radii(arm.upper_arm)), pick_angle(rng))
            motion = self._motion(rng, centre + (x, y, 0.0) @ frame, frame, arm, horizon)
            bodies.append(situation.Body(title.split()[0], title, random_shape(rng, ends), motion))
        return situation.Situation(name, horizon, arm, tuple(bodies), plane)

    def _motion(
        self,
        rng: np.random.Generator,
        meeting: np.ndarray,
        frame: np.ndarray,
        arm: Arm,
        horizon: float,
    ) -> situation.SolidMotion:
        """Be at a place of the plane at some moment of the horizon."""
        hand = arm.max_hand_speed
        if rng.random() < self.swinging:
            return self._swing(rng, meeting, hand)
        when = horizon * rng.random()
        own = (pick(rng, self.speed), pick(rng, self.speed), pick(rng, self.crossing))
        velocity = hand * np.array(own) @ frame
        pull = self._three(rng, self.acceleration, hand**2 if rng.random() < 0.5 else 0.0)
        turn = rng.normal(size=4)
        return situation.SolidQuadratic(
            position=_triple(meeting - velocity * when - 0.5 * pull * when**2),
            velocity=_triple(velocity),
            acceleration=_triple(pull),
            orientation=tuple((turn / np.linalg.norm(turn)).tolist()),
            spin=_triple(self._three(rng, self.spin, hand if rng.random() < 0.7 else 0.0)),
        )

    def _swing(
        self, rng: np.random.Generator, meeting: np.ndarray, hand: float
    ) -> situation.Pendulum:
        """A pendulum that passes a place at angle 0."""
        frame, length = random_rotation(rng), pick(rng, self.length)
        return situation.Pendulum(
            pivot=_triple(meeting - length * frame[1]),
            axis=_triple(frame[0]),
            down=_triple(frame[1]),
            length=length,
            gravity=pick(rng, self.gravity) * hand**2,
            angle=pick(rng, (-1.5, 1.5)),
            rate=pick(rng, (-0.6, 0.6)) * hand,
            damping=0.5 * float(rng.integers(2)),
            hang=None if rng.random() < 0.5 else 0.5 * length,
        )

    @staticmethod
    def _three(rng: np.random.Generator, ends: Range, unit: float) -> np.ndarray:
        """Three components from a range (3,), times a unit."""
        return unit * np.array([pick(rng, ends) for _ in range(3)])


def random_solid(
    rng: np.random.Generator, obstacles: Counts = (1, 4), name: str = "random solid"
) -> situation.Situation:
    """Draw a 3D situation once; the limb may touch an obstacle at t = 0.

    Parameters
    ----------
    rng : numpy.random.Generator
    obstacles : (int, int)
        Smallest and largest number of obstacles.
    name : str
        Of the situation; names must be unique in a file.

    Returns
    -------
    Situation
    """
    return RandomSolid(obstacles=obstacles).sketch(rng, name)


def random_rotation(rng: np.random.Generator) -> np.ndarray:
    """A rotation matrix (3, 3), all equally likely."""
    turn = rng.normal(size=4)
    return rotation_of(turn.tolist())


def random_shape(rng: np.random.Generator, size: Range) -> situation.SolidShape:
    """Draw a solid of any kind, with sizes from a range [forearms]."""
    a, b, c = (pick(rng, size) for _ in range(3))
    return (
        situation.Sphere(a),
        situation.Box((a, b, c)),
        situation.Capsule(0.5 * a, b),
        situation.Cylinder(a, b),
    )[int(rng.integers(4))]


def _triple(vector: np.ndarray) -> Vector3:
    """An array (3,) as the tuple that records hold."""
    x, y, z = vector.tolist()
    return x, y, z
