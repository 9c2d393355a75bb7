"""What a planner answers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, Protocol

from gcm_learn.maps import CognitiveMap
from gcm_learn.motion import Failure, Trajectory
from gcm_learn.situation import Situation

FORMAT = "gcm-learn/solution@1"
Status = Literal["caught", "unreachable", "start_blocked"]


@dataclass(frozen=True)
class Plan:
    """A verified catch, or why there is none."""

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
    """Smallest distance of limb and obstacles, less the thickness [forearm lengths]; infinite
    without obstacles."""
    trajectory: Trajectory | None = None
    failure: Failure | None = None
    """Why there is no catch, to be counted; `message` has its sentence."""
    map: CognitiveMap | None = None
    """The map that the plan came from; planners without maps leave it out."""

    @property
    def caught(self) -> bool:
        """Whether there is a verified catch."""
        return self.status == "caught"


class Planner(Protocol):
    """Anything that plans."""

    @property
    def name(self) -> str:
        """Name under which it is registered."""

    def plan(self, situation: Situation) -> Plan:
        """Answer a situation."""


def plan_to_json(plan: Plan) -> dict[str, Any]:
    """The plan in the exchange format ``gcm-learn/solution@1``.

    Fields that make sense only for a catch are null otherwise; so is the clearance of a catch in a
    world without obstacles, where it has no value.
    """
    clearance = plan.clearance
    out: dict[str, Any] = {
        "format": FORMAT,
        "name": plan.name,
        "planner": plan.planner,
        "status": plan.status,
        "catch_time": plan.catch_time,
        "catch_body": plan.catch_body,
        "clearance": None if clearance is None or clearance > 1e200 else clearance,
        "planning_ms": round(plan.planning_ms, 3),
        "message": plan.message,
    }
    if plan.trajectory is not None:
        out["trajectory"] = {
            "time": plan.trajectory.time.tolist(),
            "hand": plan.trajectory.hand.tolist(),
            "joints": plan.trajectory.joints.tolist(),
        }
    return out
