"""Moves by which trees grow: straight lines, or ramps under limits of acceleration."""

from __future__ import annotations

from typing import NamedTuple

from gcm_learn.compiled import by_type, njit
from gcm_learn.planners.joints import ramps
from gcm_learn.planners.joints.goals import reach
from gcm_learn.planners.joints.moves import time_of, turning_time
from gcm_learn.planners.joints.pull import box

FROM_START, FROM_CATCH = 0, 1  # the trees
SPARE = 1.1  # of the least time of a ramp, since limbs rarely begin at rest
RESTS = 0.5  # share of nodes at which the limb comes to rest


class Lines(NamedTuple):
    """Straight moves of joints that have their rates at once."""

    none: float


LINES = Lines(0.0)


@njit(_nrt=False, forceinline=True)
def _line_box(moves, study, t):
    box(study, study.scene.limb.start, t)


@njit(_nrt=False)
def _ramp_box(moves, study, t):
    ramps.ramp_box(study, study.scene.limb.start, study.scene.limb.rates, t)


box_by = by_type({None: _line_box, ramps.Ramp: _ramp_box})
"""Write the joints that are within reach of the start in a time [s] into ``study``."""


@njit(_nrt=False, forceinline=True)
def _line_time(moves, limits, q, p):
    return turning_time(limits.joint_speed, q, p)


@njit(_nrt=False)
def _ramp_time(moves, limits, q, p):
    return ramps.least_ramp(limits, q, p, ramps.END_FREE)


time_by = by_type({None: _line_time, ramps.Ramp: _ramp_time})
"""Least time of a move from joints q at rest to p (n,), apart from the hand's speed [s]."""


@njit(_nrt=False)
def _line_soon(moves, study, q, p):
    return time_of(study, q, p)[0]


@njit(_nrt=False)
def _ramp_soon(moves, study, q, p):
    return SPARE * ramps.least_ramp(study.scene.limits, q, p, ramps.END_FREE)


soon_by = by_type({None: _line_soon, ramps.Ramp: _ramp_soon})
"""Time of a fast move from joints q to p (n,) that keeps the hand's speed [s]."""


@njit(_nrt=False, forceinline=True)
def _any_line(moves, limits, q, r, p, span, backward):
    return True


@njit(_nrt=False)
def _any_ramp(moves, limits, q, r, p, span, backward):
    return ramps.may_ramp(limits, q, r, p, span, backward)


may_by = by_type({None: _any_line, ramps.Ramp: _any_ramp})
"""Return whether there may be a move from q with rates r to p (n,), or to q with these rates."""


@njit(_nrt=False, forceinline=True)
def _no_rates(moves, tree, rates, drawn):
    return ramps.GIVEN


@njit(_nrt=False)
def _draw_rates(moves, tree, rates, drawn):
    for j in range(rates.size):
        rates[j] = 0.0
    if drawn < RESTS:
        return ramps.GIVEN
    return ramps.END_FREE if tree == FROM_START else ramps.START_FREE


rates_by = by_type({None: _no_rates, ramps.Ramp: _draw_rates})
"""Return which rates of the move to a new node are free, by a number in [0, 1); see `ramp`.

The rates (n,) at the node are those of rest until they are known.
"""


@njit(_nrt=False, forceinline=True)
def _line_between(moves, study, q, r, since, p, v, t, free):
    return reach(study, q, since, t, p, t)


@njit(_nrt=False)
def _ramp_between(moves, study, q, r, since, p, v, t, free):
    return ramps.reach_ramped(study, q, r, since, p, v, t, free, moves)


move_by = by_type({None: _line_between, ramps.Ramp: _ramp_between})
"""Free move from joints q with rates r at a time to p with rates v at t [s]; see `reach_ramped`."""


@njit(_nrt=False, forceinline=True)
def _halve_line(moves, q, there, rates, span):
    for j in range(q.size):
        q[j] = 0.5 * (q[j] + there[j])


@njit(_nrt=False)
def _halve_ramp(moves, q, there, rates, span):
    for j in range(q.size):
        q[j] = there[j] + 0.25 * (q[j] - there[j]) + 0.25 * rates[j] * span


halve_by = by_type({None: _halve_line, ramps.Ramp: _halve_ramp})
"""Draw joints q (n,) nearer to where a move began: to where it is after half of its time.

Under limits of acceleration that is where constant accelerations lead by then.
"""


@njit(_nrt=False, forceinline=True)
def _keep_none(moves, tree, free, rates):
    pass


@njit(_nrt=False)
def _keep_free(moves, tree, free, rates):
    for j in range(rates.size):
        if tree == FROM_START and free & ramps.END_FREE:
            rates[j] = moves.rates[3, j]
        elif tree == FROM_CATCH and free & ramps.START_FREE:
            rates[j] = moves.rates[0, j]


keep_by = by_type({None: _keep_none, ramps.Ramp: _keep_free})
"""Write the rates (n,) that were free, as the last move has them."""
