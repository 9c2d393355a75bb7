"""Motion laws of bodies; lengths in forearm lengths, times in seconds, angles in radians."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

from gcm_learn import checks


@dataclass(frozen=True)
class PlanarQuadratic:
    """Constant acceleration and constant spin in the arm plane.

    ``p(t) = position + velocity t + acceleration t^2 / 2``, turned by ``angle + spin t``.

    Parameters
    ----------
    position, velocity, acceleration : (2,) tuple of float
        Of the body's origin at t = 0.
    angle : float
        Counter-clockwise orientation at t = 0 [rad].
    spin : float
        Angular velocity [rad/s].
    """

    position: tuple[float, float]
    velocity: tuple[float, float]
    acceleration: tuple[float, float]
    angle: float = 0.0
    spin: float = 0.0

    kind: ClassVar[str] = "quadratic"

    def __post_init__(self) -> None:
        """Check the documented shapes."""
        for name in ("position", "velocity", "acceleration"):
            checks.put(self, name, checks.vector(getattr(self, name), name, 2))
        for name in ("angle", "spin"):
            checks.put(self, name, checks.number(getattr(self, name), name))


@dataclass(frozen=True)
class SolidQuadratic:
    """Constant acceleration and constant spin in space.

    ``p(t) = position + velocity t + acceleration t^2 / 2`` and ``R(t) = exp([spin t]) R0``.

    Parameters
    ----------
    position, velocity, acceleration : (3,) tuple of float
        Of the body's centre at t = 0, in the world frame.
    orientation : (4,) tuple of float
        Unit quaternion (w, x, y, z) of R0, body to world.
    spin : (3,) tuple of float
        Angular velocity in the world frame [rad/s].
    """

    position: tuple[float, float, float]
    velocity: tuple[float, float, float]
    acceleration: tuple[float, float, float]
    orientation: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)
    spin: tuple[float, float, float] = (0.0, 0.0, 0.0)

    kind: ClassVar[str] = "quadratic"

    def __post_init__(self) -> None:
        """Check the documented shapes."""
        for name in ("position", "velocity", "acceleration", "spin"):
            checks.put(self, name, checks.vector(getattr(self, name), name, 3))
        checks.put(self, "orientation", checks.unit_vector(self.orientation, "orientation", 4))


MOST_PERIODS = 1000  # of a pendulum's fastest swing in a horizon: its angle is tabulated


@dataclass(frozen=True)
class Pendulum:
    """A body on a cord; ``angle'' = -(gravity / length) sin(angle) - damping angle'``.

    The body's z axis points along the cord, away from the pivot.

    Parameters
    ----------
    pivot : (3,) tuple of float
        Fixed end of the cord, in the world frame.
    axis : (3,) tuple of float
        Unit vector of the rotation axis; angles grow counter-clockwise about it.
    down : (3,) tuple of float
        Unit vector from the pivot to the body at angle 0, orthogonal to `axis`.
    length : float
        Of the equivalent simple pendulum, above zero.
    gravity : float
        Not negative.
    angle, rate : float
        Angle [rad] and angular velocity [rad/s] at t = 0.
    damping : float
        Not negative [1/s].
    hang : float, optional
        Distance from the pivot to the body's centre, not negative; `length` when absent.
    """

    pivot: tuple[float, float, float]
    axis: tuple[float, float, float]
    down: tuple[float, float, float]
    length: float
    gravity: float
    angle: float
    rate: float
    damping: float = 0.0
    hang: float | None = None

    kind: ClassVar[str] = "pendulum"

    def __post_init__(self) -> None:
        """Check the documented shapes and ranges."""
        checks.put(self, "pivot", checks.vector(self.pivot, "pivot", 3))
        checks.put(self, "axis", checks.unit_vector(self.axis, "axis"))
        checks.put(self, "down", checks.unit_vector(self.down, "down"))
        checks.orthogonal(self.axis, self.down, "down", "axis")
        checks.put(self, "length", checks.positive(self.length, "length"))
        checks.put(self, "gravity", checks.non_negative(self.gravity, "gravity"))
        for name in ("angle", "rate"):
            checks.put(self, name, checks.number(getattr(self, name), name))
        checks.put(self, "damping", checks.non_negative(self.damping, "damping"))
        if self.hang is not None:
            checks.put(self, "hang", checks.non_negative(self.hang, "hang"))

    @property
    def hang_distance(self) -> float:
        """Distance from the pivot to the body's centre."""
        return self.length if self.hang is None else self.hang

    @property
    def fastest(self) -> float:
        """Bound of how fast anything about the swing changes [rad/s]."""
        return max(math.sqrt(self.gravity / self.length), abs(self.rate), self.damping, 1e-3)
