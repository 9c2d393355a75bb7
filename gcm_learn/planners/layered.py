"""Planning with waits: causal marching over cells and their safe intervals."""

from __future__ import annotations

import numpy as np

from gcm_learn.maps import CognitiveMap, layered_map, task_of
from gcm_learn.planners.completion import Problem
from gcm_learn.planners.fronts import FrontPlanner, Way, marching_rungs
from gcm_learn.planners.timing import segment_times, straight_way
from gcm_learn.situation.situation import Arm
from gcm_learn.wave import LayeredFront, MarchingParams, Task, march_layers


def layered(params: MarchingParams | None = None) -> FrontPlanner[MarchingParams]:
    """The planner of first choice: marching in which the hand may wait.

    Where the straight line to the earliest interception holds, that is the answer, without a map.
    """
    return FrontPlanner("layered", marching_rungs(params), _explore, direct=True)


def _explore(
    problem: Problem, params: MarchingParams, ignore: float
) -> tuple[CognitiveMap, Way | None]:
    """Layered map and the way back through its states."""
    task = task_of(problem.situation, params, problem.bodies, ignore)
    front = march_layers(task, params)
    way = way_to(front, task, problem.situation.arm) if front.met_state >= 0 else None
    return layered_map(problem.situation, task, front), way


def way_to(front: LayeredFront, task: Task, arm: Arm) -> tuple[np.ndarray, np.ndarray]:
    """Way from the hand to where the target is met, with waits.

    Returns
    -------
    hand : (m, 2) ndarray
        Straight pieces between the states on the way, sampled.
    wanted : (m,) ndarray
        When the hand should be there [s]; it waits at the end of each piece.
    """
    chain = []
    state = front.met_state
    while state >= 0:
        chain.append(state)
        state = int(front.via[state])
    chain.reverse()
    centres = task.lattice.centres
    hand, wanted = [np.array([task.hand])], [np.zeros(1)]
    for state in chain:
        iy, ix = front.cells[state]
        piece = straight_way(hand[-1][-1], np.array([centres[ix], centres[iy]]))
        under_way = np.concatenate([[0.0], np.cumsum(segment_times(arm, piece))])
        leave = max(front.arrival[state] - under_way[-1], wanted[-1][-1])
        share = under_way / max(under_way[-1], 1e-300)
        times = leave + share * (front.arrival[state] - leave)
        hand += [piece[:1], piece[1:]]
        wanted += [np.array([leave]), times[1:]]
    return np.vstack(hand), np.concatenate(wanted)
