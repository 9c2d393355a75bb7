"""What a remembered way looks like: all that decides where it can be bent to.

Whether a memory holds in a situation depends on its knots and its goal, and on nothing else of the
situation that it comes from. Knots lie where corners and waits are, so each of them says little on
its own; the way is also told at equal shares of its length.


What a cognitive map looks like to an encoder: its fields about the shoulder, on few cells.

Three fields on a polar lattice that begins in the direction of the hand: when the front arrived,
whether it did, and where it was stopped for good (the effective obstacles). A cell that was not
reached has no arrival: its number is 0 and the second field says so, in place of a time that means
"never". The contact follows: direction, share of the ring and time of the catch.
"""

from __future__ import annotations

import numpy as np

from gcm_learn.compiled import njit
from gcm_learn.maps import CognitiveMap, build_map
from gcm_learn.situation import Situation
from gcm_learn.situation.canonical import canonical
from gcm_learn.wave import MarchingParams

SAMPLES = 16  # equal shares of the way's length
PER_KNOT, PER_SAMPLE, WHOLE = 8, 5, 7
HUB = 0.1  # added to shares of the ring for lengths, lest a hand at the shoulder went nowhere


def count(knots: int) -> int:
    """Features of ways with so many knots."""
    return PER_KNOT * knots + PER_SAMPLE * SAMPLES + WHOLE


def ways(traces: np.ndarray, goals: np.ndarray) -> np.ndarray:
    """Features (n, count(k)) float32 of remembered ways.

    Parameters
    ----------
    traces : (n, k, 4) ndarray
        Rows (direction of the hand [rad], share of the ring, time [s], earliest [s] or 0).
    goals : (n, 2) ndarray
        Direction and share of the target's centre.
    """
    out = np.zeros((len(traces), count(traces.shape[1])), dtype=np.float32)
    _fill(traces.astype(np.float64), goals.astype(np.float64), out)
    return out


@njit
def _fill(traces, goals, out):
    """Fill in the features of all ways."""
    n, knots = traces.shape[0], traces.shape[1]
    cum = np.zeros(knots)
    for m in range(n):
        at, latest = 0, 0.0
        for k in range(knots):
            a, ring, t, earliest = (
                traces[m, k, 0], traces[m, k, 1], traces[m, k, 2], traces[m, k, 3],
            )  # fmt: skip
            latest = max(latest, earliest)
            at = _place(a, ring, t, m, at, out)
            out[m, at] = 1.0 if earliest > 0.0 else 0.0
            out[m, at + 1], out[m, at + 2] = earliest, latest
            at += 3
            if k > 0:
                turn, width = a - traces[m, k - 1, 0], ring - traces[m, k - 1, 1]
                mean = 2.0 * (0.5 * (ring + traces[m, k - 1, 1]) + HUB)
                cum[k] = cum[k - 1] + np.sqrt((2.0 * width) ** 2 + (mean * turn) ** 2)
        whole = cum[knots - 1]
        k = 0
        for j in range(SAMPLES):
            want = whole * (j + 0.5) / SAMPLES
            while k < knots - 2 and cum[k + 1] < want:
                k += 1
            span = cum[k + 1] - cum[k]
            s = min(max((want - cum[k]) / span, 0.0), 1.0) if span > 1e-12 else 1.0
            a = traces[m, k, 0] + s * (traces[m, k + 1, 0] - traces[m, k, 0])
            ring = traces[m, k, 1] + s * (traces[m, k + 1, 1] - traces[m, k, 1])
            t = traces[m, k, 2] + s * (traces[m, k + 1, 2] - traces[m, k, 2])
            at = _place(a, ring, t, m, at, out)
        at = _place(goals[m, 0], goals[m, 1], traces[m, knots - 1, 2], m, at, out)
        out[m, at], out[m, at + 1] = 0.5 * whole, latest


@njit
def _place(a, ring, t, m, at, out):
    """Fill in a place of the hand and its time; where the next feature goes."""
    out[m, at], out[m, at + 1] = np.cos(a), np.sin(a)
    out[m, at + 2] = a / np.pi
    out[m, at + 3] = 2.0 * ring - 1.0
    out[m, at + 4] = 2.0 * t - 1.0
    return at + 5


CELLS = 40  # along a side of the maps that are made here
DIRECTIONS, RINGS = 32, 10
FIELDS = 3
CONTACT = 5
COUNT = FIELDS * DIRECTIONS * RINGS + CONTACT


def picture_of(situation: Situation, made: CognitiveMap | None = None) -> np.ndarray:
    """Features (COUNT,) float32 of a situation's map.

    Parameters
    ----------
    situation : Situation
        In any frame if no map is given, else the canonical one that the map belongs to.
    made : CognitiveMap, optional
        By default one is marched on CELLS x CELLS cells.
    """
    turned = canonical(situation)[0] if made is None else situation
    chart = build_map(turned, MarchingParams(n=CELLS)) if made is None else made
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
    if chart.contact is not None:
        x, y = chart.contact.position
        r = np.hypot(x, y)
        share = (r - arm.inner_reach) / (arm.reach - arm.inner_reach)
        out[-CONTACT:] = (1.0, x / r, y / r, 2.0 * share - 1.0, chart.contact.time * speed / 3.0)
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
