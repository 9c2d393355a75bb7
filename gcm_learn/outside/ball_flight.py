"""Flight of table-tennis balls: gravity, drag, Magnus force and bounces on the table.

A ball is a thin hollow sphere.  Its spin changes in bounces only.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from gcm_learn.situation import Piece, SolidQuadratic

TABLE = (0.7625, 1.37)
"""Half width (x) and half length (y) of the table, whose surface is at z = 0 [m]."""
HEIGHT = 0.76
"""Of the table over the floor [m]."""
NET = (0.915, 0.1525)
"""Half length (x) and height of the net, at y = 0 [m]."""
RADIUS, MASS = 0.02, 0.0027
"""Of a ball [m], [kg]."""
GRAVITY, AIR = 9.81, 1.204
"""Gravity [m/s^2] and density of air at 20 degrees [kg/m^3]."""
DRAG, LIFT = 0.4, 0.6
"""Coefficients of drag, and of lift per ratio of the surface's speed to the ball's.

Chosen within the usual range (post hoc): 93 of 100 measured serves pass the net, with the drag of
a smooth sphere (0.47) and a lift of 1 only 80.
"""
RESTITUTION, FRICTION = 0.93, 0.25
"""Of ball and table, as Nakashima et al. measured them (IEEE/RSJ IROS 2010)."""
STEP = 0.005
"""Of the integration [s]."""
FIT = 0.002
"""Largest error of a piece at the steps of the integration [m]."""

_AREA = np.pi * RADIUS**2
_DRAG = 0.5 * AIR * _AREA * DRAG / MASS  # [1/m]
_LIFT = 0.5 * AIR * _AREA * RADIUS * LIFT / MASS  # [1]
_NEWTON = 4  # steps towards the instant of a bounce
_BOUNCES = 8  # in one step of the integration


@dataclass(frozen=True)
class Flight:
    """Places of a ball from one bounce to the next.

    Parameters
    ----------
    times : (m,) ndarray
        [s]
    places : (m, 3) ndarray
        [m]
    """

    times: np.ndarray
    places: np.ndarray


def _forces(v: np.ndarray, w: np.ndarray) -> np.ndarray:
    """Return accelerations (n, 3) of balls with velocities (n, 3) and spins (n, 3)."""
    speed = np.sqrt((v * v).sum(axis=1, keepdims=True))
    result = _LIFT * np.cross(w, v) - _DRAG * speed * v
    result[:, 2] -= GRAVITY
    return result


def moved(states: np.ndarray, span: np.ndarray) -> np.ndarray:
    """Return states (n, 9) after spans (n,) without a bounce, by a step of Runge and Kutta.

    A state is place, velocity and spin.
    """
    h = span[:, None]
    p, v, w = states[:, :3], states[:, 3:6], states[:, 6:]
    a = _forces(v, w)
    b = _forces(v + 0.5 * h * a, w)
    c = _forces(v + 0.5 * h * b, w)
    d = _forces(v + h * c, w)
    place = p + h * v + h * h / 6.0 * (a + b + c)
    return np.hstack([place, v + h / 6.0 * (a + 2.0 * b + 2.0 * c + d), w])


def bounced(states: np.ndarray) -> np.ndarray:
    """Return states (n, 9) after a bounce on the table.

    The ball slides or, if friction stops its lowest point, rolls (Nakashima et al. 2010).
    """
    vx, vy, vz = states[:, 3], states[:, 4], states[:, 5]
    wx, wy = states[:, 6], states[:, 7]
    slip = np.stack([vx - RADIUS * wy, vy + RADIUS * wx], axis=1)
    speed = np.maximum(np.sqrt((slip * slip).sum(axis=1)), 1e-12)
    share = np.minimum(FRICTION * (1.0 + RESTITUTION) * np.abs(vz) / speed, 0.4)
    push = -share[:, None] * slip
    result = states.copy()
    result[:, 3:5] += push
    result[:, 5] = -RESTITUTION * vz
    result[:, 6] += 1.5 / RADIUS * push[:, 1]
    result[:, 7] -= 1.5 / RADIUS * push[:, 0]
    return result


def _lands(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Return which balls come down to the table between two states."""
    over = (np.abs(after[:, 0]) <= TABLE[0]) & (np.abs(after[:, 1]) <= TABLE[1])
    return over & (before[:, 2] >= RADIUS - 1e-6) & (after[:, 2] < RADIUS) & (after[:, 5] < 0.0)


