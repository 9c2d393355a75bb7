"""Targets that are carried: capsules in the frame of the hand's joint, until they are placed."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from gcm_learn.referee.catching import Catch
from gcm_learn.referee.chain import ChainMotion, Geometry
from gcm_learn.referee.contact import Watched
from gcm_learn.referee.curves import Curve
from gcm_learn.referee.motions import Body
from gcm_learn.referee.rotations import Array
from gcm_learn.referee.tolerances import NEAR, Complaint


def capsule_of(shape: dict[str, Any]) -> tuple[Array, float]:
    """Return half the axis (3,), in the frame of the body, and the radius of a carried shape."""
    if shape["kind"] != "box":
        return np.array([0.0, 0.0, shape.get("half_length", 0.0)]), float(shape["radius"])
    half = np.array(shape["half_extents"], dtype=float)
    axis = np.eye(3)[half.argmax()] * half.max()
    return axis, float(np.linalg.norm(half - axis))


class Carry:
    """A target that stays in the hand from the end of its hold to its place."""

    def __init__(
        self, geometry: Geometry, curve: Curve, joint: int, body: Body, catch: Catch
    ) -> None:
        assert catch.held_until is not None and catch.placed is not None
        self.geometry, self.curve, self.joint, self.body = geometry, curve, joint, body
        self.held, self.placed = catch.held_until, catch.placed
        frames, origins = geometry.frames(curve.joints(np.array([self.held])))
        (centre,), (turn,) = body.poses(np.array([self.held]))
        half, self.radius = capsule_of(body.shape)
        self.centre = (centre - origins[joint, 0]) @ frames[joint, 0]
        self.half = (turn @ half) @ frames[joint, 0]

    def misplaced(self) -> list[Complaint]:
        """Return a complaint if the target is placed somewhere else."""
        joints = self.curve.joints(np.array([self.placed]))
        asked = self.body.given["place"]
        apart = self.geometry.point(joints, self.joint, self.centre)[0] - asked["position"]
        off = float(np.linalg.norm(apart))
        if off <= asked["within"] + NEAR:
            return []
        what = f"{self.body.name} is placed {off:.9g} away, allowed {asked['within']:g}"
        return [Complaint("catches", what, self.placed)]

    def watched(self, size: float) -> list[Watched]:
        """Return the capsule's movement, in parts with the obstacles that each part ignores."""
        axes = np.array([[self.centre - self.half, self.centre + self.half]])
        none = np.zeros((0, 2), dtype=int)
        link = replace(
            self.geometry,
            carriers=np.array([self.joint]),
            axes=axes,
            radii=np.array([self.radius]),
            pairs=none,
        )
        supports = {(0, name) for name in self.body.given.get("ignore", ())}
        brief = self.body.given.get("ignore_for", math.inf)
        parts = [(self.held, self.placed, supports)]
        if self.held + brief < self.placed - brief:
            lifted, lowered = self.held + brief, self.placed - brief
            parts = [(self.held, lifted, supports), (lowered, self.placed, supports)]
            parts.append((lifted, lowered, set()))
        return [
            Watched(ChainMotion(link, self.curve, size, (a, b)), ignored, self.body.name)
            for a, b, ignored in parts
        ]
