"""Planners from outside of the package: their plans are verified before they count."""

from __future__ import annotations

import sys
import time as clock
from collections.abc import Callable
from contextlib import redirect_stdout
from copy import deepcopy
from dataclasses import fields
from typing import TYPE_CHECKING, Any

import numpy as np

from gcm_learn.arms import PLANAR, ByKind, Kind, kind_of
from gcm_learn.errors import UnknownNameError
from gcm_learn.maps import CognitiveMap
from gcm_learn.motion import (
    Ask,
    Carry,
    Movement,
    rests_at_end,
    rules_of,
    start_clearance,
    verify,
    why_blocked,
)
from gcm_learn.planners.plan import Catch, Plan, takes
from gcm_learn.planners.references import in_words, place_in
from gcm_learn.processes import OutOfTime, time_limit
from gcm_learn.scene import pack
from gcm_learn.situation import AnySituation

if TYPE_CHECKING:
    from gcm_learn.planners.plan import Plan


GOING_ON = ("gcm-learn/situation@4",)
"""Formats in which a movement may go on after its catch."""
PLACE_SLACK = 1e-9  # of times [s]
JOINT_SLACK = 1e-6  # of joints that follow from hands [rad]


def broken_promise(situation: AnySituation, plan: Plan) -> str | None:
    """Return the first promise of a caught plan that does not hold.

    Parameters
    ----------
    situation : Situation
    plan : Plan
        Of this situation.

    Returns
    -------
    str or None
        None when all promises hold, or nothing was promised.
    """
    return judged_anew(situation, plan)[0]


def judged_anew(situation: AnySituation, plan: Plan) -> tuple[str | None, float | None]:
    """Return the first promise of a caught plan that does not hold, and the plan's clearance."""
    if plan.status != "caught":
        return None, None
    moves = plan.trajectory
    if moves is None or plan.catch_time is None or plan.catch_body is None:
        return "a catch without a trajectory, a time or a body", None
    if kind_of(moves.arm) != kind_of(situation):
        return "moves an arm of the other kind", None
    if moves.arm != situation.arm:
        return "moves another arm", None
    if plan.catch_body not in [target.name for target in situation.targets]:
        return f"catches {plan.catch_body!r}, which is no target", None
    fault = _missing(situation, plan)
    if fault is not None:
        return fault, None
    goes_on = situation.format in GOING_ON
    if not goes_on and not abs(moves.duration - plan.catch_time) <= PLACE_SLACK:
        return "does not end at the catch", None
    parts = (moves.time, moves.hand, moves.joints, moves.rates)
    if not all(np.isfinite(part).all() for part in parts if part is not None):
        return "has numbers that are not finite", None
    if goes_on:
        return _all_held(situation, moves, plan)
    for one in plan.on_the_way:
        fault = _missed_on_the_way(situation, moves, one.body, one.time)
        if fault is not None:
            return fault, None
    return verified_anew(situation, moves, plan.catch_body)


def _missing(situation: AnySituation, plan: Plan) -> str | None:
    """Return the fault in a plan's list of caught targets, or in its order, if there is a fault."""
    bodies, wanted = [body.name for body in situation.bodies], len(situation.targets)
    names, times = zip(*((one["body"], one["time"]) for one in plan.catches), strict=True)
    if situation.catch == "any" and len(names) > 1:
        return f"catches {len(names)} targets, and one is wanted"
    if situation.catch == "all" and len(names) < wanted:
        return f"catches {len(names)} of {wanted} targets, and all have to be caught"
    if len(set(names)) < len(names):
        return "catches a target twice"
    strangers = set(names) - {target.name for target in situation.targets}
    if strangers:
        return f"catches {min(strangers)!r}, which is no target"
    order = [(time, bodies.index(name)) for name, time in zip(names, times, strict=True)]
    return None if order == sorted(order) else "lists its catches in another order than in time"


