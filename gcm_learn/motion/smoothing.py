"""Limits of jerk: a moving average over a movement whose accelerations are constant in pieces.

Averaged over a span of 2 h, a movement with accelerations up to a has third derivatives up to a / h
and second derivatives that are continuous. Rates, accelerations and ranges are kept. The movement
changes by at most a h^2 / 6, and not at all where rates are constant. (Biagiotti and Melchiorri,
"FIR filters for online trajectory planning with time- and frequency-domain specifications", 2012).
"""

from __future__ import annotations

import numpy as np

from gcm_learn.motion.failures import Failure
from gcm_learn.motion.movement import REST, Movement
from gcm_learn.scene import JointLimits

CLOSEST = 2e-5
"""Pieces under limits of jerk take at least this long; the contract asks for half of it [s]."""
SHORTEST = 1e-5
"""Pieces under limits of jerk take at least this long [s]."""
JERK, ROUNDING = 5e-5, 5e-15
"""Slack of third order, relative and absolute; the contract grants 1e-4 and 1e-14."""
RESTS = 5e-7
"""Share of a joint's speed that is rest; the contract grants 1e-6."""
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


def jerk_fault(
    limits: JointLimits, jerk: np.ndarray, moves: Movement, forces: np.ndarray
) -> Failure | None:
    """Return JOINT_JERK if a movement with rates breaks the limits of jerk, else None.

    Parameters
    ----------
    limits : JointLimits
    jerk : (n,) ndarray
    moves : Movement
    forces : (n,) ndarray
        Accelerations at t = 0.
    """
    assert moves.rates is not None
    span = np.diff(moves.time)[:, None]
    if (span < SHORTEST).any():
        return Failure.JOINT_JERK
    first, last = _ends_of(moves)
    jolt, noise = (last - first) / span, ROUNDING / span
    off = np.abs(np.vstack([forces, last[:-1]]) - first)
    least = np.minimum(span, np.vstack([span[:1], span[:-1]]))
    good = (off <= JERK * limits.joint_acceleration + ROUNDING / least**2).all()
    good &= (np.abs(jolt) <= jerk * (1.0 + JERK) + noise / span**2).all()
    return None if good else Failure.JOINT_JERK


def _ends_of(moves: Movement) -> tuple[np.ndarray, np.ndarray]:
    """Return accelerations (n - 1, dof) at the beginnings and at the ends of all pieces."""
    assert moves.rates is not None
    span, way = np.diff(moves.time)[:, None], np.diff(moves.joints, axis=0)
    v, w = moves.rates[:-1], moves.rates[1:]
    return (6.0 * way / span - 4.0 * v - 2.0 * w) / span, (
        2.0 * v + 4.0 * w - 6.0 * way / span
    ) / span


def ends_at_rest(moves: Movement, share: float = REST) -> bool:
    """Return whether a movement with rates ends at most at `share` of the limits of speed."""
    assert moves.rates is not None
    return bool((np.abs(moves.rates[-1]) <= share * np.array(moves.arm.max_joint_speed)).all())


def rests_at_end(limits: JointLimits, jerk: np.ndarray | None, moves: Movement) -> bool:
    """Return whether the joints rest at the end of a movement with rates."""
    still = ends_at_rest(moves, RESTS)
    if not still or moves.time.size < 2 or jerk is None:
        return still
    return bool((np.abs(_ends_of(moves)[1][-1]) <= JERK * limits.joint_acceleration).all())
