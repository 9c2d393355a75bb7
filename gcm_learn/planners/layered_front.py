"""Plans from maps in which the hand may wait."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from gcm_learn.arms import Arm
from gcm_learn.charts import chart_of
from gcm_learn.maps import explore, map_of
from gcm_learn.planners.completion import (
    Attempt,
    Problem,
    finish,
    go_on,
    path_through,
    straight_catch,
    timed,
)
from gcm_learn.planners.feedback import Exploration, Feedback
from gcm_learn.planners.fronts import Level, finer, first_arrival, without_margin
from gcm_learn.wave import Front, MarchingParams, WaveParams, fastest

MEETING = 1.5  # the hand may meet a target so long before the map says so [crossings]
A_WAIT = 0.3  # a stay that is longer is a wait [crossings]
BEYOND = 4.0  # what a path through cells' centres loses at most to the best one [crossings]
DELAYS = (0.0, 0.5, 1.0, 1.5, 2.0)  # with which a last wait is left [crossings]


def levels(params: MarchingParams) -> tuple[Level, ...]:
    """Return maps to ask in turn, the quickest first.

    The map without margin sees every gap that is as wide as a cell. The search ends if this map has
    no interception.  Descents on first-arrival maps cut corners in another way than
    chains of cells do, and now and then hold where those fail.
    """
    bare = without_margin(params)
    # A front that enters a cell as soon as its centre is free is early; one that does not misses
    # gaps that are open for a moment.
    patient = replace(bare, lookback=params.lookback)
    return (
        Level(params, waiting),
        Level(bare, waiting, 4, BEYOND, decisive=True),
        Level(params, first_arrival),
        Level(bare, first_arrival),
        Level(patient, waiting, 8, BEYOND),
        Level(finer(params), waiting),
        Level(finer(patient), waiting, 16, BEYOND),
        Level(finer(bare), waiting, 8, BEYOND),
        Level(finer(bare), first_arrival),
    )


def waiting(problem: Problem, params: MarchingParams, feedback: Feedback) -> Exploration:
    """Make the layered map, and paths back through the map's states."""
    return explored(problem, spread(problem, params, feedback), params)


def spread(problem: Problem, params: WaveParams | MarchingParams, feedback: Feedback) -> Front:
    """Let a front that may wait spread over the arm's hand-space."""
    chart = chart_of(problem.situation.arm, params.n)
    return explore(
        feedback.applied(problem.scene, chart),
        chart,
        params,
        wait=True,
        ignore=feedback.ignore,
        widening=feedback.widening,
    )


def explored(problem: Problem, front: Front, params: WaveParams | MarchingParams) -> Exploration:
    """Make the map of a front that waits, and the paths that end at the map's interception."""
    found = map_of(problem.situation, problem.scene, front, params)
    if front.met_state < 0:
        return Exploration(found)
    chain = front.chain()
    wait = _last_wait(problem, front, chain)
    corner = len(chain) - 2 if wait < 0 else wait
    return Exploration(
        found,
        _attempts(problem, front, chain, wait),
        arrived=float(front.arrival[front.met_state]),
        shared=float(front.arrival[chain[corner]]) if corner >= 0 else 0.0,
    )


def path_to(front: Front, arm: Arm, chain: list[int]) -> tuple[np.ndarray, np.ndarray]:
    """Return the hand's way (m, 2) through states, with waits, and its wanted times (m,) [s]."""
    return path_through(arm, front.chart.hands[front.nodes[chain]], front.arrival[chain])


def _attempts(problem: Problem, front: Front, chain: list[int], wait: int) -> Iterator[Attempt]:
    """Paths that end at the interception, the soonest first.

    - From the last corner straight to the target.
    - Through the cell of the interception and on to the target.
    - The same with a rest in that cell until the target comes.
    - From the last wait straight to the target, a little later if need be. `wait` is its index, -1
      without a wait.
    """
    arm, crossing = problem.situation.arm, front.chart.spacing / fastest(problem.scene)

    def until(count: int) -> tuple[np.ndarray, np.ndarray]:
        hand, wanted = path_to(front, arm, chain[:count])
        return timed(arm, wanted, hand) if count > 0 else (wanted, hand)

    time, hand = until(len(chain) - 1)
    paths = [go_on(problem, time, hand, straight_catch(problem, hand[-1], float(time[-1])))]
    yield from (path for path in paths if path is not None)
    whole = finish(problem, *path_to(front, arm, chain))
    if whole is not None:
        yield whole
    time, hand = until(len(chain))
    for early in (MEETING, 0.0):
        after = front.met_time - early * crossing
        ending = straight_catch(problem, hand[-1], float(time[-1]), after=after, wait=True)
        rested = go_on(problem, time, hand, ending)
        if rested is not None:
            yield rested
    if wait < 0:
        return
    time, hand = until(wait + 1)
    leave = _leaves(problem, front, chain, wait)
    for delay in DELAYS:
        left = max(leave + delay * crossing, float(time[-1]))
        waited, stays = np.append(time, left), np.vstack([hand, hand[-1:]])
        dash = go_on(problem, waited, stays, straight_catch(problem, hand[-1], left))
        if dash is not None:
            yield dash


def _leaves(problem: Problem, front: Front, chain: list[int], k: int) -> float:
    """Return the time at which the hand leaves state k of a chain for the next state [s]."""
    here, there = front.chart.hands[front.nodes[chain[k : k + 2]]]
    away = np.hypot.reduce(there - here)
    return float(front.arrival[chain[k + 1]] - away / fastest(problem.scene))


def _last_wait(problem: Problem, front: Front, chain: list[int]) -> int:
    """Return the index of the last state of a chain where the hand waits before going on, or -1."""
    stay = A_WAIT * front.chart.spacing / fastest(problem.scene)
    for k in range(len(chain) - 2, -1, -1):
        if _leaves(problem, front, chain, k) - front.arrival[chain[k]] > stay:
            return k
    return -1