def _missed_on_the_way(
    situation: AnySituation, moves: Movement, name: str, time: float
) -> str | None:
    """Return the fault of a catch on the way, which must be at a sample; None if it holds."""
    if not np.abs(moves.time - time).min() <= PLACE_SLACK:
        return f"catches {name!r} at {time:g} s, which is no sample"
    fault, _ = verified_anew(situation, moves.until(time), name)
    return None if fault is None else f"{name!r}: {fault}"


def _all_held(
    situation: AnySituation, moves: Movement, plan: Plan
) -> tuple[str | None, float | None]:
    """Return the fault, if any, and clearance of a movement that goes on after its catches."""
    bodies, asked, full, last = [body.name for body in situation.bodies], [], -np.inf, 0.0
    carries: list[tuple[Carry, float]] = []
    # at one instant, a catch without a hold comes first
    for one in sorted(plan.catches, key=lambda one: (one["time"], one.get("held_until", 0.0))):
        number = bodies.index(one["body"])
        name, hold, time = one["body"], situation.bodies[number].hold, one["time"]
        until, seconds = one.get("held_until"), 0.0 if hold is None else hold.seconds
        if (until is None) != (hold is None):
            return f"{name!r}: held_until is given exactly for targets with a hold", None
        until = time if until is None else until
        if not abs(until - time - seconds) <= PLACE_SLACK:
            return f"{name!r}: is held for {until - time:g} s (must be {seconds:g})", None
        for when in (time, until):
            if not np.abs(moves.time - when).min() <= PLACE_SLACK:
                return f"{name!r}: there is no sample at {when:g} s", None
        if time < full:
            return f"{name!r}: is caught at {time:g} s, while the hand is full", None
        full, place = until if seconds > 0.0 else full, situation.bodies[number].place
        if (one.get("placed") is None) != (place is None):
            return f"{name!r}: placed is given exactly for targets with a place", None
        if place is not None:
            full = one["placed"]
            carries.append((Carry(situation, number, moves, until), full))  # type: ignore[arg-type]
        asked.append((number, time, until))
        last = max(last, until, full)
    if situation.end == "free" and not abs(moves.duration - last) <= PLACE_SLACK:
        return "goes on after its last catch", None
    found, clearance = verified_anew(
        situation, moves, str(plan.catch_body), Ask.of(situation, asked)
    )
    for carry, placed in carries if found is None else ():
        fault = _carried_anew(carry, placed)
        if isinstance(fault, str):
            return fault, None
        clearance = min(clearance or np.inf, fault)
    return found, clearance


def _carried_anew(carry: Carry, placed: float) -> str | float:
    """Return the fault of a carry as text, or the carry's clearance."""
    moves, name = carry.moves, carry.target.name
    k = int(np.abs(moves.time - placed).argmin())
    if not abs(moves.time[k] - placed) <= PLACE_SLACK or placed <= carry.held:
        return f"{name!r}: there is no sample at {placed:g} s, when it is placed"
    ask = Ask.of(carry.situation, ())
    until = moves.until(placed)
    if not rests_at_end(pack(carry.situation).limits, ask.jerk, until):
        return f"{name!r}: is placed while the arm moves"
    failure, clearance, when = carry.fault(placed)
    return clearance if failure is None else f"{name!r}: {failure.with_numbers(when=when)}"


def verified_anew(
    situation: AnySituation, moves: Movement, target: str, ask: Ask | None = None
) -> tuple[str | None, float | None]:
    """Return the fault, if any, and the clearance of a movement to a target.

    For demands on the movement's end, `ask`, see `verify`.
    """
    scene = pack(situation, max(situation.horizon, moves.duration))
    body = [body.name for body in situation.bodies].index(target)
    rules = rules_of(scene)._replace(touch=scene.limb.thickness)  # planners keep a little more
    verdict = verify(scene, rules, moves, body, ask)
    if verdict.reason is not None:
        return str(verdict.reason), None
    if moves.path is not None and not _agree(moves, moves.path):
        return "has joints that do not lead the hand along its path", None
    return None, verdict.clearance