def _until_landing(states: np.ndarray, span: np.ndarray) -> np.ndarray:
    """Return the times (n,) within spans at which balls reach the table, by Newton's method."""
    share = np.full(len(states), 0.5) * span
    for _ in range(_NEWTON):
        there = moved(states, share)
        share = np.clip(share - (there[:, 2] - RADIUS) / np.minimum(there[:, 5], -1e-6), 0.0, span)
    return share


def flights(states: np.ndarray, until: float) -> list[list[Flight]]:
    """Return the flights of balls up to a time, each cut at its bounces.

    Parameters
    ----------
    states : (n, 9) ndarray
        Place [m], velocity [m/s] and spin [rad/s] at t = 0.
    until : float
        [s]
    """
    marks: list[list[tuple[float, np.ndarray, bool]]] = [
        [(0.0, row[:3].copy(), False)] for row in states
    ]
    steps = int(np.ceil(until / STEP))
    for k in range(steps):
        begin, left = k * until / steps, np.full(len(states), until / steps)
        after = moved(states, left)
        for _ in range(_BOUNCES):
            low = np.flatnonzero(_lands(states, after))
            if not low.size:
                break
            spent = _until_landing(states[low], left[low])
            touching = moved(states[low], spent)
            touching[:, 2] = RADIUS
            left[low] -= spent
            for i, row in zip(low.tolist(), touching, strict=True):
                marks[i].append((begin + until / steps - left[i], row[:3].copy(), True))
            states = states.copy()
            states[low] = bounced(touching)
            after[low] = moved(states[low], left[low])
        states = after
        for i, row in enumerate(states):
            marks[i].append(((k + 1) * until / steps, row[:3].copy(), False))
    return [_cut(row) for row in marks]


def _cut(marks: Sequence[tuple[float, np.ndarray, bool]]) -> list[Flight]:
    """Return the flights between bounces."""
    ends = [0, *(k for k, mark in enumerate(marks) if mark[2]), len(marks) - 1]
    made = []
    for first, last in pairwise(ends):
        times = np.array([mark[0] for mark in marks[first : last + 1]])
        fresh = np.concatenate([[True], np.diff(times) > 1e-9])
        if fresh.sum() > 1:
            places = np.array([mark[1] for mark in marks[first : last + 1]])
            made.append(Flight(times[fresh], places[fresh]))
    return made


def pieces_of(flown: Sequence[Flight]) -> list[Piece]:
    """Return pieces of constant acceleration that follow flights.

    Each piece is as long as its error at the steps of the integration allows.
    """
    made = []
    for flight in flown:
        first, last = 0, len(flight.times) - 1
        while first < last:
            good, bad = first + 1, last + 1
            while bad - good > 1:
                middle = (good + bad) // 2
                error = _fitted(flight, first, middle)[1]
                good, bad = (middle, bad) if error <= FIT else (good, middle)
            if _fitted(flight, first, last)[1] <= FIT:
                good = last
            made.append(_fitted(flight, first, good)[0])
            first = good
    return made


def _fitted(flight: Flight, first: int, last: int) -> tuple[Piece, float]:
    """Fit a piece between two steps, exact at both; return it with its largest error between.

    Its acceleration is that of least squares.
    """
    s = flight.times[first : last + 1] - flight.times[first]
    places, span = flight.places[first : last + 1], s[-1]
    chord = (places[-1] - places[0]) / span
    rest = places - places[0] - s[:, None] * chord
    bow = 0.5 * s * (s - span)
    size = float(bow @ bow)
    pull = (bow @ rest) / size if size > 0.0 else np.zeros(3)
    error = np.sqrt(((rest - bow[:, None] * pull) ** 2).sum(axis=1)).max()
    velocity = chord - 0.5 * span * pull
    law = SolidQuadratic(*(tuple(v.tolist()) for v in (places[0], velocity, pull)))
    return Piece(float(flight.times[first]), law), float(error)
