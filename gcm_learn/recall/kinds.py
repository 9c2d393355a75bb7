"""The table of memories by kind of arm: waypoints, features, adaptation."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from gcm_learn import planners
from gcm_learn.arms import CHAIN, PLANAR, SPATIAL, ByKind, Kind, kind_of
from gcm_learn.errors import ArmKindError, RecallError
from gcm_learn.maps import CognitiveMap
from gcm_learn.recall import adaptation, hand_features, hand_paths, joint_features, joint_moves
from gcm_learn.recall.features import Features, Sizes, hand_path_features, joint_path_features
from gcm_learn.recall.map_features import (
    coarse_map,
    joint_map_features,
    planar_map,
    planar_map_features,
)
from gcm_learn.recall.raw_features import chain_raw_features, hand_raw_features, joint_raw_features
from gcm_learn.recall.waypoints import GOAL, Waypoints, hand_waypoints, joint_waypoints
from gcm_learn.situation import AnySituation


@dataclass(frozen=True)
class MemoryKind:
    """Formats and functions for memories of one kind of arm."""

    format: str
    """Format of a memory's folder."""
    knots: tuple[int, int]
    """Shape of a path's knots; no columns where they differ from arm to arm."""
    columns: Callable[[Any], int]
    """Numbers of a knot, for an arm."""
    goal: int
    """Numbers of a goal."""
    waypoints_of: Callable[..., Waypoints]
    """A situation's movement to a body, as memory keeps it."""
    raw_features: Callable[..., np.ndarray]
    """Raw parameters of a situation, with its scene if that is at hand."""
    features: Callable[..., Features]
    """Clearance features of a situation, with its scene if that is at hand."""
    path_features: Callable[[np.ndarray, np.ndarray], np.ndarray]
    """Features of memories' knots and goals."""
    in_joints: bool
    """True if movements are in joints, not in hands."""
    map_of: Callable[[Any], CognitiveMap]
    """Map of a situation that encoders embed where none is stored."""
    map_features: Callable[[CognitiveMap], np.ndarray]
    """Features of a map of a canonical situation."""
    problem: Callable[..., Any]
    """Maker of the problem of a situation, for a planner's name."""
    straight: Callable[[Any], planners.Plan]
    """Plan of a problem straight to the earliest interception."""
    early_answer: Callable[[Any], planners.Plan | None]
    """Answer to a problem without a memory, None if it takes one."""
    tries: Callable[[Any, adaptation.Adaptation], adaptation.Tries]
    """Memories tried on a problem."""
    pool: int
    """Memories recalled for each check: failures put similar ones back."""
    penalty: float
    """Loss of a memory by the failure of one in the same direction [log-odds]."""
    lesson: Sizes
    """Sizes of the batches of labels that an encoder learns from."""
    shipped: str
    """Name of the memory that is shipped."""


def _joints_and_times(arm: Any) -> int:
    return len(arm.joints) + 2


_CHAIN = MemoryKind(
    format="gcm-learn/memory@3",
    knots=(joint_moves.KNOTS, 0),
    columns=_joints_and_times,
    goal=GOAL,
    waypoints_of=joint_waypoints,
    raw_features=chain_raw_features,
    features=joint_features.posture_features,
    path_features=joint_path_features,
    in_joints=True,
    map_of=coarse_map,
    map_features=joint_map_features,
    problem=planners.JointProblem,
    straight=adaptation.straight_in_joints,
    early_answer=adaptation.early_answer_in_space,
    tries=adaptation.tries_in_joints,
    pool=4,
    penalty=1.0,
    lesson=Sizes(192, 40, 20, 6),  # a try costs tens of times as much
    shipped="recall-panda",
)
MEMORIES = ByKind(
    {
        PLANAR: MemoryKind(
            format="gcm-learn/memory@1",
            knots=(hand_paths.KNOTS, 4),
            columns=lambda arm: 4,
            goal=2,
            waypoints_of=hand_waypoints,
            raw_features=hand_raw_features,
            features=hand_features.clearance_features,
            path_features=hand_path_features,
            in_joints=False,
            map_of=planar_map,
            map_features=planar_map_features,
            problem=planners.Problem,
            straight=planners.straight_plan,
            early_answer=planners.Problem.early_answer,
            tries=adaptation.HandTries,
            pool=10,
            penalty=4.0,
            lesson=Sizes(),
            shipped="recall",
        ),
        SPATIAL: replace(
            _CHAIN,
            format="gcm-learn/memory@2",
            knots=(joint_moves.KNOTS, 6),
            raw_features=joint_raw_features,
            lesson=Sizes(),
            shipped="recall-space",
        ),
        CHAIN: _CHAIN,
    },
    who="memory",
)
FORMATS = {MEMORIES.of(kind).format: kind for kind in MEMORIES}


def same_kind(kind: Kind, situation: AnySituation, columns: int = 0) -> None:
    """Refuse a situation with another kind of arm, or with another number of joints.

    Parameters
    ----------
    kind : Kind
        Of the arms that a memory holds catches of.
    situation : Situation
    columns : int
        Numbers of a knot in the memory, 0 while it is empty.
    """
    found = kind_of(situation)
    if found != kind:
        raise ArmKindError(
            f"memory: holds catches of {kind.plural}, "
            f"asked with a {found.name} one ({situation.name!r})"
        )
    own = MEMORIES.of(kind).columns(situation.arm)
    if columns not in (0, own):
        raise ArmKindError(
            f"memory: holds catches of {columns - 2} joints, this arm has {own - 2}; "
            "`gcm-learn memory make` makes one of its own for --memory"
        )


def waypoints_of(situation: AnySituation, plan: planners.Plan) -> Waypoints:
    """Return the catch of a plan as waypoints, the form that memories store.

    Parameters
    ----------
    situation : Situation
        In any frame; waypoints of a situation and of its canonical form are the same.
    plan : Plan
        A catch in it.
    """
    if plan.trajectory is None or plan.catch_body is None:
        raise ValueError(f"plan: {plan.status}, only catches can be remembered")
    body = [body.name for body in situation.bodies].index(plan.catch_body)
    time = plan.catch_time or 0.0
    goes_on = plan.held_until is not None or plan.trajectory.duration > time
    held = ((time, plan.held_until or time),) if goes_on else ()
    return MEMORIES.of(situation).waypoints_of(situation, plan.trajectory, body, *held)


def raw_features(situation: AnySituation, scene: Any = None) -> np.ndarray:
    """Return the raw parameters (m,) float32 of a situation in any frame."""
    return MEMORIES.of(situation).raw_features(situation, scene)


def kind_of_format(place: object, format: object) -> Kind:
    """Return the kind of arm of a memory's folder; raise RecallError for anything else."""
    kind = FORMATS.get(str(format))
    if kind is None:
        raise RecallError(f"{place}: format is {format!r}, expected {' or '.join(FORMATS)}")
    return kind
