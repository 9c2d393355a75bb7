"""Adaptation: a remembered catch bent to a new situation, and whether it then holds.

Retrieved paths are repaired rather than replayed in Lightning and Thunder (Berenson, Abbeel and
Goldberg, ICRA 2012; Coleman, Sucan, Moll, Okada and Correll, ICRA 2015). Here the repair is a bend
without search, as of dynamic movement primitives that get new ends, because it has to cost less
than planning anew; what it breaks is found by the verification that every plan goes through.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from gcm_learn.motion.interception import first_interception
from gcm_learn.motion.timing import SPACING, refine, spread
from gcm_learn.planners.completion import Attempt, Problem, attempt_of
from gcm_learn.recall import kernels, trials
from gcm_learn.recall.kernels import Query
from gcm_learn.recall.waypoints import Trace, ring_share
from gcm_learn.situation import Situation

INSTANTS = 33  # at which the limb is looked at before the exact check
STYLES = {"polar": kernels.POLAR, "cartesian": kernels.CARTESIAN}
TEMPOS = {"hurry": kernels.HURRY, "keep": kernels.KEEP}


@dataclass(frozen=True)
class Adaptation:
    """How memories are bent."""

    style: Literal["polar", "cartesian"] = "polar"
    """Coordinates in which the differences of the ends are spread along the path."""
    tempo: Literal["hurry", "keep", "both"] = "hurry"
    """Whether only waits are kept ("hurry"), or all of the memory's times; or one after the
    other."""
    mends: int = 1
    """How often a path that touches is pushed aside, which makes it another path to check."""

    @cached_property
    def ways(self) -> np.ndarray:
        """Codes (s, 2) of the styles and tempos in which each memory is tried, in order."""
        tempos = ("hurry", "keep") if self.tempo == "both" else (self.tempo,)
        return np.array([[STYLES[self.style], TEMPOS[tempo]] for tempo in tempos])


DEFAULT = Adaptation()


def query_of(problem: Problem) -> Query:
    """What adaptations must know of a situation; once for all memories."""
    scene, rules, horizon = problem.scene, problem.rules, problem.situation.horizon
    x, y = problem.situation.arm.hand
    soonest, _, _, _ = first_interception(scene, rules, x, y, 0.0, 0.0, horizon)
    return Query(
        scene=scene,
        rules=rules,
        table=kernels.pose_table(scene.bodies, horizon, INSTANTS),
        angle=float(np.arctan2(y, x)),
        ring=float(ring_share(problem.situation.arm, np.hypot(x, y))),
        soonest=max(float(soonest), 0.0),
    )


def adapt(problem: Problem, trace: Trace, how: Adaptation = DEFAULT) -> Attempt | None:
    """Bend one memory to a situation, in the first of its styles that meets a target in time.

    Returns
    -------
    Attempt or None
        Not verified.
    """
    query = query_of(problem)
    desk = kernels.desk_for(query)
    for style, tempo in how.ways:
        count, body = kernels.adapt(
            trace.knots[None], trace.goal[None], 0, query, style, tempo, desk
        )
        if count:
            return attempt_at(problem, desk.best_time[:count], desk.best_hand[:count], body)
    return None


def attempt_at(problem: Problem, time: np.ndarray, hand: np.ndarray, body: int) -> Attempt:
    """A bent path (m,), (m, 2) as an attempt, with samples near enough for joints, too."""
    arm = problem.situation.arm
    time, hand = refine(arm, *spread(time, hand, SPACING))
    return attempt_of(problem, time, hand, int(body))


def transfer(
    situation: Situation,
    traces: np.ndarray,
    goals: np.ndarray,
    chosen: np.ndarray | None = None,
    how: Adaptation = DEFAULT,
) -> np.ndarray:
    """When memories, bent to a situation, catch in it: labels for learning.

    Parameters
    ----------
    situation : Situation
        In any frame. The limb must be free at t = 0, or none holds.
    traces, goals : (n, KNOTS, 4), (n, 2) ndarray of float32
        Memories, as of `Trace`.
    chosen : (m,) ndarray of int, optional
        Which of them; all by default.

    Returns
    -------
    (m,) ndarray
        Catch time [s], negative for memories that do not catch.
    """
    query = query_of(Problem(situation, "transfer"))
    rows = np.arange(len(traces)) if chosen is None else np.asarray(chosen, dtype=np.int64)
    out = np.full(len(rows), -1.0)
    for style, tempo in how.ways:
        left = np.flatnonzero(out < 0.0)
        out[left] = trials.transfer(traces, goals, rows[left], query, style, tempo, how.mends)
    return out
