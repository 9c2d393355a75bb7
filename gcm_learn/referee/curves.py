"""Joints between the samples of a trajectory: straight lines or cubic Hermite curves."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.referee.rotations import Array


class Curve(NamedTuple):
    """Joints as polynomials of the time since the sample before."""

    knots: Array
    """Times (n + 1,) of the samples; a single sample counts twice [s]."""
    powers: Array
    """Coefficients (n, joints, 4) of the polynomials."""

    def pieces(self, times: Array) -> tuple[Array, Array]:
        """Return the piece's index (k,) at each time (k,), and the time since its begin (k,)."""
        last = len(self.powers) - 1
        piece = np.clip(np.searchsorted(self.knots, times, side="right") - 1, 0, last)
        return piece, times - self.knots[piece]

    def joints(self, times: Array) -> Array:
        """Return joints (k, joints) at times (k,)."""
        piece, since = self.pieces(times)
        return self.within(piece, since)

    def within(self, piece: Array, since: Array) -> Array:
        """Return joints (k, joints) in pieces (k,) at times since their begin (k,)."""
        c, s = self.powers[piece], since[:, None]
        return c[:, :, 0] + s * (c[:, :, 1] + s * (c[:, :, 2] + s * c[:, :, 3]))

    def rates(self, piece: Array, since: Array) -> Array:
        """Return rates (k, joints) in pieces (k,) at times since their begin (k,)."""
        c, s = self.powers[piece], since[:, None]
        return c[:, :, 1] + s * (2.0 * c[:, :, 2] + 3.0 * s * c[:, :, 3])

    def accelerations(self, piece: Array, since: Array) -> Array:
        """Return second derivatives (k, joints) in pieces (k,) at times since their begin (k,)."""
        c, s = self.powers[piece], since[:, None]
        return 2.0 * c[:, :, 2] + 6.0 * s * c[:, :, 3]

    @property
    def spans(self) -> Array:
        """Durations (n,) of the pieces."""
        return np.diff(self.knots)

    def extremes(self, order: int) -> tuple[Array, Array]:
        """Return least and largest values (n, joints) of a derivative in each piece."""
        c = self.powers
        for _ in range(order):
            c = c[:, :, 1:] * np.arange(1.0, c.shape[2])
        return extremes(c, self.spans)

    def most(self, order: int) -> Array:
        """Return the largest absolute value (n, joints) of a derivative in each piece."""
        low, high = self.extremes(order)
        return np.maximum(np.abs(low), np.abs(high))

    def ways(self) -> Array:
        """Return bounds (n + 1, joints) of the way of each joint since t = 0."""
        steps = self.most(1) * self.spans[:, None]
        return np.concatenate([np.zeros((1, steps.shape[1])), np.cumsum(steps, axis=0)])


def curve_of(time: Array, joints: Array, rates: Array | None = None) -> Curve:
    """Return the curve through joints (n, joints), with given rates if there are any."""
    if len(time) == 1:
        time, joints = np.repeat(time, 2), np.repeat(joints, 2, axis=0)
        rates = None if rates is None else np.repeat(rates, 2, axis=0)
    span = np.diff(time)[:, None]
    safe = np.where(span > 0.0, span, 1.0)
    slope = np.diff(joints, axis=0) / safe
    c = np.zeros((*slope.shape, 4))
    c[:, :, 0], c[:, :, 1] = joints[:-1], slope
    if rates is not None:
        first, last = rates[:-1], rates[1:]
        slope = np.where(span > 0.0, slope, first)
        c[:, :, 1], c[:, :, 2] = first, (3.0 * slope - 2.0 * first - last) / safe
        c[:, :, 3] = (first + last - 2.0 * slope) / safe**2
    return Curve(time, c)


def extremes(powers: Array, span: Array) -> tuple[Array, Array]:
    """Return least and largest values (n, m) of polynomials (n, m, up to 4) over [0, span (n,)]."""
    c = np.concatenate([powers, np.zeros((*powers.shape[:2], 4 - powers.shape[2]))], axis=2)
    whole = np.broadcast_to(span[:, None], c.shape[:2])
    a, b, d = 3.0 * c[:, :, 3], 2.0 * c[:, :, 2], c[:, :, 1]
    with np.errstate(all="ignore"):
        # the form of the roots that does not cancel
        q = -0.5 * (b + np.copysign(np.sqrt(np.maximum(b * b - 4.0 * a * d, 0.0)), b))
        places = [np.zeros_like(whole), whole, q / a, d / q]
    values = []
    for place in places:
        s = np.clip(np.where(np.isfinite(place), place, 0.0), 0.0, whole)
        values.append(((c[:, :, 3] * s + c[:, :, 2]) * s + c[:, :, 1]) * s + c[:, :, 0])
    return np.min(values, axis=0), np.max(values, axis=0)