def _agree(moves: Movement, path: np.ndarray) -> bool:
    """Return whether the joints of a planar arm lead the hand along `path`, up to whole turns."""
    off = moves.joints - Movement.of_hand(moves.arm, moves.time, path).joints
    turns = 2.0 * np.pi * np.round(off[0] / (2.0 * np.pi))
    return bool((np.abs(off - turns) <= JOINT_SLACK).all())


LIMIT = 60.0
"""Time on the wall for a plan, by default [s]."""
MOST_SAMPLES = 100_000  # of a movement
MOST_NODES = 2**53  # exact in JSON
TOUCHES = 1e-6  # within this of contact a start may be called blocked [lengths]
GIVEN = ("time", "joints", "rates", "path")
UNSAID = "no reason was given"
"""Message of plans without a catch and without a message: exchange formats want a sentence."""
_BY_HAND = ByKind({PLANAR: True}, default=False)
"""True for kinds of arms whose movements have a path of the hand."""


class _Broken(Exception):
    """Error of a plan that breaks a promise; the message says how."""


class Outside:
    """Planner from outside of the package; each of its answers is verified once.

    It plans for a copy of the situation, for a limited time. A planner that fails answers with the
    status "error", one that promises too much with "broken"; both have a message.

    Parameters
    ----------
    planner : object or callable
        With `plan(situation)`, or a function of a situation.
    name : str
        Planner of its plans.
    limit : float, optional
        Time on the wall for a plan [s], see `processes.time_limit`.
    """

    def __init__(self, planner: Any, name: str, limit: float | None = LIMIT) -> None:
        self.planner, self.name, self.limit = planner, name, limit
        self._plan: Callable[..., Any] = getattr(planner, "plan", None) or planner

    @property
    def anytime(self) -> bool:
        """True if the planner takes a deadline; see `Anytime`."""
        return getattr(self.planner, "anytime", False) is True

    def takes(self, kind: Kind) -> bool:
        """Return whether the planner takes arms of a kind; by default planar arms only."""
        try:
            return takes(self.planner, kind)
        except Exception as error:
            reason = f"its function takes fails ({in_words(error)})"
            raise UnknownNameError(f"planner {self.name!r}: {reason}") from error

    def plan(self, situation: AnySituation, **given: Any) -> Plan:
        """Answer a situation; `given` may have a deadline if the planner takes deadlines."""
        since, shown, form = clock.perf_counter(), deepcopy(situation), situation.format
        status, message, answer = "error", "", None
        try:
            with np.errstate(), time_limit(self.limit), redirect_stdout(sys.stderr):
                answer = self._plan(shown, **given)
        except OutOfTime:
            message = f"no answer within {self.limit:g} s"
        except (Exception, SystemExit) as error:
            message = in_words(error) + place_in(error, __file__)
        spent = 1e3 * (clock.perf_counter() - since)
        if not message:
            try:
                if shown != situation:
                    raise ValueError("it changed the situation")
                values = _values(answer, situation)
                return Plan(**values, planner=self.name, planning_ms=spent, format=form)
            except _Broken as error:
                status, message = "broken", f"the planner breaks its promise: {error}"
            except Exception as error:
                message = in_words(error)
        if status == "error":
            message = f"the planner fails: {message}"
        known: Any = status
        return Plan(situation.name, self.name, known, message, spent, format=form)


