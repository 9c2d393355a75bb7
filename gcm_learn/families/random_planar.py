"""Random planar situations: the same laws as the pilot measurements, one to five moving bodies."""

from __future__ import annotations

import numpy as np

from gcm_learn.errors import SituationError
from gcm_learn.situation import Arm, Body, Disc, PlanarQuadratic, Polygon, Situation
from gcm_learn.situation.shapes import Shape

SPEED = 3.3  # largest hand speed [forearm lengths / s]: kappa is about 1/400 s on 80 cells
HORIZON = 1.2  # [s], about 480 tau
BODY_SPEED = 1.2  # largest body speed, in hand speeds
ATTEMPTS = 100


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
    count = int(rng.integers(bodies[0], bodies[1] + 1))
    elbow = "right" if rng.random() < 0.5 else "left"
    upper_arm = float(rng.uniform(0.8, 1.2))
    angle = rng.uniform(-np.pi, np.pi)
    radius = rng.uniform(abs(upper_arm - 1.0) + 0.35, upper_arm + 0.9)
    arm = Arm(
        hand=(radius * np.cos(angle), radius * np.sin(angle)),
        max_hand_speed=SPEED,
        upper_arm=upper_arm,
        elbow=elbow,
        thickness=float(rng.choice([0.0, 0.03])),
    )
    target = Body("target", "target", Disc(float(rng.uniform(0.04, 0.12))), _motion(rng))
    obstacles = [
        Body("obstacle", f"obstacle {k}", _shape(rng), _motion(rng)) for k in range(1, count)
    ]
    return Situation(name, HORIZON, arm, (target, *obstacles))


def _motion(rng: np.random.Generator) -> PlanarQuadratic:
    """Start anywhere in view; 70 % move, half of those accelerate."""
    position = (float(rng.uniform(-2.0, 2.0)), float(rng.uniform(-2.0, 2.0)))
    if rng.random() < 0.3:
        return PlanarQuadratic(position, (0.0, 0.0), (0.0, 0.0), float(rng.uniform(0, np.pi)), 0.0)
    heading = rng.uniform(-np.pi, np.pi)
    speed = rng.uniform(0.0, BODY_SPEED * SPEED)
    velocity = (float(speed * np.cos(heading)), float(speed * np.sin(heading)))
    acceleration = (0.0, float(-rng.uniform(0.0, 6.0))) if rng.random() < 0.5 else (0.0, 0.0)
    spin = float(rng.uniform(-8.0, 8.0))
    return PlanarQuadratic(position, velocity, acceleration, float(rng.uniform(0, np.pi)), spin)


def _shape(rng: np.random.Generator) -> Shape:
    """A disc, a bar or an irregular polygon."""
    kind = rng.integers(3)
    if kind == 0:
        return Disc(float(rng.uniform(0.05, 0.25)))
    if kind == 1:
        length, width = float(rng.uniform(0.1, 0.5)), float(rng.uniform(0.02, 0.1))
        return Polygon(((-length, -width), (length, -width), (length, width), (-length, width)))
    for _ in range(ATTEMPTS):
        angles = np.sort(rng.uniform(-np.pi, np.pi, size=int(rng.integers(3, 8))))
        radii = rng.uniform(0.08, 0.3, size=angles.size)
        points = np.stack([radii * np.cos(angles), radii * np.sin(angles)], axis=-1)
        try:
            return Polygon(tuple((float(x), float(y)) for x, y in points))
        except SituationError:
            continue  # clockwise or crossing: draw again
    raise SituationError("vertices", f"no simple polygon in {ATTEMPTS} draws")
