"""Marching in space: a front over cells and postures, its map, and the way that it came."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from gcm_learn.charts import chart_of
from gcm_learn.compiled import njit
from gcm_learn.maps import CognitiveMap, Interception, build_map, chain_to
from gcm_learn.motion import Failure, Movement, Reason
from gcm_learn.planners.completion import Attempt, SpatialProblem, judged
from gcm_learn.planners.joints.accelerated import plan_accelerated
from gcm_learn.planners.joints.goals import no_goals, reach
from gcm_learn.planners.joints.moves import Study, time_of
from gcm_learn.planners.joints.pull import met_from
from gcm_learn.planners.joints.straight import at_once
from gcm_learn.planners.joints.ways import (
    MOST,
    Way,
    hasten,
    new_way,
    samples_of,
    shorten,
    write,
)
from gcm_learn.planners.plan import Plan, in_joints
from gcm_learn.scene import HAND, PART, Scene
from gcm_learn.situation import AnySituation
from gcm_learn.wave import MarchingParams, fastest

INSTANTS, SWIVELS = 32, 12  # of interceptions that are dashed for under limits of acceleration
ENDINGS = 24  # moments at which a way's end is tried
CELLS = (16, 24, 32, 40)  # along a side of the lattices of chains: each has postures of its own
CONTACTS = 32  # of a chain's front that are tried
LATER = 0.25  # from one of them to the next [crossings of a cell]


class Endings(NamedTuple):
    """Straight moves at the end of a way that are tried."""

    later: float = LATER
    """From one moment to the next [crossings of a cell]."""
    back: tuple[int, ...] = (0,)
    """Numbers of postures that are left out at the end of the way."""

    def of(self, way: Way) -> list[int]:
        """Return the postures of a way from which its end is tried."""
        last = int(way.size[0]) - 1
        return [last - k for k in self.back if k <= last]


LAST = Endings()
CHAIN_ENDINGS = Endings(3.0, (0, 1, 2, 4, 8, 16))
"""Ends of chains, whose hand mostly has to turn into the approach, too."""


@dataclass(frozen=True)
class FrontInSpace:
    """Maps, until the way to an interception holds."""

    name: str
    levels: tuple[tuple[MarchingParams, int], ...]
    """Parameters of the fronts, and postures in a cell."""
    trials: int = 3
    """Fronts on each of them, each for interceptions later than those before."""
    contacts: int = 1
    """Interceptions that are tried of each front."""
    endings: Endings = LAST
    accelerates: bool = True
    """Limits of acceleration are kept."""

    takes = staticmethod(in_joints)

    def plan(self, situation: AnySituation) -> Plan:
        """Answer a situation."""
        problem = SpatialProblem(situation, self.name)
        answer = problem.early_answer(self.accelerates) or at_once(problem)
        if answer is None and problem.accelerates:
            targets = int((problem.bodies.rows[:, PART] == HAND).sum())
            times = problem.situation.horizon * np.arange(1, INSTANTS + 1) / INSTANTS
            tried = no_goals(len(problem.situation.arm.joints), targets, INSTANTS, SWIVELS), times
            answer = plan_accelerated(problem, tried, SWIVELS, self.plan)
        return self._search(problem) if answer is None else answer

    def _search(self, problem: SpatialProblem) -> Plan:
        situation = problem.situation
        study, scene = problem.study, kept(problem)
        reason: Reason | None = None
        for params, postures in self.levels:
            chart, ignore = chart_of(situation, params.n, postures), 0.0
            for trial in range(self.trials):
                found = build_map(situation, params, chart=chart, scene=scene, ignore=ignore)
                if found.interception is None:
                    reason = reason or Reason(Failure.NO_INTERCEPTION)
                    break
                for met in meetings(problem, found, self.contacts):
                    plan, reason = followed(problem, study, met, self.endings)
                    if plan is not None:
                        return plan
                ignore = found.interception.time + 2**trial * chart.spacing / fastest(scene)
        return problem.answer(reason or Failure.NO_INTERCEPTION, found)


def posture_marching(postures: tuple[int, ...] = (1, 4, 8)) -> FrontInSpace:
    """Marching over cells of ever more postures."""
    params = MarchingParams(n=40, margin=0.0)
    return FrontInSpace("marching", tuple((params, count) for count in postures))


def hand_marching() -> FrontInSpace:
    """Marching over cells of a chain's hand, each with the one posture that the front found.

    A cell can be missed that only another posture can enter.  The approach of a target is asked at
    the end only.  Under limits of acceleration there is no answer.
    """
    levels = tuple((MarchingParams(n=n, margin=0.0, until="horizon"), 1) for n in CELLS)
    return FrontInSpace("marching", levels, 1, CONTACTS, endings=CHAIN_ENDINGS, accelerates=False)


def kept(problem: SpatialProblem) -> Scene:
    """The scene with a limb so thick that what it keeps is surely verified."""
    scene = problem.scene
    return scene._replace(limb=scene.limb._replace(thickness=problem.rules.touch))


def followed(
    problem: SpatialProblem, study: Study, found: CognitiveMap, endings: Endings
) -> tuple[Plan | None, Reason | None]:
    """The way to a map's interception, made shorter and ended on the target, or why it fails.

    Parameters
    ----------
    found : CognitiveMap
        A map with an interception; it says where its front came from.
    endings : Endings
    """
    assert found.interception is not None
    nodes = np.array(chain_to(found, found.met))
    joints, times = (
        found.postures(nodes),
        found.arrival.ravel()[nodes].filled(0.0).astype(float),
    )
    body = [b.name for b in problem.situation.bodies].index(found.interception.body)
    way, out = new_way(joints.shape[1]), new_way(joints.shape[1])
    if len(nodes) + 2 > MOST or not lay(study, joints, times, way):
        return None, Reason(Failure.NO_ENDING)
    wanted = found.interception.time
    apart = endings.later * found.chart.spacing / fastest(problem.scene)
    if not any(end(study, way, k, body, wanted, apart) for k in endings.of(way)):
        return None, Reason(Failure.NO_ENDING)
    shorten(study, way, out)
    hasten(study, out)
    time, path, caught = samples_of(study, out)
    attempt = Attempt(Movement(problem.situation.arm, time, path), int(caught))
    plan, verdict = judged(problem, attempt, found)
    return plan, verdict.reason


def meetings(problem: SpatialProblem, found: CognitiveMap, most: int) -> Iterator[CognitiveMap]:
    """Yield a map with its interception, then with others in order of time, `most` in all."""
    yield found
    if most == 1:
        return
    arrival = found.arrival.filled(np.inf).ravel()
    met = np.flatnonzero(found.effective_target)
    met = met[np.argsort(arrival[met], kind="stable")]
    for node in met[met != found.met][: most - 1]:
        cell = tuple(int(i) for i in np.unravel_index(node, found.chart.shape))
        place, time = found.chart.hand_at(node), float(arrival[node])
        for target in problem.situation.targets:
            yield replace(found, interception=Interception(cell, place, time, target.name))


@njit(_nrt=False)
def lay(study: Study, joints: np.ndarray, times: np.ndarray, way: Way) -> bool:
    """Write the way through joints (m, dof), wanted at times (m,), as soon as limits allow.

    If time is left, the limb moves more slowly.  Returns whether it comes before the horizon.
    """
    limits, now = study.scene.limits, 0.0
    write(way, 0, study.scene.limb.start, 0.0, 0.0)
    for k in range(times.size):
        took, _ = time_of(study, way.joints[k], joints[k])
        now = max(now + took, times[k])
        write(way, k + 1, joints[k], now, now)
    return now < limits.horizon


@njit(_nrt=False)
def end(study: Study, way: Way, last: int, body: int, wanted: float, later: float) -> bool:
    """Let a way end on a body by a straight move from one of its postures.

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
                write(way, last + 1, goal, arrive, t)
                return True
        if t >= horizon:
            break
    return False
