"""Planning with waits: causal marching over cells and their safe intervals."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gcm_learn.arm.lattice import LARGEST_LATTICE
from gcm_learn.maps import CognitiveMap, layered_map, task_of
from gcm_learn.planners.completion import Problem, checked, finish
from gcm_learn.planners.fronts import HALF_DIAGONAL
from gcm_learn.planners.plan import Plan
from gcm_learn.planners.timing import straight_way
from gcm_learn.situation import Situation
from gcm_learn.wave import LayeredFront, MarchingParams, Task, march_layers


@dataclass(frozen=True)
class LayeredPlanner:
    """Earliest catch when the hand may wait; like `FrontPlanner`, with more care on failure."""

    rungs: tuple[MarchingParams, ...]
    """Parameters of the fronts to try, in order."""
    name: str = "layered"
    contacts: int = 3
    """How many meetings with a target to try before the next front."""

    def plan(self, situation: Situation) -> Plan:
        """Answer a situation."""
        problem = Problem(situation, self.name)
        answer = problem.early_answer()
        if answer is not None:
            return answer
        first: CognitiveMap | None = None
        reason = ""
        for params in self.rungs:
            task = task_of(situation, params, problem.bodies)
            for attempts in range(self.contacts):
                front = march_layers(task, params)
                front_map = layered_map(situation, task, front)
                first = front_map if first is None else first
                if front.met_state < 0:
                    reason = reason or "no target can be met within the horizon, waits included"
                    break
                attempt = finish(problem, *way_to(front, task))
                if attempt is None:
                    reason = "no target can be met from where the hand may wait"
                else:
                    plan, reason = checked(problem, attempt, front_map)
                    if plan is not None:
                        return plan
                # Meetings that fail come in rows: skip ever more of them.
                skip = 2**attempts * task.lattice.spacing / task.speed
                task = replace(task, ignore=front.met_time + skip)
        return problem.answer("unreachable", reason, first)


def layered(params: MarchingParams | None = None) -> LayeredPlanner:
    """The planner of first choice: layered marching."""
    params = MarchingParams() if params is None else params
    bare = replace(params, margin=0.0, lookback=0.0, slack=HALF_DIAGONAL)
    finer, bare_finer = (replace(p, n=min(2 * p.n, LARGEST_LATTICE)) for p in (params, bare))
    return LayeredPlanner((params, bare, finer, bare_finer))


def way_to(front: LayeredFront, task: Task) -> tuple[np.ndarray, np.ndarray]:
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
        length = float(np.hypot(*(piece[-1] - piece[0])))
        leave = max(front.arrival[state] - length / task.speed, wanted[-1][-1])
        times = np.linspace(leave, front.arrival[state], len(piece))
        hand += [piece[:1], piece[1:]]
        wanted += [np.array([leave]), times[1:]]
    return np.vstack(hand), np.concatenate(wanted)
