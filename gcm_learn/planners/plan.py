"""Plans, and the protocols of planners."""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, Protocol

from gcm_learn.arms import PLANAR, Kind, kind_of, solution_format
from gcm_learn.errors import ArmKindError
from gcm_learn.maps import CognitiveMap
from gcm_learn.motion import Failure, Movement
from gcm_learn.situation import AnySituation, Situation

GAIN = 0.01
"""Share of the horizon by which a catch must be earlier to be looked for."""


class Deadline:
    """A time by which an answer is wanted, counted from now.

    By default it is processor time, as thinking is charged everywhere here. On an idle core that is
    the time on the wall. On a busy one, the work of others is not counted. Searches read it about
    once in a millisecond.

    Parameters
    ----------
    seconds : float
        From 0 on; 0 asks for what can be said at once.
    clock : callable
        Tells the time [s], e.g. `time.perf_counter` for that on the wall.
    """

    def __init__(self, seconds: float, clock: Callable[[], float] = time.process_time) -> None:
        if not seconds >= 0.0:
            raise ValueError(f"deadline: must be from 0 on (got {seconds!r})")
        self._clock, self._end = clock, clock() + seconds

    @property
    def over(self) -> bool:
        """True after the deadline."""
        return self._clock() >= self._end

    def part(self, share: float) -> Deadline:
        """Return a deadline after a share (0 to 1) of the time that is left."""
        return Deadline(max(share * (self._end - self._clock()), 0.0), self._clock)


def deadline_of(given: float | Deadline | None) -> Deadline | None:
    """Convert seconds to a deadline; return a deadline or None unchanged."""
    return Deadline(given) if isinstance(given, (int, float)) else given


Status = Literal["caught", "unreachable", "start_blocked", "broken", "error"]
FAULTS = ("broken", "error")
"""Statuses of planners from outside only: a catch that fails verification, and no answer at all."""


class Catch(NamedTuple):
    """A target that is caught."""

    body: str
    """Its name."""
    time: float
    """[s]"""
    held_until: float | None = None
    """End of its hold, where there is one [s]."""
    placed: float | None = None
    """When it is placed, where it has a place [s]."""


@dataclass(frozen=True)
class Plan:
    """A verified catch, or the reason for its absence."""

    name: str
    """Name of the situation."""
    planner: str
    status: Status
    """"caught" is a promise: the trajectory has been verified. For "broken" and "error" see
    `FAULTS`."""
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
    """Reason for a missing catch, to be counted; `message` has its sentence."""
    map: CognitiveMap | None = None
    """The map that the plan came from; plans that needed none leave it out."""
    on_the_way: tuple[Catch, ...] = ()
    """Targets that are caught before `catch_body`, in order."""
    held_until: float | None = None
    """End of the last hold, where there is one [s]."""
    placed: float | None = None
    """When the last target is placed, where it has a place [s]."""
    nodes: int = 0
    """Labels that a search over cells has expanded, or nodes that were added to trees."""
    format: str = ""
    """Format of the situation; one made by hand may do without."""

    @property
    def caught(self) -> bool:
        """True if there is a verified catch."""
        return self.status == "caught"

    @property
    def exchanged(self) -> str:
        """Status in exchange formats, where faults of planners are "unreachable"."""
        return "unreachable" if self.status in FAULTS else self.status

    @property
    def catches(self) -> list[dict[str, Any]]:
        """Targets that are caught, in order of time: `body`, `time`, `held_until`, `placed` [s]."""
        if self.catch_body is None:
            return []
        last = Catch(self.catch_body, self.catch_time or 0.0, self.held_until, self.placed)
        told = [one._asdict() for one in (*self.on_the_way, last)]
        return [{k: v for k, v in one.items() if v is not None} for one in told]


class Planner(Protocol):
    """Protocol of planners; a planner of arms that are not planar has a method, see `takes`.

    A planner that keeps no limits of acceleration has a false attribute `accelerates`.
    """

    @property
    def name(self) -> str:
        """Name under which the planner is registered."""

    def plan(self, situation: Situation) -> Plan:
        """Answer a situation."""


class Anytime(Protocol):
    """A planner that takes a deadline; its attribute `anytime` is True.

    It answers with the best verified catch that it has by then, and goes on looking for an earlier
    one until then. It is late by what it takes to finish and verify a movement: some milliseconds.
    """

    @property
    def name(self) -> str:
        """Name under which the planner is registered."""

    def plan(
        self, situation: Any, bound: float | None = None, deadline: float | Deadline | None = None
    ) -> Plan:
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


