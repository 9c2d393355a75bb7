"""Situations turned, mirrored and carried about: what a planner answers must follow."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gcm_learn.situation import Pendulum, Plane, Polygon
from tests.referee import of_quaternion


def turned(situation, angle):
    """Turn a planar situation about the shoulder, counter-clockwise."""
    c, s = np.cos(angle), np.sin(angle)
    return _moved(situation, np.array([[c, -s], [s, c]]), angle)


def mirrored(situation):
    """Reflect a planar situation in the x axis; the elbow changes its side."""
    there = _moved(situation, np.array([[1.0, 0.0], [0.0, -1.0]]), None)
    elbow = {"right": "left", "left": "right"}[situation.arm.elbow]
    return replace(there, arm=replace(there.arm, elbow=elbow))


def _moved(situation, matrix, angle):
    """Apply an orthogonal (2, 2) matrix: a turn by `angle`, or a reflection when it is None."""

    def move(vector):
        return tuple(float(v) for v in matrix @ vector)

    bodies = []
    for body in situation.bodies:
        shape, motion = body.shape, body.motion
        if angle is None:
            motion = replace(motion, angle=-motion.angle, spin=-motion.spin)
            if isinstance(shape, Polygon):
                shape = Polygon(tuple((x, -y) for x, y in shape.vertices[::-1]))
        else:
            motion = replace(motion, angle=motion.angle + angle)
        for name in ("position", "velocity", "acceleration"):
            motion = replace(motion, **{name: move(getattr(motion, name))})
        bodies.append(replace(body, shape=shape, motion=motion))
    arm = replace(situation.arm, hand=move(situation.arm.hand))
    return replace(situation, arm=arm, bodies=tuple(bodies))


def carried(situation, rotation, shift):
    """Carry a 3D situation, its plane included, through the world: x -> rotation x + shift."""

    def turn(vector):
        return tuple(float(v) for v in rotation @ vector)

    def place(point):
        return tuple(float(v) for v in rotation @ point + shift)

    bodies = []
    for body in situation.bodies:
        motion = body.motion
        if isinstance(motion, Pendulum):
            motion = replace(
                motion,
                pivot=place(motion.pivot),
                axis=turn(motion.axis),
                down=turn(motion.down),
            )
        else:
            motion = replace(
                motion,
                position=place(motion.position),
                velocity=turn(motion.velocity),
                acceleration=turn(motion.acceleration),
                orientation=quaternion_of(rotation @ of_quaternion(motion.orientation)),
                spin=turn(motion.spin),
            )
        bodies.append(replace(body, motion=motion))
    plane = situation.plane
    plane = Plane(place(plane.origin), turn(plane.x), turn(plane.y))
    return replace(situation, bodies=tuple(bodies), plane=plane)


def quaternion_of(rotation):
    """Unit quaternion (w, x, y, z) of a rotation matrix, as an eigenvector."""
    r = np.asarray(rotation)
    symmetric = np.zeros((4, 4))
    symmetric[0, 0] = np.trace(r)
    symmetric[0, 1:] = symmetric[1:, 0] = [r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]]
    symmetric[1:, 1:] = r + r.T - np.trace(r) * np.eye(3)
    return tuple(float(v) for v in np.linalg.eigh(symmetric)[1][:, -1])
