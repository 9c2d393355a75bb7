"""Terms of the reward of a step: the same for every kind of arm."""

from __future__ import annotations

from gcm_learn.compiled import njit
from gcm_learn.execution.arena.kernels.world import CAUGHT, COLLIDED

CATCH, TOUCH, HASTE, GUIDE = range(4)  # terms of the reward
TERMS = 4


@njit(_nrt=False)
def pay(told, e, outcome, share, weights, nearer):
    """Write the outcome of a step of arm e, and the terms of its reward.

    Parameters
    ----------
    told : Told
    share : float
        Of the horizon that the step took.
    weights : (4,) ndarray
    nearer : float
        Potential before the step less the discounted one after it. The potential after an end is
        0, or the optimum would change.
    """
    terms = told.terms
    told.outcomes[e] = outcome
    terms[e, CATCH] = weights[CATCH] if outcome == CAUGHT else 0.0
    terms[e, TOUCH] = -weights[TOUCH] if outcome == COLLIDED else 0.0
    terms[e, HASTE] = -weights[HASTE] * share
    terms[e, GUIDE] = weights[GUIDE] * nearer
