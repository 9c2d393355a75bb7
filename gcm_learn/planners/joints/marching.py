"""Marching in space: a front over cells and postures, its map, and the way that it came."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gcm_learn.charts import PostureLattice, posture_lattice_of
from gcm_learn.compiled import njit
from gcm_learn.maps import CognitiveMap, build_map, chain_to
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
from gcm_learn.planners.plan import Plan, spatial_only
from gcm_learn.scene import HAND, PART, Scene
from gcm_learn.situation import AnySituation
from gcm_learn.wave import MarchingParams, WaveParams, fastest

INSTANTS, SWIVELS = 32, 12  # of interceptions that are dashed for under limits of acceleration
ENDINGS = 24  # moments at which a way's end is tried
LATER = 0.25  # from one of them to the next [crossings of a cell]


@dataclass(frozen=True)
class FrontInSpace:
    """Maps, until the way to an interception holds."""

    name: str
    levels: tuple[tuple[WaveParams | MarchingParams, int], ...]
    """Parameters of the fronts, and postures in a cell."""
    trials: int = 3
    """Interceptions that are tried on each of them."""
    wait: bool = False
    """The hand may wait: maps then have sheets."""

    takes = staticmethod(spatial_only)

    def plan(self, situation: AnySituation) -> Plan:
        """Answer a situation."""
        problem = SpatialProblem(situation, self.name)
        answer = problem.early_answer(keeps_acceleration=True) or at_once(problem)
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
            chart, ignore = posture_lattice_of(situation.arm, params.n, postures), 0.0
            for trial in range(self.trials):
                found = build_map(
                    situation, params, chart=chart, scene=scene, ignore=ignore, wait=self.wait
                )
                if found.interception is None:
                    reason = reason or Reason(Failure.NO_INTERCEPTION)
                    break
                plan, reason = followed(problem, study, found, chart)
                if plan is not None:
                    return plan
                ignore = found.interception.time + 2**trial * chart.spacing / fastest(scene)
        return problem.answer(reason or Failure.NO_INTERCEPTION, found)


def posture_marching(postures: tuple[int, ...] = (1, 4, 8), *, wait: bool = False) -> FrontInSpace:
    """Marching over cells of ever more postures; the hand may `wait`."""
    params = MarchingParams(n=40, margin=0.0)
    return FrontInSpace("marching", tuple((params, count) for count in postures), wait=wait)


def gcm_in_space(params: WaveParams | None = None) -> FrontInSpace:
    """The paper's planner in space: the wave of Eq. 10 over cells of one posture.

    With a margin first, as in the plane, then without one: moves are judged for what they are.
    """
    params = WaveParams(step=0.4) if params is None else params
    return FrontInSpace("gcm", ((params, 1), (replace(params, margin=0.0), 1)))


def kept(problem: SpatialProblem) -> Scene:
    """The scene with a limb so thick that what it keeps is surely verified."""
    scene = problem.scene
    return scene._replace(limb=scene.limb._replace(thickness=problem.rules.touch))


def followed(
    problem: SpatialProblem, study: Study, found: CognitiveMap, chart: PostureLattice
) -> tuple[Plan | None, Reason | None]:
    """The way to a map's interception, made shorter and ended on the target, or why it fails.

    Parameters
    ----------
    found : CognitiveMap
        A map with an interception; it says where its front came from.
    chart : PostureLattice
        The chart of the map.
    """
    assert found.interception is not None
    states = np.array(chain_to(found, found.met))
    joints = chart.joints_at(states % chart.size)
    times = found.sheets.ravel()[states].filled(0.0).astype(float)
    body = [b.name for b in problem.situation.bodies].index(found.interception.body)
    way, out = new_way(joints.shape[1]), new_way(joints.shape[1])
    if len(states) + 2 > MOST or not lay(study, joints, times, found.engine == "layered", way):
        return None, Reason(Failure.NO_ENDING)
    later = LATER * chart.spacing / fastest(problem.scene)
    if not end(study, way, body, found.interception.time, later):
        return None, Reason(Failure.NO_ENDING)
    shorten(study, way, out)
    hasten(study, out)
    time, path, caught = samples_of(study, out)
    attempt = Attempt(Movement(problem.situation.arm, time, path), int(caught))
    plan, verdict = judged(problem, attempt, found)
    return plan, verdict.reason


@njit(_nrt=False)
def lay(study: Study, joints: np.ndarray, times: np.ndarray, waits: bool, way: Way) -> bool:
    """Write the way through joints (m, dof), wanted at times (m,), as soon as limits allow.

    If time is left, the limb waits before the move, or moves more slowly without `waits`.
    Returns whether it comes before the horizon.
    """
    limits, now = study.scene.limits, 0.0
    write(way, 0, study.scene.limb.start, 0.0, 0.0)
    for k in range(times.size):
        took, _ = time_of(study, way.joints[k], joints[k])
        now = max(now + took, times[k])
        if waits and k > 0:
            way.left[k] = now - took
        write(way, k + 1, joints[k], now, now)
    return now < limits.horizon


@njit(_nrt=False)
def end(study: Study, way: Way, body: int, wanted: float, later: float) -> bool:
    """Let a way end on a body, by a straight move from its last posture; whether there is one.

    Parameters
    ----------
    wanted : float
        When the body is expected at the last posture [s].
    later : float
        From one moment that is tried to the next [s].
    """
    last, horizon = way.size[0] - 1, study.scene.limits.horizon
    q, since, goal = way.joints[last], way.reached[last], study.goal
    for k in range(1, ENDINGS + 1):
        t = min(max(since, wanted) + k * later, horizon)
        if met_from(study, q, since, body, q, t) > 0:
            begin, arrive = reach(study, q, since, t, goal, t)
            if begin >= 0.0:
                way.left[last], way.body[0] = begin, body
                write(way, last + 1, goal, arrive, t)
                return True
        if t >= horizon:
            break
    return False
