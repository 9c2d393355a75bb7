"""Rates that joints take in a step under their limits, and the curve of the step."""

from __future__ import annotations

import numpy as np

from gcm_learn.arms.curves import hermite, line
from gcm_learn.arms.limbs import dof
from gcm_learn.compiled import njit

_HAIR = 2e-9  # share of the joints' speeds that is not used, against rounding
SOFTER = 1e-6  # the same of accelerations, which short pieces tell with few digits


@njit(_nrt=False, forceinline=True)
def braking(rate, most):
    """Way in steps' time until a joint rests that brakes by at most `most` in each step.

    Rates change evenly within steps, so the last one, which takes what is left, counts in full.
    """
    whole = int(abs(rate) / most)
    rest = abs(rate) - whole * most
    return 0.5 * rest + whole * rest + 0.5 * whole * whole * most


@njit(_nrt=False, forceinline=True)
def _fastest_towards(room, most):
    """Greatest rate after a step of which the joint can rest `room` steps' rate farther on.

    `room` has what the rate before the step takes of it off; the inverse of half a rate and its
    `braking`.
    """
    if room <= 0.0:
        return room
    whole = int(0.5 * (np.sqrt(1.0 + 8.0 * room / most) - 1.0))
    return whole * most + (room - 0.5 * most * whole * (whole + 1.0)) / (whole + 1.0)


@njit(_nrt=False)
def wish(scene, posture, e, command, span, out):
    """Write into `out` (dof,) the rates nearest to a command (dof,) that keep the joints' limits.

    Under limits of acceleration these are the rates after the step, and leave the joint the way to
    stop before its range ends. Otherwise rates hold during the step and end at the range.
    """
    limb, limits, n = scene.limb, scene.limits, dof(scene.limb)
    for j in range(n):
        q, v = posture[e, j], posture[e, n + j]
        top = limits.joint_speed[j] * (1.0 - _HAIR)
        rate = min(max(command[e, j], -1.0), 1.0) * top
        most = limits.joint_acceleration[j] * span * (1.0 - SOFTER)
        if most < np.inf:
            rate = min(rate, _fastest_towards((limb.high[j] - q) / span - 0.5 * v, most))
            rate = max(rate, -_fastest_towards((q - limb.low[j]) / span + 0.5 * v, most))
            out[j] = min(max(rate, v - most), v + most)
        else:
            out[j] = (min(max(q + rate * span, limb.low[j]), limb.high[j]) - q) / span


@njit(_nrt=False)
def lay(scene, posture, e, rates, span, end, curve):
    """Write a step that ends with `rates` (dof,): its end (dof,) and its curve (dof, 4)."""
    limb, n = scene.limb, dof(scene.limb)
    q, v = posture[e, :n], posture[e, n:]
    free = scene.limits.joint_acceleration[0] == np.inf
    for j in range(n):
        mean = rates[j] if free else 0.5 * (v[j] + rates[j])
        end[j] = min(max(q[j] + mean * span, limb.low[j]), limb.high[j])
    if free:
        line(q, end, curve)
    else:
        hermite(q, v, end, rates, span, curve)
