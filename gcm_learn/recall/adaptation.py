"""Adaptation: a remembered catch moved to a new situation, and whether it is then valid.

Retrieved paths are repaired rather than replayed in Lightning and Thunder (Berenson, Abbeel and
Goldberg, ICRA 2012; Coleman, Sucan, Moll, Okada and Correll, ICRA 2015). Here a path gets new ends
without search, as dynamic movement primitives do, because that has to cost less than planning anew;
what it breaks is found by the verification that every plan goes through.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from gcm_learn.motion import SPACING, first_interception, refine, spread
from gcm_learn.planners import Attempt, Problem, attempt_of
from gcm_learn.recall import kernels, trials
from gcm_learn.recall.kernels import Query, Style
from gcm_learn.recall.trials import Budget, Offer
from gcm_learn.recall.waypoints import Waypoints, ring_share
from gcm_learn.situation import Situation

INSTANTS = 129  # at which paths are looked at before their check
STYLES = {"polar": kernels.POLAR, "cartesian": kernels.CARTESIAN}
TEMPOS = {"hurry": kernels.HURRY, "keep": kernels.KEEP}


@dataclass(frozen=True)
class Adaptation:
    """How memories are adapted."""

    style: Literal["polar", "cartesian"] = "polar"
    """Coordinates in which the differences of the ends are spread along the path."""
    tempo: Literal["hurry", "keep", "both"] = "hurry"
    """Whether only waits are kept ("hurry"), or all of the memory's times; or one after the
    other."""
    bends: int = 5
    """Changes at most, one upon the other, of a path that looks as if it touched: it is pushed
    aside, or held back. Only what comes out of them is checked. In space there are three at
    most. Under limits of acceleration a path that touches is tried with other times, and pushed
    aside if it touches at all of them; 0 keeps the first time that the limits allow."""

    @cached_property
    def styles(self) -> np.ndarray:
        """Columns (s, 2) of the `Style`s in which each memory is tried, in order."""
        tempos = ("hurry", "keep") if self.tempo == "both" else (self.tempo,)
        return np.array([[STYLES[self.style], TEMPOS[tempo]] for tempo in tempos])


DEFAULT = Adaptation()


def query_of(problem: Problem) -> Query:
    """What adaptations must know of a situation; once for all memories."""
    scene, rules, arm = problem.scene, problem.rules, problem.situation.arm
    x, y = arm.hand
    horizon = problem.situation.horizon
    soonest, _, _, _ = first_interception(scene, rules, x, y, 0.0, 0.0, horizon)
    return Query(
        scene=scene,
        rules=rules,
        table=np.full((INSTANTS, len(scene.bodies.rows), 12), np.nan),
        angle=float(np.arctan2(y, x)),
        ring=float(ring_share(arm, np.hypot(x, y))),
        soonest=max(float(soonest), 0.0),
    )


def adapt(
    problem: Problem,
    waypoints: Waypoints,
    how: Adaptation = DEFAULT,
    query: Query | None = None,
) -> Attempt | None:
    """Adapt one memory to a situation, in the first of its styles that meets a target in time.

    Parameters
    ----------
    problem : Problem
    waypoints : Waypoints
    how : Adaptation
    query : Query, optional
        Of the problem, if the caller has it at hand.

    Returns
    -------
    Attempt or None
        Not verified.
    """
    query = query_of(problem) if query is None else query
    work = kernels.workspace_for(query)
    knots, goals = waypoints.knots[None], waypoints.goal[None]
    for style in how.styles:
        count, _, body = trials.adapted(knots, goals, 0, query, Style(*style), work, how.bends)
        if count:
            return attempt_at(problem, work.best_time[:count], work.best_hand[:count], body)
    return None


def attempt_at(problem: Problem, time: np.ndarray, hand: np.ndarray, body: int) -> Attempt:
    """An adapted path (m,), (m, 2) as an attempt, with samples near enough for joints, too."""
    arm = problem.situation.arm
    time, hand = refine(arm, *spread(time, hand, SPACING))
    return attempt_of(problem, time, hand, int(body))


class Tries:
    """Memories tried on a situation of the plane.

    Parameters
    ----------
    problem : Problem
    how : Adaptation
    """

    def __init__(self, problem: Problem, how: Adaptation) -> None:
        self.problem, self.how = problem, how

    @cached_property
    def query(self) -> Query:
        """What adaptations must know of the situation."""
        return query_of(self.problem)

    def first_valid(
        self, paths: tuple[np.ndarray, np.ndarray], offer: Offer, budget: Budget
    ) -> tuple[int, int, Attempt | None]:
        """The first of the offered memories that is valid.

        Parameters
        ----------
        paths : (ndarray, ndarray)
            Knots and goals of all memories.
        offer : Offer
        budget : Budget

        Returns
        -------
        place : int
            In the offer, -1 if none is.
        checked : int
            Paths that were checked.
        attempt : Attempt or None
            Which the verification has still to confirm.
        """
        k, body, tried, time, hand = trials.first_valid(
            *paths, offer, self.query, self.how.styles, budget
        )
        return k, tried, attempt_at(self.problem, time, hand, body) if k >= 0 else None

    def catch_times(self, knots: np.ndarray, goals: np.ndarray, chosen: np.ndarray) -> np.ndarray:
        """When memories catch in it, see `transfer`."""
        out: np.ndarray = trials.catch_times(
            knots, goals, chosen, self.query, self.how.styles, self.how.bends
        )
        return out


def transfer(
    situation: Situation | Problem,
    knots: np.ndarray,
    goals: np.ndarray,
    chosen: np.ndarray | None = None,
    how: Adaptation = DEFAULT,
) -> np.ndarray:
    """When memories, adapted to a situation, catch in it: labels for learning.

    Parameters
    ----------
    situation : Situation or Problem
        In any frame. The limb must be free at t = 0, or none is valid.
    knots, goals : (n, KNOTS, 4), (n, 2) ndarray of float32
        Memories, as of `Waypoints`.
    chosen : (m,) ndarray of int, optional
        Which of them; all by default.

    Returns
    -------
    (m,) ndarray
        Catch time [s], negative for memories that do not catch.
    """
    problem = situation if isinstance(situation, Problem) else Problem(situation, "transfer")
    rows = np.arange(len(knots)) if chosen is None else chosen
    rows = np.ascontiguousarray(rows, dtype=np.int64)
    return Tries(problem, how).catch_times(knots, goals, rows)
