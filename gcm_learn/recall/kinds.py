"""What recall must know of a kind of arm: of the plane, or of space."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from gcm_learn.errors import ArmKindError, RecallError
from gcm_learn.planners import (
    AnyPlan,
    Attempt,
    Problem,
    SpatialProblem,
    earliest_straight,
    straight_plan,
)
from gcm_learn.recall import kernels
from gcm_learn.recall.adaptation import Adaptation, Tries
from gcm_learn.recall.clearance_features import CELLS, CONTEXT, Features, clearance_features
from gcm_learn.recall.memory_features import path_features
from gcm_learn.recall.raw_features import raw_features
from gcm_learn.recall.space import features
from gcm_learn.recall.space import kernels as space_kernels
from gcm_learn.recall.space.adaptation import TriesInSpace, early_answer_in_space
from gcm_learn.recall.space.features import features_in_space
from gcm_learn.recall.space.path_features import path_features_in_space
from gcm_learn.recall.space.raw_features import raw_features_in_space
from gcm_learn.recall.space.waypoints import GOAL, SpatialWaypoints, waypoints_in_space
from gcm_learn.recall.trials import Budget, Offer
from gcm_learn.recall.waypoints import Waypoints, waypoints_in_plane
from gcm_learn.situation import AnySituation

AnyWaypoints = Waypoints | SpatialWaypoints


class Trier(Protocol):
    """Memories tried on a situation."""

    def first_valid(
        self, paths: tuple[np.ndarray, np.ndarray], offer: Offer, budget: Budget
    ) -> tuple[int, int, Attempt[Any] | None]:
        """See `recall.adaptation.Tries`."""

    def catch_times(self, knots: np.ndarray, goals: np.ndarray, chosen: np.ndarray) -> np.ndarray:
        """See `recall.adaptation.transfer`."""


@dataclass(frozen=True)
class Kind:
    """Memories for one kind of arm."""

    name: str
    """As families have it."""
    format: str
    """Of a memory's folder."""
    knots: tuple[int, int]
    """Shape of a movement's knots."""
    goal: int
    """Numbers of its goal."""
    waypoints: type[Any]
    """Made of knots and goal."""
    waypoints_of: Callable[..., AnyWaypoints]
    """The catch of a plan in a situation, as memory keeps it."""
    raw_features: Callable[..., np.ndarray]
    """Of a situation, and its scene if that is at hand."""
    problem: Callable[[Any, str], Any]
    """A situation on its way to a plan, by whom."""
    look: Callable[..., Features]
    """What a situation looks like, whose scene is given if it is at hand."""
    context: int
    """Numbers of a look's context."""
    cells: int
    """Numbers of an obstacle."""
    path_features: Callable[[np.ndarray, np.ndarray], np.ndarray]
    """Of memories' knots and goals."""
    straight: Callable[[Any], AnyPlan]
    """A straight way to the earliest interception, of a problem."""
    early_answer: Callable[[Any], AnyPlan | None]
    """What can be said of a problem without a memory."""
    tries: Callable[[Any, Adaptation], Trier]
    """Of a problem."""
    pool: int
    """Memories recalled for each that is checked: failures send those like them back."""
    penalty: float
    """What a memory loses by the failure of one in the same direction [log-odds]."""


PLANE = Kind(
    name="planar",
    format="gcm-learn/memory@1",
    knots=(kernels.KNOTS, 4),
    goal=2,
    waypoints=Waypoints,
    waypoints_of=waypoints_in_plane,
    raw_features=raw_features,
    look=clearance_features,
    context=CONTEXT,
    cells=CELLS,
    path_features=path_features,
    straight=straight_plan,
    problem=Problem,
    early_answer=Problem.early_answer,
    tries=Tries,
    pool=10,
    penalty=4.0,
)
SPACE = Kind(
    name="spatial",
    format="gcm-learn/memory@2",
    knots=(space_kernels.KNOTS, space_kernels.COLUMNS),
    goal=GOAL,
    waypoints=SpatialWaypoints,
    waypoints_of=waypoints_in_space,
    raw_features=raw_features_in_space,
    look=features_in_space,
    context=features.CONTEXT,
    cells=features.CELLS,
    path_features=path_features_in_space,
    straight=earliest_straight,
    problem=SpatialProblem,
    early_answer=early_answer_in_space,
    tries=TriesInSpace,
    pool=4,
    penalty=1.0,
)
FORMATS = {kind.format: kind for kind in (PLANE, SPACE)}
BY_NAME = {kind.name: kind for kind in (PLANE, SPACE)}


def kind_of(situation: AnySituation) -> Kind:
    """That of a situation's arm."""
    return SPACE if situation.is_spatial else PLANE


def same_kind(kind: Kind, situation: AnySituation) -> None:
    """Refuse a situation of the other kind of arm."""
    if kind_of(situation) != kind:
        raise ArmKindError(
            f"memory: holds catches of {kind.name} arms, "
            f"asked with a {kind_of(situation).name} one ({situation.name!r})"
        )


def waypoints_of(situation: AnySituation, plan: AnyPlan) -> AnyWaypoints:
    """The catch of a plan as memory keeps it, of either kind of arm.

    Parameters
    ----------
    situation : Situation
        In any frame; those of a situation and of its canonical form are the same.
    plan : Plan
        A catch in it.
    """
    return kind_of(situation).waypoints_of(situation, plan)


def raw_numbers(situation: AnySituation, scene: Any = None) -> np.ndarray:
    """Raw parameters of a situation, of either kind of arm."""
    return kind_of(situation).raw_features(situation, scene)


def kind_of_format(place: object, format: object) -> Kind:
    """The kind of a memory's folder; raises RecallError for anything else."""
    kind = FORMATS.get(str(format))
    if kind is None:
        raise RecallError(f"{place}: format is {format!r}, expected {' or '.join(FORMATS)}")
    return kind
