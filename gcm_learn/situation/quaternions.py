"""Unit quaternions (w, x, y, z) that turn at a constant angular velocity."""

from __future__ import annotations

import math
from collections.abc import Sequence

Quaternion = tuple[float, float, float, float]
Vector = tuple[float, float, float]


def product(p: Sequence[float], q: Sequence[float]) -> Quaternion:
    """Return the quaternion of the rotation q followed by the rotation p."""
    a, b, c, d = p
    w, x, y, z = q
    return (
        a * w - b * x - c * y - d * z,
        a * x + b * w + c * z - d * y,
        a * y - b * z + c * w + d * x,
        a * z + b * y - c * x + d * w,
    )


def turned(orientation: Sequence[float], spin: Sequence[float], t: float) -> Quaternion:
    """Return exp([spin t]) applied to an orientation; `spin` is in the world frame [rad/s]."""
    rate = math.hypot(*spin)
    if rate * t == 0.0:
        w, x, y, z = orientation
        return (w, x, y, z)
    half = 0.5 * rate * t
    along = math.sin(half) / rate
    x, y, z = spin
    return product((math.cos(half), x * along, y * along, z * along), orientation)


def spin_between(first: Sequence[float], second: Sequence[float], t: float) -> Vector:
    """Return the constant spin that turns one orientation into another the short way in t [s]."""
    w, x, y, z = first
    a, b, c, d = product(second, (w, -x, -y, -z))
    side = -1.0 if a < 0.0 else 1.0
    size = math.sqrt(b * b + c * c + d * d)
    if size == 0.0:
        return (0.0, 0.0, 0.0)
    rate = side * 2.0 * math.atan2(size, side * a) / (size * t)
    return (b * rate, c * rate, d * rate)


def nearer(first: Sequence[float], second: Sequence[float]) -> tuple[float, ...]:
    """Return the second quaternion with the sign that brings it nearer to the first."""
    same = math.fsum(a * b for a, b in zip(first, second, strict=True)) >= 0.0
    return tuple(x if same else -x for x in second)
