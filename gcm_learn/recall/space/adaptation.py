"""Adaptation in space: a remembered movement of the joints, moved to a new situation."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from gcm_learn.arms import JOINTS
from gcm_learn.motion import SpatialTrajectory
from gcm_learn.planners import Attempt, Plan, SpatialProblem, at_once, study_of
from gcm_learn.recall.adaptation import TEMPOS, Adaptation
from gcm_learn.recall.space import accelerated, trials
from gcm_learn.recall.space.kernels import Query, work_room
from gcm_learn.recall.trials import Budget, Offer
from gcm_learn.situation import spatial_frame_of

BENDS = 3  # changes at most of a movement that touches, however many are allowed


class TriesInSpace:
    """Memories tried on a situation of a spatial arm, see `recall.adaptation.Tries`.

    Only one tempo is tried; under limits of acceleration several times of the end.
    """

    def __init__(self, problem: SpatialProblem, how: Adaptation) -> None:
        self.problem, self.how = problem, how

    @cached_property
    def query(self) -> Query:
        """What adaptations must know of the situation."""
        frame = spatial_frame_of(self.problem.situation)
        study = study_of(self.problem.scene, self.problem.rules)
        return Query(study, frame.canonical_joints(np.ones(JOINTS)))

    @property
    def _tempo(self) -> int:
        return TEMPOS["keep" if self.how.tempo == "keep" else "hurry"]

    @property
    def _bends(self) -> int:
        return min(self.how.bends, BENDS)

    def first_valid(
        self, paths: tuple[np.ndarray, np.ndarray], offer: Offer, budget: Budget
    ) -> tuple[int, int, Attempt[SpatialTrajectory] | None]:
        """The first of the offered memories that is valid; see `recall.adaptation.Tries`."""
        if self.problem.accelerates:
            return self._first_accelerated(paths[0], offer, budget)
        budget = budget._replace(changes=self._bends)
        k, body, tried, time, joints = trials.first_valid(
            paths[0], offer, self.query, self._tempo, budget, work_room()
        )
        if k < 0:
            return -1, tried, None
        path = SpatialTrajectory(self.problem.situation.arm, time, joints)
        return k, tried, Attempt(path, int(body))

    def _first_accelerated(
        self, knots: np.ndarray, offer: Offer, budget: Budget
    ) -> tuple[int, int, Attempt[SpatialTrajectory] | None]:
        """The same, where accelerations are limited."""
        track = accelerated.new_track()
        k, body, tried = accelerated.first_valid(
            knots, offer, self.query, budget, work_room(), track
        )
        if k < 0:
            return -1, tried, None
        path = SpatialTrajectory(self.problem.situation.arm, track.time, track.joints, track.rates)
        return k, tried, Attempt(path, int(body))

    def catch_times(self, knots: np.ndarray, goals: np.ndarray, chosen: np.ndarray) -> np.ndarray:
        """When memories catch in it, see `recall.adaptation.transfer`."""
        if self.problem.accelerates:
            track = accelerated.new_track()
            return accelerated.catch_times(
                knots, chosen, self.query, self._bends, work_room(), track
            )
        out: np.ndarray = trials.catch_times(
            knots, chosen, self.query, self._tempo, self._bends, work_room()
        )
        return out


def early_answer_in_space(problem: SpatialProblem) -> Plan[SpatialTrajectory] | None:
    """What can be said without a memory: hopeless, blocked, or caught at t = 0."""
    return problem.early_answer(keeps_acceleration=True) or at_once(problem)
