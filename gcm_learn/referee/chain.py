"""Chains: frames, links and hand along joints, and bounds of their motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from gcm_learn.referee.curves import Curve
from gcm_learn.referee.rotations import Array, crossing, rotations, unit

ZERO = (0.0, 0.0, 0.0)
COARSE = 32
"""Intervals into which a movement is divided first."""


@dataclass(frozen=True)
class Joint:
    """One joint as arrays, with the fixed rotation before the joint."""

    origin: Array
    axis: Array
    """Direction (3,) in the frame before the joint."""
    slides: bool
    turn: tuple[Array, Array, Array]
    """Parts of the rotation that stay, go with the cosine, and go with the sine."""
    ends: tuple[float, float]
    parent: int
    """Frame on which the joint stands."""


def _joint(given: dict[str, Any], number: int) -> Joint:
    """Return joint `number`, from 1, of an arm file."""
    axis = unit(given["axis"])
    before = rotations(given.get("rotation", (1.0, 0.0, 0.0, 0.0)))
    along = np.outer(axis, axis)
    parts = (before @ along, before @ (np.eye(3) - along), before @ crossing(axis))
    origin = np.array(given.get("origin", ZERO), dtype=float)
    slides = given.get("type", "revolute") == "prismatic"
    low, high = given["range"]
    ends = (float(low), float(high))
    return Joint(origin, before @ axis, slides, parts, ends, given.get("parent", number - 1))


def tree_of(joints: Sequence[dict[str, Any]]) -> tuple[list[Joint], tuple[Array, Array]]:
    """Return the joints of an arm file, and `Geometry.lines`."""
    own = [k for k, joint in enumerate(joints) if "follows" not in joint]
    factors, offsets = np.zeros((len(joints), len(own))), np.zeros(len(joints))
    for k, joint in enumerate(joints):
        line = joint.get("follows", {"joint": k + 1, "factor": 1.0})
        factors[k, own.index(line["joint"] - 1)] = line["factor"]
        offsets[k] = line.get("offset", 0.0)
    return [_joint(joint, k) for k, joint in enumerate(joints, 1)], (factors, offsets)


@dataclass(frozen=True)
class Geometry:
    """Bodies of an open tree of m joints, whose values follow from n coordinates."""

    base: tuple[Array, Array]
    """Origin (3,) and rotation (3, 3) of frame 0 in the world."""
    joints: list[Joint]
    lines: tuple[Array, Array]
    """Factors (m, n) and offsets (m,) of the joints' values."""
    carriers: Array
    """Joints (links,) that carry the links, 0 for the base."""
    axes: Array
    """Ends (links, 2, 3) of the links in the frames of their joints."""
    radii: Array
    pairs: Array = field(default_factory=lambda: np.zeros((0, 2), dtype=int))

    def followed(self, curve: Curve) -> Curve:
        """Return the curve of all m joints by that of the coordinates."""
        factors, offsets = self.lines
        powers = np.einsum("mn,knp->kmp", factors, curve.powers)
        powers[:, :, 0] += offsets
        return Curve(curve.knots, powers)

    def frames(self, joints: Array) -> tuple[Array, Array]:
        """Return frames 0 to m of joints (k, n): rotations (m + 1, k, 3, 3), origins."""
        k = len(joints)
        turn, at = np.broadcast_to(self.base[1], (k, 3, 3)), np.broadcast_to(self.base[0], (k, 3))
        turns, places = [turn], [at]
        joints = joints @ self.lines[0].T + self.lines[1]
        cosine, sine = np.cos(joints)[:, :, None, None], np.sin(joints)[:, :, None, None]
        for j, joint in enumerate(self.joints):
            turn, at = turns[joint.parent], places[joint.parent]
            stay, c, s = joint.turn
            offset = joint.origin
            if joint.slides:
                offset = joint.origin + joints[:, j, None] * joint.axis
                spun = np.broadcast_to(stay + c, (k, 3, 3))
            else:
                spun = stay + cosine[:, j] * c + sine[:, j] * s
            at = at + (turn @ np.broadcast_to(offset, (k, 3))[:, :, None])[:, :, 0]
            turn = turn @ spun
            turns.append(turn)
            places.append(at)
        return np.array(turns), np.array(places)

    def ends(self, joints: Array) -> Array:
        """Return both ends (k, links, 2, 3) of the links' axes, of joints (k, n)."""
        turn, at = self.frames(joints)
        moved = np.einsum("lkij,lej->klei", turn[self.carriers], self.axes)
        return moved + at[self.carriers].transpose(1, 0, 2)[:, :, None]

    def point(self, joints: Array, joint: int, point: Array) -> Array:
        """Return places (k, 3) in the world of a point of a joint's frame."""
        turn, at = self.frames(joints)
        return at[joint] + turn[joint] @ point

    def direction(self, joints: Array, joint: int, axis: Array) -> Array:
        """Return directions (k, 3) in the world of an axis of a joint's frame."""
        return self.frames(joints)[0][joint] @ axis

    def velocity(self, joints: Array, rates: Array, joint: int, point: Array) -> Array:
        """Return velocities (k, 3) of a point of a joint's frame."""
        turn, at = self.frames(joints)
        place = at[joint] + turn[joint] @ point
        total, rates = np.zeros_like(place), rates @ self.lines[0].T
        for j in self.path(joint):
            axis = turn[self.joints[j].parent] @ self.joints[j].axis
            arm = axis if self.joints[j].slides else np.cross(axis, place - at[j + 1])
            total += rates[:, j, None] * arm
        return total

    def path(self, frame: int) -> list[int]:
        """Return the joints (from 0) that move a frame, from the base outwards."""
        path: list[int] = []
        while frame > 0:
            path.insert(0, frame - 1)
            frame = self.joints[frame - 1].parent
        return path

    @cached_property
    def lengths(self) -> Array:
        """Bounds (m,) of the distance between the origins of each frame and the frame before."""
        slide = [max(map(abs, j.ends)) if j.slides else 0.0 for j in self.joints]
        return np.array([np.linalg.norm(j.origin) for j in self.joints]) + slide

    def levers(self, joint: int, reach: float) -> Array:
        """Return ways (m,) of a point of a joint's frame, at most `reach` off, by unit of joint."""
        out = np.zeros(len(self.joints))
        for j in reversed(self.path(joint)):
            out[j] = 1.0 if self.joints[j].slides else reach
            reach += self.lengths[j]
        return out

    @cached_property
    def link_levers(self) -> Array:
        """Ways (links, m) of the links by unit of each joint."""
        reach = np.linalg.norm(self.axes, axis=2).max(axis=1)
        both = zip(self.carriers, reach, strict=True)
        return np.array([self.levers(int(joint), far) for joint, far in both])

    @cached_property
    def pair_levers(self) -> Array:
        """Ways (pairs, m) of links relative to each other: joints between them alone count."""
        out = np.zeros((len(self.pairs), len(self.joints)))
        for k, (first, second) in enumerate(self.pairs):
            out[k] = self.link_levers[first] + self.link_levers[second]
            common = set(self.path(self.carriers[first])) & set(self.path(self.carriers[second]))
            out[k, list(common)] = 0.0
        return out


