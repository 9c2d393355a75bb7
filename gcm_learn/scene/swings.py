"""Pendulums as tables of angle and rate."""

from __future__ import annotations

import numpy as np

from gcm_learn.compiled import njit
from gcm_learn.situation import Pendulum

STEPS_PER_PERIOD = 2000  # Hermite error about (2 pi / 2000)^4 / 384, i.e. 3e-13 rad


def swing_tables(
    swings: list[Pendulum], horizon: float, least: int = 64
) -> tuple[float, np.ndarray]:
    """Integrate every pendulum on one time grid of at least so many entries.

    Returns
    -------
    step : float
        Time step of the grid [s].
    angles : (k, m, 2) ndarray
        Angle [rad] and rate [rad/s].
    """
    if not swings:
        return 1.0, np.zeros((0, 2, 2))
    fastest = max(m.fastest for m in swings)
    wanted = int(np.ceil(horizon * fastest * STEPS_PER_PERIOD / (2 * np.pi))) + 2
    count = max(wanted, least)
    step = horizon / (count - 2)
    tables = [
        integrate_swing(m.angle, m.rate, m.gravity / m.length, m.damping, step, count)
        for m in swings
    ]
    return step, np.array(tables)


@njit
def integrate_swing(angle, rate, stiffness, damping, step, count):
    """Integrate angle'' = -stiffness sin(angle) - damping angle' by classical Runge-Kutta.

    Returns
    -------
    (count, 2) ndarray
        Angle [rad] and rate [rad/s] at 0, step, 2 step, ...
    """
    out = np.empty((count, 2))
    out[0, 0], out[0, 1] = angle, rate
    for i in range(1, count):
        k1 = -stiffness * np.sin(angle) - damping * rate
        r2 = rate + 0.5 * step * k1
        k2 = -stiffness * np.sin(angle + 0.5 * step * rate) - damping * r2
        r3 = rate + 0.5 * step * k2
        k3 = -stiffness * np.sin(angle + 0.5 * step * r2) - damping * r3
        r4 = rate + step * k3
        k4 = -stiffness * np.sin(angle + step * r3) - damping * r4
        angle += step * (rate + 2.0 * r2 + 2.0 * r3 + r4) / 6.0
        rate += step * (k1 + 2.0 * k2 + 2.0 * k3 + k4) / 6.0
        out[i, 0], out[i, 1] = angle, rate
    return out
