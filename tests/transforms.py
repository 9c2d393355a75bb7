"""Situations turned, mirrored and carried about: what a planner answers must follow."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gcm_learn.referee.rotations import rotations as of_quaternion
from gcm_learn.situation import Pendulum, Plane, Polygon


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

    bodies = tuple(
        replace(body, motion=carried_motion(body.motion, rotation, shift))
        for body in situation.bodies
    )
    plane = situation.plane
    place = tuple((rotation @ plane.origin + shift).tolist())
    plane = Plane(place, tuple((rotation @ plane.x).tolist()), tuple((rotation @ plane.y).tolist()))
    return replace(situation, bodies=bodies, plane=plane)


def carried_motion(motion, matrix, shift):
    """Carry a motion of a solid through the world: x -> matrix x + shift, `matrix` orthogonal.

    A reflected body is turned and reflected in its own xz-plane, which changes no solid of ours.
    """
    side = np.linalg.det(matrix)

    def turn(vector):
        return tuple(float(v) for v in matrix @ vector)

    def place(point):
        return tuple(float(v) for v in matrix @ point + shift)

    def axial(vector):
        return tuple(float(v) for v in round(side) * (matrix @ vector))

    if isinstance(motion, Pendulum):
        axis, down = axial(motion.axis), turn(motion.down)
        return replace(motion, pivot=place(motion.pivot), axis=axis, down=down)
    rotation = matrix @ of_quaternion(motion.orientation) @ np.diag([1.0, round(side), 1.0])
    return replace(
        motion,
        position=place(motion.position),
        velocity=turn(motion.velocity),
        acceleration=turn(motion.acceleration),
        orientation=quaternion_of(rotation),
        spin=axial(motion.spin),
    )


def quaternion_of(rotation):
    """Unit quaternion (w, x, y, z) of a rotation matrix, as an eigenvector."""
    r = np.asarray(rotation)
    symmetric = np.zeros((4, 4))
    symmetric[0, 0] = np.trace(r)
    symmetric[0, 1:] = symmetric[1:, 0] = [r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]]
    symmetric[1:, 1:] = r + r.T - np.trace(r) * np.eye(3)
    return tuple(float(v) for v in np.linalg.eigh(symmetric)[1][:, -1])
