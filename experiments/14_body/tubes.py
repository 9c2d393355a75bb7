"""The width of the tube about many plans, by the speed of the hand."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gcm_learn.errors import PhysicsError
from gcm_learn.execution import MECHANICS, Execution
from gcm_learn.execution.body.model import STEP
from gcm_learn.planners import Tube

QUANTILE = 0.99
"""Share of moments that are within the tube, at every speed."""
BINS = 8
"""Of speeds, each with as many moments."""


def measured_tube(done: Sequence[Execution], quantile: float = QUANTILE) -> Tube:
    """The tube about plans in which arms stayed until their catches; in metres.

    The width at rest is that of the slowest eighth of all moments; what each m/s adds is the most
    that any faster eighth asks for.

    Parameters
    ----------
    done : sequence of Execution
        Of one body and one controller.
    quantile : float
        Share of the moments of each eighth that are inside.

    Raises
    ------
    PhysicsError
        If nothing was executed.
    """
    rows = [_moments(one) for one in done if one.plant is not None]
    if not rows:
        raise PhysicsError("tube: nothing was executed that could be measured")
    speed, off = np.concatenate(rows).T
    order = np.argsort(speed, kind="stable")
    parts = [part for part in np.array_split(order, BINS) if part.size]
    widths = np.array([np.quantile(off[part], quantile) for part in parts])
    middles = np.array([speed[part].mean() for part in parts])
    rise = np.maximum(widths[1:] - widths[0], 0.0) / np.maximum(middles[1:], 1e-12)
    return Tube(float(widths[0]), float(rise.max(initial=0.0)))


def _moments(done: Execution) -> np.ndarray:
    """Speed of the planned hand and how far the limb is from its plan at every step (n, 2) [m]."""
    plant, plan = done.plant, done.plan
    assert plant is not None and plan is not None
    steps = np.arange(round(done.movement.duration / STEP) + 1)
    time = steps * STEP
    points = MECHANICS.of(plan.arm).points
    there, wanted = (
        points(plan.arm, plant.joints_log[steps]),
        points(plan.arm, plan.joints_at(time)),
    )
    off = np.linalg.norm(there - wanted, axis=2).max(axis=1)
    speed = np.linalg.norm(np.gradient(wanted[:, -1], STEP, axis=0), axis=1)
    return np.stack([speed, off], axis=1) * plant.body.metres
