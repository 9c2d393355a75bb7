"""Timing of spatial arms under limits of acceleration.

An arm comes from its start, with its rates, to a posture at a given time in one of two ways.  A
dash has one constant acceleration and then constant rates.  A tracked movement keeps as near to a
given path as the limits allow.  A catch has a place and a time, while the rates at its end are
free.  Generators of motion from point to point (ruckig) want these given.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from gcm_learn.arms.limbs import dof
from gcm_learn.compiled import njit
from gcm_learn.motion.movement import Movement

HAIR = 1e-6  # share of the limits that is not used, against rounding
KNOTS = 24  # of a tracked path, evenly in time: between them accelerations are linear
SAMPLES = 4  # of the path in each span between knots
_NO_ROOM = 1e-7  # at the end of its range a joint stops within this [rad]
_AT_ONCE = 1e-9  # what stops sooner rests, and what stops this much apart stops together [s]
_END = 300.0  # weight of the path's end, where the target is, beside that of any other sample


@njit(_nrt=False)
def dash(scene, goal, until, joints, rates):
    """Come to a posture at a time: a constant acceleration, then constant rates.

    Parameters
    ----------
    goal : (dof,) ndarray
        Joints [rad] at the time `until` [s].
    joints, rates : (3, dof) ndarray
        Filled with the samples at 0, at the switch and at `until`.

    Returns
    -------
    float
        When the acceleration ends [s]; -1 if no such movement keeps the limits of the joints.
    """
    limb, limits, switch = scene.limb, scene.limits, until
    for j in range(dof(limb)):  # the longer the acceleration lasts, the faster the end
        far = goal[j] - limb.start[j] - limb.rates[j] * until
        most = limits.joint_speed[j] * (1.0 - HAIR)
        spare = most - limb.rates[j] if far > 0.0 else most + limb.rates[j]
        if abs(far) > spare * until:
            return -1.0
        if abs(far) > 0.5 * spare * until:
            switch = min(switch, 2.0 * (until - abs(far) / spare))
    lever = switch * (until - 0.5 * switch)
    for j in range(dof(limb)):
        far = goal[j] - limb.start[j] - limb.rates[j] * until
        if abs(far) > limits.joint_acceleration[j] * (1.0 - HAIR) * lever:
            return -1.0
        force = far / lever
        joints[0, j], joints[2, j] = limb.start[j], goal[j]
        rates[0, j] = limb.rates[j]
        rates[1, j] = rates[2, j] = limb.rates[j] + force * switch
        joints[1, j] = limb.start[j] + switch * (limb.rates[j] + 0.5 * force * switch)
    return switch


def braked(plan: Movement, limits: np.ndarray) -> Movement:
    """A movement that goes on after its end until each joint rests, as soon as it can.

    A joint that would leave its range loses the rest of its speed at the end: it brakes harder than
    the limits.  A movement that is linear between samples knows no accelerations, and stops at its
    end.

    Parameters
    ----------
    plan : Movement
    limits : (dof,) ndarray
        Of the accelerations [rad/s^2].
    """
    if plan.rates is None:
        return plan
    rates, (low, high) = plan.rates[-1], np.array(plan.arm.joint_range).T
    room = np.where(rates > 0.0, high - plan.joints[-1], plan.joints[-1] - low)
    most = np.maximum(limits, rates**2 / (2.0 * np.maximum(room, _NO_ROOM)))
    stops = np.abs(rates) / most
    time = np.sort(stops[stops > _AT_ONCE])
    time = time[np.append(np.diff(time) > _AT_ONCE, True)] if time.size else time
    passed = np.minimum(time[:, None], stops)
    force = -np.sign(rates) * most
    return Movement(
        plan.arm,
        np.append(plan.time, plan.duration + time),
        np.vstack([plan.joints, plan.joints[-1] + passed * (rates + 0.5 * force * passed)]),
        np.vstack([plan.rates, rates + force * passed]),
    )


def tracked(
    time: np.ndarray,
    path: np.ndarray,
    rates: np.ndarray,
    limits: np.ndarray,
    knots: int = KNOTS,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Find the movement nearest to a timed path, with limited accelerations.

    Nearest is meant in the sum of squares over the path, its end above all.  Speeds and ranges are
    not checked.

    Parameters
    ----------
    time : (n,) ndarray
        [s], from 0.
    path : (n, dof) ndarray
        Joints, linear between the times [rad].
    rates : (dof,) ndarray
        Of the joints at the start [rad/s].
    limits : (dof,) ndarray
        Of the accelerations [rad/s^2].

    Returns
    -------
    time : (m,) ndarray
    joints, rates : (m, dof) ndarray
        Samples of the cubic Hermite curve.
    """
    from scipy.optimize import lsq_linear  # takes half a second to load

    end = time[-1]
    at, speeds, places, weights = _tracking(knots)
    wanted = np.stack(
        [np.interp(at * end, time, path[:, j]) for j in range(path.shape[1])], axis=-1
    )
    joints, moving = np.empty((2, knots + 1, path.shape[1]))
    share = np.linspace(0.0, 1.0, knots + 1)
    for j in range(path.shape[1]):
        off = wanted[:, j] - path[0, j] - rates[j] * end * at
        most = limits[j] * (1.0 - HAIR) * end * end
        force = lsq_linear(
            weights[:, None] * places, weights * off, (-most, most), method="bvls", tol=1e-9
        ).x
        joints[:, j] = path[0, j] + rates[j] * end * share + places[::SAMPLES] @ force
        moving[:, j] = rates[j] + speeds @ force / end
    return share * end, joints, moving


@lru_cache(maxsize=8)
def _tracking(knots: int) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Samples of a path of duration 1, and the effect of accelerations at the knots.

    Returns
    -------
    at : (m,) ndarray
        Samples; every SAMPLES-th is a knot.
    speeds : (knots + 1, knots + 1) ndarray
        Rates at knots from accelerations there.
    places : (m, knots + 1) ndarray
        Joints at samples.
    weights : (m,) ndarray
        Of the samples.
    """
    h = 1.0 / knots
    speeds, turned = np.zeros((knots + 1, knots + 1)), np.zeros((knots + 1, knots + 1))
    for k in range(knots):  # an acceleration that goes linearly from a to b in h
        speeds[k + 1] = speeds[k]
        speeds[k + 1, k] += 0.5 * h
        speeds[k + 1, k + 1] += 0.5 * h
        turned[k + 1] = turned[k] + h * speeds[k]
        turned[k + 1, k] += h * h / 3.0
        turned[k + 1, k + 1] += h * h / 6.0
    places = np.zeros((knots * SAMPLES + 1, knots + 1))
    for i in range(places.shape[0]):
        k = min(i // SAMPLES, knots - 1)
        s = h * (i / SAMPLES - k)
        places[i] = turned[k] + s * speeds[k]
        places[i, k] += 0.5 * s * s - s**3 / (6.0 * h)
        places[i, k + 1] += s**3 / (6.0 * h)
    weights = np.ones(places.shape[0])
    weights[-1] = _END
    return np.linspace(0.0, 1.0, places.shape[0]), speeds, places, weights
