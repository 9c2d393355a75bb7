"""Random 3D situations for tests: solids of all kinds that cross the arm's plane."""

from __future__ import annotations

import numpy as np

from gcm_learn.situation import (
    Arm,
    Body,
    Box,
    Capsule,
    Cylinder,
    Pendulum,
    Plane,
    Situation,
    SolidQuadratic,
    Sphere,
)

HORIZON = 1.0  # [s]
SPEED = 3.3  # of the hand [forearm lengths / s]


def random_solid(rng, obstacles=(1, 4)):
    """One target and some obstacles; half of the pendulums are cords, all else flies and spins."""
    frame = random_rotation(rng)
    plane = Plane(tuple(rng.uniform(-1, 1, 3)), tuple(frame[:, 0]), tuple(frame[:, 1]))
    upper_arm = float(rng.uniform(0.8, 1.2))
    radius, angle = (
        rng.uniform(abs(upper_arm - 1.0) + 0.35, upper_arm + 0.9),
        rng.uniform(-3.1, 3.1),
    )
    arm = Arm(
        hand=(radius * np.cos(angle), radius * np.sin(angle)),
        max_hand_speed=SPEED,
        upper_arm=upper_arm,
        elbow=("right", "left")[rng.integers(2)],
        thickness=float(rng.choice([0.0, 0.03])),
    )
    count = int(rng.integers(obstacles[0], obstacles[1] + 1))
    bodies = [Body("target", "target", random_shape(rng, 0.06, 0.15), _motion(rng, plane))]
    for k in range(count):
        bodies.append(Body("obstacle", f"{k}", random_shape(rng, 0.04, 0.3), _motion(rng, plane)))
    return Situation("random solid", HORIZON, arm, tuple(bodies), plane)


def random_rotation(rng):
    """Rotation matrix (3, 3)."""
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return q * np.sign(np.linalg.det(q))


def random_shape(rng, small, large):
    """A solid of any kind, its sizes between `small` and `large`."""
    a, b, c = (float(v) for v in rng.uniform(small, large, 3))
    return (Sphere(a), Box((a, b, c)), Capsule(0.5 * a, b), Cylinder(a, b))[rng.integers(4)]


def _motion(rng, plane):
    """Cross the plane somewhere within reach at some moment of the horizon."""
    x, y, n = np.array(plane.x), np.array(plane.y), np.array(plane.normal)
    polar, reach = rng.uniform(-np.pi, np.pi), rng.uniform(0.3, 1.9)
    meeting = np.array(plane.origin) + reach * (np.cos(polar) * x + np.sin(polar) * y)
    if rng.random() < 0.3:
        return _swing(rng, meeting)
    when = rng.uniform(0.0, HORIZON)
    velocity = rng.uniform(-1.0, 1.0, 2) @ np.stack([x, y]) + rng.uniform(-0.6, 0.6) * n
    acceleration = rng.uniform(-2.0, 2.0, 3) * (rng.random() < 0.5)
    position = meeting - velocity * when - 0.5 * acceleration * when**2
    turn = rng.normal(size=4)
    return SolidQuadratic(
        position=tuple(position),
        velocity=tuple(velocity),
        acceleration=tuple(acceleration),
        orientation=tuple(turn / np.linalg.norm(turn)),
        spin=tuple(rng.uniform(-6.0, 6.0, 3) * (rng.random() < 0.7)),
    )


def _swing(rng, meeting):
    """A pendulum that passes the point at angle 0."""
    frame = random_rotation(rng)
    length = float(rng.uniform(0.3, 1.5))
    return Pendulum(
        pivot=tuple(meeting - length * frame[:, 1]),
        axis=tuple(frame[:, 0]),
        down=tuple(frame[:, 1]),
        length=length,
        gravity=float(rng.uniform(0.0, 40.0)),
        angle=float(rng.uniform(-1.5, 1.5)),
        rate=float(rng.uniform(-2.0, 2.0)),
        damping=float(rng.choice([0.0, 0.5])),
        hang=None if rng.random() < 0.5 else 0.5 * length,
    )
