"""Limits of jerk: a moving average over a movement whose accelerations are constant in pieces.

Averaged over a span of 2 h, a movement with accelerations up to a has third derivatives up to a / h
and second derivatives that are continuous. Rates, accelerations and ranges are kept; the movement
changes by at most a h^2 / 6, and not at all where rates are constant (Biagiotti and Melchiorri,
"FIR filters for online trajectory planning with time- and frequency-domain specifications", 2012).
"""

from __future__ import annotations

import numpy as np

from gcm_learn.motion.movement import Movement

CLOSEST = 2e-5
"""Pieces under limits of jerk take at least this long; the contract asks for half of it [s]."""
SAME = 1e-12
"""Instants that differ by rounding alone [s]."""
SPARE = 1e-5
"""Share of the limits of jerk that is not used."""


def half_width(acceleration: np.ndarray, jerk: np.ndarray) -> float:
    """Return half the width of the average that keeps limits of jerk (n,); 0 without any [s]."""
    return float(np.max(acceleration / jerk, initial=0.0)) * (1.0 + SPARE)


def start_before(
    joints: np.ndarray, rates: np.ndarray, forces: np.ndarray, half: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return joints and rates (n,) at t = 0 of the movement whose average starts as given.

    Accelerations are constant until `half` [s].
    """
    return joints - forces * half * half / 6.0, rates


def smoothed(moves: Movement, forces: np.ndarray, half: float, kept: np.ndarray) -> Movement | None:
    """Return the moving average of a movement.

    Parameters
    ----------
    moves : Movement
        With rates; accelerations are constant between samples, and those of the first piece last
        for `half` at least. It ends with rates that are kept for `half`, or at rest.
    forces : (n,) ndarray
        Accelerations before t = 0.
    half : float
        Half the width [s].
    kept : (k,) ndarray
        Times that have to be samples [s].

    Returns
    -------
    Movement or None
        None if two of its pieces are too short.
    """
    assert moves.rates is not None
    knots = np.concatenate([moves.time[1:] - half, moves.time[1:] + half])
    end = moves.duration + half if not moves.rates[-1].any() else moves.duration - half
    fixed = np.concatenate([[0.0, end], kept])
    knots = knots[(knots > 0.0) & (knots < end)]
    knots = knots[np.abs(knots[:, None] - fixed).min(axis=1) > SAME]
    time = np.unique(np.concatenate([fixed, knots]))
    time = time[np.append(True, np.diff(time) > SAME)]
    if (np.diff(time) < CLOSEST).any():
        return None
    joints, rates = _averages(moves, forces, half, time)
    return Movement(moves.arm, time, joints, rates)


def _averages(
    moves: Movement, forces: np.ndarray, half: float, time: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the averages of joints and rates (m, n) about times (m,).

    They are those at the middle and weighted sums of accelerations about it, which loses no digits:
    an acceleration s away adds (h - s)^2 / 2 per second to the joints, and h - s to the rates.
    """
    assert moves.rates is not None
    spans = np.diff(moves.time)
    pieces = np.diff(moves.rates, axis=0) / spans[:, None]
    bounds = np.concatenate([[-np.inf], moves.time, [np.inf]])
    pieces = np.vstack([forces[None], pieces, np.zeros((1, forces.size))])
    k = np.clip(np.searchsorted(moves.time, time, side="right") - 1, 0, len(spans) - 1)
    since = (time - moves.time[k])[:, None]
    inner = pieces[k + 1]
    joints = moves.joints[k] + since * (moves.rates[k] + 0.5 * since * inner)
    rates = moves.rates[k] + since * inner
    late = time > moves.time[-1]
    joints[late], rates[late] = moves.joints[-1], moves.rates[-1]
    low = np.clip(bounds[None, :-1] - time[:, None], -half, half)
    high = np.clip(bounds[None, 1:] - time[:, None], -half, half)

    def away(s: np.ndarray) -> np.ndarray:  # integral of (h - |s|)^2 / 2 from 0 on
        return np.sign(s) * (half**3 - (half - np.abs(s)) ** 3) / 6.0

    def aside(s: np.ndarray) -> np.ndarray:  # integral of sign(s) (h - |s|) from 0 on
        return half * np.abs(s) - 0.5 * s * s

    joints += (away(high) - away(low)) @ pieces / (2.0 * half)
    rates += (aside(high) - aside(low)) @ pieces / (2.0 * half)
    return joints, rates
