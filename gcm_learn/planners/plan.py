"""What a planner answers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Generic, Literal, Protocol

import numpy as np

from gcm_learn.arms import SpatialArm
from gcm_learn.maps import CognitiveMap
from gcm_learn.motion import Failure, SpatialTrajectory, Trajectory
from gcm_learn.planners.deadline import Deadline
from gcm_learn.situation import AnySituation, Situation, planar

if TYPE_CHECKING:
    from typing_extensions import TypeVar  # a default makes a plain `Plan` one of the plane

    Movement = TypeVar(
        "Movement", bound=Trajectory | SpatialTrajectory, default=Trajectory, covariant=True
    )
else:
    from typing import TypeVar

    Movement = TypeVar("Movement")

FORMAT = "gcm-learn/solution@1"
SPATIAL_FORMAT = "gcm-learn/solution@2"
Status = Literal["caught", "unreachable", "start_blocked"]


@dataclass(frozen=True)
class Plan(Generic[Movement]):
    """A verified catch, or why there is none; `Plan[SpatialTrajectory]` of a spatial arm."""

    name: str
    """Name of the situation."""
    planner: str
    status: Status
    """"caught" is a promise: the trajectory has been verified."""
    message: str
    """Why, in one sentence."""
    planning_ms: float
    """Wall time of planning [ms]."""
    catch_time: float | None = None
    """[s]"""
    catch_body: str | None = None
    """Name of the target that is caught."""
    clearance: float | None = None
    """Smallest distance of limb and obstacles, less the thickness [forearm lengths, or the unit of
    a spatial arm]; infinite without obstacles."""
    trajectory: Movement | None = None
    failure: Failure | None = None
    """Why there is no catch, to be counted; `message` has its sentence."""
    map: CognitiveMap | None = None
    """The map that the plan came from; plans that needed none leave it out."""
    nodes: int = 0
    """How many labels, in space moves, a search over a lattice has looked at."""

    @property
    def caught(self) -> bool:
        """Whether there is a verified catch."""
        return self.status == "caught"


AnyPlan = Plan[Trajectory] | Plan[SpatialTrajectory]


class Planner(Protocol):
    """Anything that plans; one that also plans for spatial arms says ``takes_space = True``."""

    @property
    def name(self) -> str:
        """Name under which it is registered."""

    def plan(self, situation: Situation) -> Plan:
        """Answer a situation."""


class Anytime(Protocol):
    """A planner that can be told by when it must answer; it says ``anytime = True``.

    It answers with the best verified catch that it has by then, and goes on looking for an earlier
    one until then. It is late by what it takes to finish and verify a movement: some milliseconds.
    """

    @property
    def name(self) -> str:
        """Name under which it is registered."""

    def plan(
        self,
        situation: Any,
        bound: float | None = None,
        deadline: float | Deadline | None = None,
    ) -> Plan[Any]:
        """Answer a situation.

        Parameters
        ----------
        situation : Situation
        bound : float, optional
            Only catches until then count [s].
        deadline : float or Deadline, optional
            How long it may think, in seconds of processor time; without one it answers with its
            first catch.
        """


def taken(planner: Planner, situation: AnySituation) -> AnySituation:
    """The situation, if the planner takes its arm.

    Raises
    ------
    ArmKindError
    """
    if getattr(planner, "takes_space", False):
        return situation
    return planar(situation, f"planner {planner.name!r}")


def plan_to_json(plan: AnyPlan, situation: AnySituation | None = None) -> dict[str, Any]:
    """The plan in the exchange format ``gcm-learn/solution@1``, or ``@2`` of a spatial arm.

    Fields that make sense only for a catch are null otherwise; so is the clearance of a catch in a
    world without obstacles, where it has no value.

    Parameters
    ----------
    plan : Plan
    situation : Situation, optional
        What it answers; without it a plan that has no trajectory counts as one of the plane.
    """
    clearance, moves = plan.clearance, plan.trajectory
    spatial = isinstance(moves, SpatialTrajectory)
    if situation is not None:
        spatial = isinstance(situation.arm, SpatialArm)
    out: dict[str, Any] = {
        "format": SPATIAL_FORMAT if spatial else FORMAT,
        "name": plan.name,
        "planner": plan.planner,
        "status": plan.status,
        "catch_time": plan.catch_time,
        "catch_body": plan.catch_body,
        "clearance": None if clearance is None or clearance > 1e200 else clearance,
        "planning_ms": round(plan.planning_ms, 3),
        "message": plan.message,
    }
    if moves is not None:
        out["trajectory"] = _columns(moves)
    return out


def _columns(moves: Trajectory | SpatialTrajectory) -> dict[str, list[Any]]:
    columns: dict[str, np.ndarray | None] = {"time": moves.time}
    if isinstance(moves, SpatialTrajectory):
        columns |= {
            "joints": moves.joints,
            "hand": moves.hand,
            "elbow": moves.elbow,
            "rates": moves.rates,
        }
    else:
        columns |= {"hand": moves.hand, "joints": moves.joints}
    return {name: column.tolist() for name, column in columns.items() if column is not None}
