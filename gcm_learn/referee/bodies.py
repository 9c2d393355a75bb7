"""Bodies of a situation: shape, motion, and how far they get."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gcm_learn.referee.motions import Law, law_of
from gcm_learn.referee.rotations import Array
from gcm_learn.referee.shapes import ball_of, point_gaps


@dataclass(frozen=True)
class Body:
    """A target or an obstacle."""

    name: str
    role: str
    shape: dict[str, Any]
    law: Law
    ball: float
    """Radius of the ball about the centre that holds the shape."""
    approach: dict[str, Any] | None = None

    def poses(self, times: Array) -> tuple[Array, Array]:
        """Return centres (k, 3) and rotations (k, 3, 3), body to world, at times (k,)."""
        return self.law.poses(times)

    def ways(self, low: Array, middle: Array, high: Array) -> Array:
        """Return bounds (k,) of the way of any point from the middles of intervals."""
        spins = self.shape["kind"] not in ("sphere", "disc")
        way = self.law.way + (self.ball * self.law.turn if spins else 0.0)
        first, at, last = (np.interp(t, self.law.knots, way) for t in (low, middle, high))
        return np.maximum(at - first, last - at)

    def gaps(self, time: float, points: Array) -> Array:
        """Return signed distances (k,) of points (k, 3) of the world at a time."""
        centre, turn = self.poses(np.array([time], dtype=float))
        return point_gaps(self.shape, (points - centre) @ turn[0])


def bodies_of(given: Sequence[dict[str, Any]], end: float) -> list[Body]:
    """Return the bodies of a situation, with bounds of their ways up to a time [s]."""
    return [
        Body(
            body["name"],
            body["role"],
            body["shape"],
            law_of(body["motion"], end),
            ball_of(body["shape"]),
            body.get("approach"),
        )
        for body in given
    ]


def into(centre: Array, turn: Array, points: Array) -> Array:
    """Return points (k, 3) of the world in frames of centres (k, 3) and rotations (k, 3, 3)."""
    return np.einsum("kij,ki->kj", turn, points - centre)
