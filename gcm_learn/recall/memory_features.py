"""What an encoder is told of a memory: its path, and the cognitive map of its situation.

Whether a memory is valid in a situation depends on its knots and its goal, and on nothing else of
the situation that it comes from. Knots lie where corners and waits are, so each of them says little
on its own; the path is also told at equal shares of its length.

Of a map, three fields are told on a polar lattice that begins in the direction of the hand: when
the front arrived, whether it did, and where it was stopped for good (the effective obstacles). A
cell that was not reached has no arrival: its number is 0 and the second field says so, in place of
a time that means "never". The interception follows: direction, share of the ring and time.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.compiled import njit
from gcm_learn.maps import build_map
from gcm_learn.situation import Situation, canonical
from gcm_learn.wave import MarchingParams

SAMPLES = 16  # equal shares of the path's length
PER_KNOT, PER_SAMPLE, WHOLE = 8, 5, 7
HUB = 0.1  # added to shares of the ring for lengths, lest a hand at the shoulder went nowhere
CELLS = 40  # along a side of the maps that are made here
DIRECTIONS, RINGS = 32, 10
FIELDS = 3
CONTACT = 5
COUNT = FIELDS * DIRECTIONS * RINGS + CONTACT


def count(knots: int) -> int:
    """Features of a path with so many knots."""
    return PER_KNOT * knots + PER_SAMPLE * SAMPLES + WHOLE


def path_features(knots: np.ndarray, goals: np.ndarray) -> np.ndarray:
    """Features (n, count(k)) float32 of remembered paths.

    Parameters
    ----------
    knots : (n, k, 4) ndarray
        Rows (direction of the hand [rad], share of the ring, time [s], earliest [s] or 0).
    goals : (n, 2) ndarray
        Direction and share of the target's centre.
    """
    out = np.zeros((len(knots), count(knots.shape[1])), dtype=np.float32)
    _fill(knots.astype(np.float64), goals.astype(np.float64), out)
    return out


@njit
def _fill(knots, goals, out):
    """Fill in the features of all paths."""
    n, size = knots.shape[0], knots.shape[1]
    cum = np.zeros(size)
    for m in range(n):
        at, latest = 0, 0.0
        for k in range(size):
            a, ring, t, earliest = (
                knots[m, k, 0], knots[m, k, 1], knots[m, k, 2], knots[m, k, 3],
            )  # fmt: skip
            latest = max(latest, earliest)
            at = _place(a, ring, t, m, at, out)
            out[m, at] = 1.0 if earliest > 0.0 else 0.0
            out[m, at + 1], out[m, at + 2] = earliest, latest
            at += 3
            if k > 0:
                turn, width = a - knots[m, k - 1, 0], ring - knots[m, k - 1, 1]
                mean = 2.0 * (0.5 * (ring + knots[m, k - 1, 1]) + HUB)
                cum[k] = cum[k - 1] + np.sqrt((2.0 * width) ** 2 + (mean * turn) ** 2)
        whole = cum[size - 1]
        k = 0
        for j in range(SAMPLES):
            want = whole * (j + 0.5) / SAMPLES
            while k < size - 2 and cum[k + 1] < want:
                k += 1
            span = cum[k + 1] - cum[k]
            s = min(max((want - cum[k]) / span, 0.0), 1.0) if span > 1e-12 else 1.0
            a = knots[m, k, 0] + s * (knots[m, k + 1, 0] - knots[m, k, 0])
            ring = knots[m, k, 1] + s * (knots[m, k + 1, 1] - knots[m, k, 1])
            t = knots[m, k, 2] + s * (knots[m, k + 1, 2] - knots[m, k, 2])
            at = _place(a, ring, t, m, at, out)
        at = _place(goals[m, 0], goals[m, 1], knots[m, size - 1, 2], m, at, out)
        out[m, at], out[m, at + 1] = 0.5 * whole, latest


@njit
def _place(a, ring, t, m, at, out):
    """Fill in a place of the hand and its time; where the next feature goes."""
    out[m, at], out[m, at + 1] = np.cos(a), np.sin(a)
    out[m, at + 2] = a / np.pi
    out[m, at + 3] = 2.0 * ring - 1.0
    out[m, at + 4] = 2.0 * t - 1.0
    return at + 5


def map_features(situation: Situation) -> np.ndarray:
    """Features (COUNT,) float32 of the map of a situation in any frame."""
    turned, _ = canonical(situation)
    chart = build_map(turned, MarchingParams(n=CELLS))
    arm = turned.arm
    out = np.zeros(COUNT, dtype=np.float32)
    rows, columns = _cells(chart.lattice.centres, arm.inner_reach, arm.reach)
    arrival = chart.arrival[rows, columns]
    there = ~np.ma.getmaskarray(arrival)
    speed = arm.max_hand_speed
    fields = out[: FIELDS * DIRECTIONS * RINGS].reshape(FIELDS, RINGS, DIRECTIONS)
    fields[0] = np.where(there, arrival.filled(0.0) * speed / 3.0, 0.0)
    fields[1] = there
    fields[2] = chart.effective_obstacles[rows, columns]
    if chart.interception is not None:
        (x, y), when = chart.interception.position, chart.interception.time
        r = np.hypot(x, y)
        share = (r - arm.inner_reach) / (arm.reach - arm.inner_reach)
        out[-CONTACT:] = (1.0, x / r, y / r, 2.0 * share - 1.0, when * speed / 3.0)
    return out


def _cells(centres: np.ndarray, near: float, far: float) -> tuple[np.ndarray, np.ndarray]:
    """Rows and columns (RINGS, DIRECTIONS) of the lattice's cells that the polar ones lie in."""
    r = near + (np.arange(RINGS)[:, None] + 0.5) / RINGS * (far - near)
    a = 2.0 * np.pi * np.arange(DIRECTIONS)[None] / DIRECTIONS
    step = centres[1] - centres[0]
    last = len(centres) - 1
    rows = np.clip(np.rint((r * np.sin(a) - centres[0]) / step), 0, last).astype(int)
    columns = np.clip(np.rint((r * np.cos(a) - centres[0]) / step), 0, last).astype(int)
    return rows, columns


def map_picture(situation: Situation) -> np.ndarray:
    """Map of a situation in its canonical frame, as numbers (2 CELLS CELLS,) float32.

    Arrival as a share of the horizon, 1 where there is none, and the effective obstacles.
    """
    turned, _ = canonical(situation)
    made = build_map(turned, MarchingParams(n=CELLS))
    arrival = np.minimum(made.arrival.filled(np.inf) / situation.horizon, 1.0)
    return np.concatenate([arrival.ravel(), made.effective_obstacles.ravel()]).astype(np.float32)
