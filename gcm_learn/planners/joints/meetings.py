"""Times at which targets can be met if nothing is in the way."""

from __future__ import annotations

import numpy as np

from gcm_learn import seeding
from gcm_learn.compiled import njit
from gcm_learn.planners.completion import JointProblem
from gcm_learn.planners.joints.pull import box, pulled
from gcm_learn.planners.stages import stages
from gcm_learn.situation import AnySituation

INSTANTS = 12  # of a stage that are asked
DRAWS = 2  # postures that are pulled to a target at each


def soonest(situation: AnySituation) -> dict[str, float]:
    """Estimate when each target can be met at the earliest, obstacles and accelerations left out.

    Returns
    -------
    dict of str to float
        Times of the targets that can be met at all [s].
    """
    study = JointProblem(situation, "soonest").study
    shares, parts = np.arange(1, INSTANTS + 1), stages(situation, situation.horizon)
    times = np.unique([start + (end - start) * shares / INSTANTS for start, end in parts])
    goals = seeding.rng(0).random((times.size, DRAWS, study.goal.size))
    found = {}
    for k, body in enumerate(situation.bodies):
        if body.role == "target":
            time = first_met(study, k, times, goals.copy())
            if time >= 0.0:
                found[body.name] = float(time)
    return found


@njit(_nrt=False)
def first_met(study, b, times, goals):
    """Return the first of some times [s] at which a drawn posture can be turned to meet body b.

    Parameters
    ----------
    study : Study
    b : int
    times : (k,) ndarray
    goals : (k, m, n) ndarray
        Draws from the unit cube; overwritten.

    Returns
    -------
    float
        -1 if there is none.
    """
    for i in range(times.size):
        for k in range(goals.shape[1]):
            if meets(study, b, times[i], goals[i, k]):
                return times[i]
    return -1.0


@njit(_nrt=False)
def meets(study, b, t, q):
    """Turn a drawn posture until the hand catches body b at t [s]; return whether it does.

    Parameters
    ----------
    study : Study
    b : int
    t : float
    q : (n,) ndarray
        A draw from the unit cube, taken as joints that a straight move from the start can reach;
        overwritten by the posture [rad].
    """
    box(study, study.scene.limb.start, t)
    for j in range(q.size):
        q[j] = study.low[j] + q[j] * (study.high[j] - study.low[j])
    return pulled(study, b, t, q)