class ChainMotion:
    """Links of a chain along a curve in the joints."""

    def __init__(
        self,
        geometry: Geometry,
        curve: Curve,
        size: float,
        window: tuple[float, float] | None = None,
    ) -> None:
        self.geometry, self.curve, self.size = geometry, curve, size
        self.window = window or (0.0, float(curve.knots[-1]))
        self.radii, self.pairs = geometry.radii, geometry.pairs
        self._joint_ways = curve.ways()

    def starts(self) -> Array:
        """Return equal intervals of the time that counts."""
        first, last = self.window
        return np.linspace(first, last, COARSE + 1 if last > first else 2)

    def ends(self, times: Array) -> Array:
        """Return both ends (k, links, 2, 3) of the links' axes at times (k,)."""
        return self.geometry.ends(self.curve.joints(times))

    def ways(self, low: Array, middle: Array, high: Array) -> Array:
        """Return bounds (k, links) of the links' ways from the middles of intervals (k,)."""
        return self._ways(self.geometry.link_levers, low, middle, high)

    def pair_ways(self, low: Array, middle: Array, high: Array) -> Array:
        """Return bounds (k, pairs) of the ways of pairs relative to each other."""
        return self._ways(self.geometry.pair_levers, low, middle, high)

    def _ways(self, levers: Array, low: Array, middle: Array, high: Array) -> Array:
        first, at, last = (self._turned(t) for t in (low, middle, high))
        return np.maximum(at - first, last - at) @ np.abs(self.geometry.lines[0]).T @ levers.T

    def _turned(self, times: Array) -> Array:
        """Return bounds (k, n) of the ways of the joints since t = 0."""
        knots, ways = self.curve.knots, self._joint_ways
        if knots[-1] == knots[0]:
            return np.zeros((len(times), ways.shape[1]))
        return np.stack([np.interp(times, knots, way) for way in ways.T], axis=1)