def _values(answer: Any, situation: AnySituation) -> dict[str, Any]:
    """Verify an answer; return the values of its plan, except planner and planning time.

    Each value is read once. Only numbers and text of the answer are kept.
    """
    if not isinstance(answer, Plan):
        raise TypeError(f"it returned {_kind_of_thing(answer)} in place of a Plan")
    told = {field.name: getattr(answer, field.name) for field in fields(Plan)}
    if told["name"] != situation.name:
        raise _Broken(f"answers situation {told['name']!r}")
    common: dict[str, Any] = {
        "name": situation.name,
        "message": " ".join(str(told["message"]).split()),
    }
    nodes = told["nodes"]
    common["nodes"] = nodes if type(nodes) is int and 0 <= nodes <= MOST_NODES else 0
    common["map"] = told["map"] if isinstance(told["map"], CognitiveMap) else None
    if told["status"] == "caught":
        return common | _catch(told, situation)
    status, why = told["status"], common["message"] or UNSAID
    return common | _no_catch(status, why, situation)


def _no_catch(status: Any, why: str, situation: AnySituation) -> dict[str, Any]:
    """Return status and message of a plan without a catch."""
    if type(status) is not str or status not in ("unreachable", "start_blocked"):
        raise ValueError(f"its plan has the status {status!r}")
    scene = pack(situation)
    free = start_clearance(scene)
    if status == "start_blocked" and free > TOUCHES:
        raise _Broken("says that the start is blocked, which it is not")
    if free <= 0.0:
        status, why = "start_blocked", str(why_blocked(situation, scene))
    return {"status": status, "message": why}


def _catch(told: dict[str, Any], situation: AnySituation) -> dict[str, Any]:
    """Return the values of a catch that holds."""
    try:
        moves = _movement(told["trajectory"], situation)
        values: dict[str, Any] = {
            "status": "caught",
            "catch_time": _number(told["catch_time"], "catch_time"),
            "catch_body": told["catch_body"] if type(told["catch_body"]) is str else None,
            "held_until": _maybe("held_until", told["held_until"]),
            "placed": _maybe("placed", told["placed"]),
            "on_the_way": tuple(
                Catch(
                    str(name),
                    _number(time, "on_the_way"),
                    *(_maybe("on_the_way", given) for given in rest[:2]),
                )
                for name, time, *rest in told["on_the_way"]
            ),
            "trajectory": moves,
        }
        claimed = Plan(name="", planner="", message="", planning_ms=0.0, **values)
        reason, clearance = judged_anew(situation, claimed)
    except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
        raise _Broken(in_words(error)) from error
    if reason is not None:
        raise _Broken(reason)
    return values | {"clearance": clearance}


def _maybe(name: str, given: Any) -> float | None:
    """Return a time [s] of a field, or None."""
    return None if given is None else _number(given, name)


def _movement(given: Any, situation: AnySituation) -> Movement:
    """Return a new movement, with checked copies of the numbers of a movement from outside."""
    if not isinstance(given, Movement):
        raise _Broken(f"its trajectory is {_kind_of_thing(given)} in place of a Movement")
    if given.arm != situation.arm:
        raise _Broken("moves another arm")
    parts = {name: _array(getattr(given, name), name) for name in GIVEN}
    if _BY_HAND.of(situation) != (parts["path"] is not None):
        raise _Broken(f"needs {'a' if parts['path'] is None else 'no'} path of the hand")
    return Movement(situation.arm, **parts)  # type: ignore[arg-type]


def _array(given: Any, name: str) -> np.ndarray | None:
    """Return a copy of real, finite numbers; None stays."""
    if given is None:
        return None
    values = np.asarray(given)
    if values.dtype.kind not in "fiu":
        raise _Broken(f"{name} has values of type {values.dtype}")
    if not 0 < len(values) <= MOST_SAMPLES:
        raise _Broken(f"{name} has {len(values)} samples")
    copied = np.array(values, dtype=np.float64, order="C")
    if not np.isfinite(copied).all():
        raise _Broken("has numbers that are not finite")
    return copied


def _number(given: Any, name: str) -> float:
    if isinstance(given, bool) or not isinstance(given, (int, float, np.number)):
        raise _Broken(f"{name} is {_kind_of_thing(given)}")
    return float(given)


def _kind_of_thing(given: Any) -> str:
    return "None" if given is None else f"a {type(given).__name__}"
