"""Motions in stages, on circles and after bounces, for bodies that are made at rest."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from gcm_learn.arms import quaternion_of, rotation_of
from gcm_learn.families.solids import STILL, UP, flight, triple
from gcm_learn.situation import Body, Pendulum, Piece, Piecewise, Sampled, SolidQuadratic

STEP = 0.1  # turn between samples of a circle, at most [rad]

Law = tuple[float, ArrayLike, ArrayLike]
"""Start [s], velocity then (3,) and constant acceleration (3,)."""


def staged(body: Body, laws: Sequence[Law]) -> Body:
    """Return a resting body set in motion by one law after another, from its place at t = 0."""
    rest, pieces = flight(body), []
    place, last = np.array(rest.position), None
    for start, velocity, pull in laws:
        v, a = np.asarray(velocity, dtype=float), np.asarray(pull, dtype=float)
        if last is not None:
            span = start - last[0]
            place = place + last[1] * span + 0.5 * last[2] * span**2
        motion = SolidQuadratic(triple(place), triple(v), triple(a), rest.orientation)
        pieces.append(Piece(start, motion))
        last = (start, v, a)
    return replace(body, motion=Piecewise(tuple(pieces)))


def shifted(body: Body, by: ArrayLike) -> Body:
    """A resting body at another place."""
    rest = flight(body)
    there = triple(np.array(rest.position) + np.asarray(by, dtype=float))
    return replace(body, motion=replace(rest, position=there))


def sliding(body: Body, begins: float, ends: float, by: np.ndarray) -> Body:
    """A resting body that is displaced by a vector (3,) between two times [s], evenly."""
    if begins <= 0.0:
        return staged(body, [(0.0, by / ends, STILL), (ends, STILL, STILL)])
    rate = by / (ends - begins)
    return staged(body, [(0.0, STILL, STILL), (begins, rate, STILL), (ends, STILL, STILL)])


def arriving(body: Body, when: float, velocity: np.ndarray, drift: np.ndarray = STILL) -> Body:
    """Return a body that slows down evenly to be at its place at `when`, and then drifts."""
    first = shifted(body, -0.5 * (velocity + drift) * when)
    return staged(first, [(0.0, velocity, (drift - velocity) / when), (when, drift, STILL)])


def orbiting(body: Body, middle: np.ndarray, rate: float, when: float) -> Body:
    """Return a ball that circles `middle` (3,) on its level for ever, at its place at `when`."""
    out = np.array(flight(body).position) - middle
    radius = float(np.linalg.norm(out))
    swing = Pendulum(
        triple(middle), triple(UP), triple(out / radius), radius, 0.0, -rate * when, rate
    )
    return replace(body, motion=swing)


def circling(body: Body, middle: np.ndarray, rate: float, when: float, horizon: float) -> Body:
    """Return a body that turns with a turntable about the vertical, at its place at `when`.

    Parameters
    ----------
    body : Body
        At rest.
    middle : (3,) ndarray
        On the turntable's axis.
    rate : float
        [rad/s]
    when, horizon : float
        [s]
    """
    steps = [max(math.ceil(abs(rate) * span / STEP), 1) for span in (when, horizon - when)]
    before = np.linspace(0.0, when, steps[0] + 1)
    times = np.concatenate([before, np.linspace(when, horizon, steps[1] + 1)[1:]])
    rest = flight(body)
    axes, arm = rotation_of(rest.orientation), np.array(rest.position) - middle
    places, turns = [], []
    for t in times:
        turn = _about_up(rate * (float(t) - when))
        places.append(triple(middle + turn @ arm))
        turns.append(quaternion_of(turn @ axes))
    return replace(body, motion=Sampled(tuple(times.tolist()), tuple(places), tuple(turns)))


def _about_up(angle: float) -> np.ndarray:
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