def end_of(situation: AnySituation, bound: float | None) -> float:
    """Return the time until which catches count [s]: a bound or the horizon.

    Raises
    ------
    ValueError
        If the bound is not positive.
    """
    if bound is not None and not bound > 0.0:
        raise ValueError(f"bound: must be positive (got {bound:g})")
    return situation.horizon if bound is None else min(situation.horizon, bound)


def in_plane(kind: Kind) -> bool:
    """Return whether arms of a kind are planar; the default of planners without `takes`."""
    return kind == PLANAR


def in_joints(kind: Kind) -> bool:
    """Return whether arms of a kind move in their joints."""
    return kind != PLANAR


def any_arm(kind: Kind) -> bool:
    """Return True: for planners that take every kind of arm."""
    return True


def takes(planner: Planner, kind: Kind) -> bool:
    """Return whether a planner takes arms of a kind, by its function `takes` if it has one."""
    return bool(getattr(planner, "takes", in_plane)(kind))


def keeps_limits(planner: Planner, situation: AnySituation) -> bool:
    """Return whether a planner keeps the limits of acceleration that an arm has, if any."""
    if getattr(situation.arm, "max_joint_acceleration", None) is None:
        return True
    for_arm = getattr(planner, "for_arm", None)  # of `ByArm`
    return bool(getattr(planner if for_arm is None else for_arm(situation), "accelerates", True))


def taken(planner: Planner, situation: AnySituation) -> AnySituation:
    """Return the situation, if the planner takes its arm.

    Raises
    ------
    ArmKindError
    """
    if takes(planner, kind_of(situation)):
        return situation
    raise refused(planner.name, situation)


def refused(name: str, situation: AnySituation) -> ArmKindError:
    """Return the error of a planner that does not take a situation's arm."""
    where = f" (situation {json.dumps(situation.name)})"
    return ArmKindError(f"planner {declined(name, kind_of(situation), where)}")


INSTEAD = {"gcm": "marching", "layered": "search"}
"""Planners for arms that move in their joints, by the planner of the plane that is like them."""


def declined(name: str, kind: Kind, where: str = "") -> str:
    """Return the message of a planner that declines arms of a kind, with another planner to use."""
    other = f"; {INSTEAD[name]!r} does" if name in INSTEAD and in_joints(kind) else ""
    return f"{name!r} does not take {kind.plural}{where}{other}"


COLUMNS = {
    "gcm-learn/solution@1": ("time", "hand", "joints"),
    "gcm-learn/solution@2": ("time", "joints", "hand", "elbow", "rates"),
    "gcm-learn/solution@3": ("time", "joints", "hand", "rates"),
    "gcm-learn/solution@4": ("time", "joints", "hand", "rates"),
}
"""Columns of a trajectory, in the order of each format."""
LISTED = ("gcm-learn/solution@3", "gcm-learn/solution@4")
"""Formats that list all catches."""


def plan_to_json(plan: Plan, situation: AnySituation | None = None) -> dict[str, Any]:
    """Return the plan in the exchange format that belongs to the format of its situation.

    Fields that make sense only for a catch are null otherwise; so is the clearance of a catch in a
    world without obstacles, where it has no value.

    Parameters
    ----------
    plan : Plan
    situation : Situation, optional
        Answered by the plan; by default the format in the plan counts, which must be known then.
    """
    clearance, moves = plan.clearance, plan.trajectory
    asked = plan.format if situation is None else situation.format
    if not asked:
        raise ValueError("situation: is needed (the plan does not tell its format)")
    version = solution_format(asked)
    out: dict[str, Any] = {"format": version, "name": plan.name, "planner": plan.planner}
    out["status"] = plan.exchanged
    if version in LISTED:
        out["catches"] = plan.catches
    out |= {
        "catch_time": plan.catch_time,
        "catch_body": plan.catch_body,
        "clearance": None if clearance is None or clearance > 1e200 else clearance,
        "planning_ms": round(plan.planning_ms, 3),
        "message": plan.message,
    }
    if moves is not None:
        columns = {name: getattr(moves, name, None) for name in COLUMNS[version]}
        out["trajectory"] = {k: v.tolist() for k, v in columns.items() if v is not None}
    return out
