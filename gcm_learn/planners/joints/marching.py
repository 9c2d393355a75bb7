"""Marching in space: a front over the hand's cells, its map, and the way the front came."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from gcm_learn.compiled import njit
from gcm_learn.maps import IN_SPACE, CognitiveMap, Interception, build_map, chain_to
from gcm_learn.motion import Failure, Movement, Reason
from gcm_learn.planners.completion import Attempt, JointProblem, judged
from gcm_learn.planners.joints import ways
from gcm_learn.planners.joints.goals import reach
from gcm_learn.planners.joints.moves import Study, time_of
from gcm_learn.planners.joints.pull import met_from
from gcm_learn.planners.joints.straight import at_once
from gcm_learn.planners.plan import Plan, in_joints
from gcm_learn.scene import Scene
from gcm_learn.situation import AnySituation
from gcm_learn.wave import fastest

CELLS = (16, 24, 32, 40)  # along a side of the lattices: each has postures of its own
CONTACTS = 32  # of a front that are tried
ENDINGS = 24  # moments at which a way's end is tried
LATER = 3.0  # from one of them to the next [crossings of a cell]
BACK = (0, 1, 2, 4, 8, 16)
"""Numbers of postures that are left out at the end of a way: the hand mostly has to turn there."""


@dataclass(frozen=True)
class HandMarching:
    """Marching over cells of the hand; each cell has the one posture that the front found.

    A cell can be missed that only another posture can enter.  The approach of a target is asked at
    the end only.  Under limits of acceleration there is no answer.
    """

    cells: tuple[int, ...] = CELLS
    """Along a side of the lattices, one after the other."""
    name: ClassVar[str] = "marching"
    accelerates: ClassVar[bool] = False
    takes = staticmethod(in_joints)

    def plan(self, situation: AnySituation) -> Plan:
        """Answer a situation."""
        problem = JointProblem(situation, self.name)
        answer = problem.early_answer() or at_once(problem)
        return self._search(problem) if answer is None else answer

    def _search(self, problem: JointProblem) -> Plan:
        situation, study, scene = problem.situation, problem.study, kept(problem)
        reason: Reason | None = None
        for n in self.cells:
            found = build_map(situation, replace(IN_SPACE, n=n, until="horizon"), scene=scene)
            if found.interception is None:
                reason = reason or Reason(Failure.NO_INTERCEPTION)
            for met in meetings(problem, found):
                plan, reason = followed(problem, study, met)
                if plan is not None:
                    return plan
        return problem.answer(reason or Failure.NO_INTERCEPTION, found)


def kept(problem: JointProblem) -> Scene:
    """Return the scene with a thicker limb, so that its free moves surely pass verification."""
    scene = problem.scene
    return scene._replace(limb=scene.limb._replace(thickness=problem.rules.touch))


def followed(
    problem: JointProblem, study: Study, found: CognitiveMap
) -> tuple[Plan | None, Reason | None]:
    """Follow a map to its interception; return the plan of the shortened way, or the reason.

    Parameters
    ----------
    found : CognitiveMap
        A map with an interception; it says where its front came from.
    """
    assert found.interception is not None
    nodes = np.array(chain_to(found, found.met))
    joints, times = (found.postures(nodes), found.arrival.ravel()[nodes].filled(0.0).astype(float))
    body = [b.name for b in problem.situation.bodies].index(found.interception.body)
    way, out = ways.new_way(joints.shape[1]), ways.new_way(joints.shape[1])
    if len(nodes) + 2 > ways.MOST or not lay(study, joints, times, way):
        return None, Reason(Failure.NO_ENDING)
    wanted, last = found.interception.time, int(way.size[0]) - 1
    apart = LATER * found.chart.spacing / fastest(problem.scene)
    if not any(end(study, way, last - k, body, wanted, apart) for k in BACK if k <= last):
        return None, Reason(Failure.NO_ENDING)
    ways.shorten(study, way, out)
    ways.hasten(study, out)
    time, path, caught = ways.samples_of(study, out)
    attempt = Attempt(Movement(problem.situation.arm, time, path), int(caught))
    plan, verdict = judged(problem, attempt, found)
    return plan, verdict.reason


def meetings(problem: JointProblem, found: CognitiveMap) -> Iterator[CognitiveMap]:
    """Yield a map with its interception, then with those at CONTACTS - 1 other cells, by time."""
    if found.interception is None:
        return
    yield found
    arrival = found.arrival.filled(np.inf).ravel()
    met = np.flatnonzero(found.effective_target)
    met = met[np.argsort(arrival[met], kind="stable")]
    for node in met[met != found.met][: CONTACTS - 1]:
        cell = tuple(int(i) for i in np.unravel_index(node, found.chart.shape))
        place, time = found.chart.hand_at(node), float(arrival[node])
        for target in problem.situation.targets:
            yield replace(found, interception=Interception(cell, place, time, target.name))


@njit(_nrt=False)
def lay(study: Study, joints: np.ndarray, times: np.ndarray, way: ways.JointWay) -> bool:
    """Write the way through joints (m, dof), wanted at times (m,), as soon as limits allow.

    If time is left, the limb moves more slowly.  Returns whether it comes before the horizon.
    """
    limits, now = study.scene.limits, 0.0
    ways.write(way, 0, study.scene.limb.start, 0.0, 0.0)
    for k in range(times.size):
        took, _ = time_of(study, way.joints[k], joints[k])
        now = max(now + took, times[k])
        ways.write(way, k + 1, joints[k], now, now)
    return now < limits.horizon


@njit(_nrt=False)
def end(
    study: Study, way: ways.JointWay, last: int, body: int, wanted: float, later: float
) -> bool:
    """End a way on a body by a straight move from posture `last` of the way.

    Parameters
    ----------
    last : int
        Number of the posture.
    wanted : float
        When the body is expected at the last posture [s].
    later : float
        From one moment that is tried to the next [s].

    Returns
    -------
    bool
        Whether there is such a move.
    """
    horizon, near = study.scene.limits.horizon, way.joints[way.size[0] - 1]
    q, since, goal = way.joints[last], way.reached[last], study.goal
    for k in range(1, ENDINGS + 1):
        t = min(max(since, wanted) + k * later, horizon)
        if met_from(study, q, since, body, near, t) > 0:
            begin, arrive = reach(study, q, since, t, goal, t)
            if begin >= 0.0:
                way.left[last], way.body[0] = begin, body
                ways.write(way, last + 1, goal, arrive, t)
                return True
        if t >= horizon:
            break
    return False
