"""Long horizons in stages, each of a length that planners are made for."""

from __future__ import annotations

import math
import time as clock
from dataclasses import replace
from typing import Any, cast

import numpy as np

from gcm_learn.arms import PLANAR, SPATIAL, ByKind, kind_of
from gcm_learn.motion import Movement
from gcm_learn.planners.outside import GIVEN, verified_anew
from gcm_learn.planners.plan import Deadline, Plan, deadline_of, end_of
from gcm_learn.scene import later
from gcm_learn.situation import AnySituation, Body, Pendulum, arm_frame

ORDINARY: ByKind[float] = ByKind({PLANAR: 1.5, SPATIAL: 4.0}, default=3.0)
"""Horizons up to which planners look at a situation as a whole [crossings of the arm]."""
SHARES = tuple(2.0 ** (-0.5 * k) for k in range(6))
"""Lengths of short stages [ordinary horizons]; long ones double."""
STARTS = (0.0, 0.25, 0.5, 1.0, 2.0)  # of later stages, after the target comes [ordinary horizons]
SPANS = 6  # in which a target is within reach that have stages of their own
CALM = 4.0  # a world at rest is looked at so long [ordinary horizons]
LEAST = 2.0**-20  # length of a stage, for arms that hardly can move [horizons]
LOSS = 1e-12  # of digits where a body comes from afar


class Staged:
    """Planner of ordinary horizons that plans longer horizons in stages; the first catch counts.

    A stage begins shortly before a target may come within reach, with an arm that has rested until
    then.  An ordinary horizon is one stage.
    """

    def __init__(self, planner: Any) -> None:
        self.planner = planner

    def __getattr__(self, name: str) -> Any:
        """Return an attribute of the wrapped planner."""
        if name.startswith("__"):
            raise AttributeError(name)
        return getattr(self.planner, name)

    def plan(
        self, situation: Any, bound: float | None = None, deadline: float | Deadline | None = None
    ) -> Plan:
        """Answer a situation; a bound and a deadline are for planners that take them."""
        since, limit = clock.perf_counter(), deadline_of(deadline)
        given: dict[str, Any] = {} if limit is None else {"deadline": limit}
        todo = stages(situation, end_of(situation, bound))
        if todo == [(0.0, end_of(situation, bound))]:
            given |= {} if bound is None else {"bound": bound}
            return cast(Plan, self.planner.plan(situation, **given))
        for k, (start, end) in enumerate(todo):
            if limit is not None:  # else the first stage would take it all
                given["deadline"] = limit.part(1.0 / (len(todo) - k))
            stage = replace(situation, horizon=end)
            plan = self.planner.plan(later(stage, start) if start else stage, **given)
            blocked = plan.status == "start_blocked" and not start
            if start and plan.caught:
                plan = _after_rest(stage, plan, start)
            if plan.caught or blocked or (limit is not None and limit.over):
                break
        return cast(Plan, replace(plan, planning_ms=1e3 * (clock.perf_counter() - since)))


def stages(situation: Any, horizon: float) -> list[tuple[float, float]]:
    """Return first and last instants of the stages up to a horizon [s]."""
    ordinary = max(ORDINARY.of(situation) * crossing(situation.arm), LEAST * horizon)
    if horizon <= ordinary:
        return [(0.0, horizon)]
    moving, calm = any(getattr(situation.arm, "joint_rates", None) or ()), quiet_from(situation)
    found: list[tuple[float, float]] = []
    spans = [span for span in spans_within_reach(situation, ordinary) if span[0] <= horizon]
    for enter, leave in spans[:SPANS]:
        start, length = 0.0 if moving else max(enter - ordinary, 0.0), ordinary
        leave = min(leave, horizon, max(calm, enter) + CALM * ordinary)
        found.append((start, min(enter + length, leave)))
        found += [(start, min(enter + share * ordinary, horizon)) for share in SHARES]
        while enter + length < leave:
            length *= 2.0
            found.append((start, min(enter + length, leave)))
        if start > 0.0:  # planners that never wait may start too early
            since = [enter + share * ordinary for share in STARTS]
            found += [(t, min(t + ordinary, leave)) for t in since if t < leave]
    if not spans or found[-1][0] > 0.0:
        found.append((0.0, min(horizon, spans[-1][1] if spans else ordinary)))
    return [stage for stage in dict.fromkeys(found) if stage[0] < stage[1]] or [(0.0, horizon)]


def _after_rest(situation: Any, plan: Plan, start: float) -> Plan:
    """Return a plan that begins after a rest; without a catch if the rest is not free."""
    moves: Any = plan.trajectory
    given = {name: getattr(moves, name) for name in GIVEN} | {"time": moves.time + start}
    parts: Any = {k: v if v is None else np.concatenate([v[:1], v]) for k, v in given.items()}
    parts["time"][0] = 0.0
    whole = Movement(situation.arm, **parts)
    fault, clearance = verified_anew(situation, whole, str(plan.catch_body))
    if fault is not None:
        return Plan(plan.name, plan.planner, "unreachable", fault, 0.0)
    end, told = whole.duration, f"caught {plan.catch_body!r} at {whole.duration:.3f} s"
    caught: Any = {"catch_time": end, "clearance": clearance, "trajectory": whole}
    return replace(plan, message=told, map=None, **caught)


def crossing(arm: Any) -> float:
    """Return the longest time in which an arm crosses its reach, or a joint its range [s]."""
    longest = 2.0 * arm.reach / (getattr(arm, "max_hand_speed", None) or math.inf)
    if kind_of(arm) is PLANAR:
        return longest
    forces = arm.max_joint_acceleration or (math.inf,) * len(arm.joints)
    joints = zip(arm.joint_range, arm.max_joint_speed, forces, strict=True)
    return max(longest, *((b - a) / speed + speed / force for (a, b), speed, force in joints))


def spans_within_reach(situation: AnySituation, apart: float) -> list[tuple[float, float]]:
    """Return spans [s], in order, outside of which surely no target is within reach.

    Spans that are nearer to each other than `apart` [s] are one.
    """
    joined: list[tuple[float, float]] = []
    found = (_spans(situation, body, situation.arm.reach) for body in situation.targets)
    for since, until in sorted((since, until) for spans in found for since, until, _ in spans):
        if joined and since - joined[-1][1] < apart:
            since, until = joined[-1][0], max(until, joined.pop()[1])
        joined.append((since, until))
    return joined


def quiet_from(situation: AnySituation) -> float:
    """Return the time after which nothing moves near the arm; infinite without such a time [s]."""
    found = (_spans(situation, body, 2.0 * situation.arm.reach) for body in situation.bodies)
    return max((until for spans in found for _, until, moves in spans if moves), default=0.0)


def _spans(situation: Any, body: Body, reach: float) -> list[tuple[float, float, bool]]:
    """Return the spans [s] of a body in a box about the arm, and whether the body moves in each."""
    motion: Any = body.motion
    turn, origin = arm_frame(situation)
    size = body.shape.bounding_radius + situation.arm.grasp
    room = np.full(3, reach + size)
    if isinstance(motion, Pendulum):
        near = math.dist(motion.pivot, origin) - motion.hang_distance <= reach + size
        return [(0.0, math.inf, True)] if near else []
    if situation.plane is not None:
        room[2] = size
    pieces = getattr(motion, "arrays", None)
    laws = pieces[1:4] if pieces else (motion.position, motion.velocity, motion.acceleration)
    p, v, a = (np.atleast_2d(np.asarray(law, dtype=float)) for law in laws)
    if p.shape[1] == 3:
        p, v, a = (p - origin) @ turn.T, v @ turn.T, a @ turn.T
    starts = pieces[0] if pieces else np.zeros(1)
    since, until = _inside(p, v, a, room[: p.shape[1]], np.append(np.diff(starts), math.inf))
    spins = np.atleast_2d(pieces[5] if pieces else motion.spin).any(axis=-1)
    columns: Any = starts + since, starts + until, v.any(axis=1) | a.any(axis=1) | spins
    there = since <= until
    return list(zip(*(column[there].tolist() for column in columns), strict=True))


def _inside(p: Any, v: Any, a: Any, room: Any, span: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return first and last times (m,) of laws p, v, a (m, dim) in a box (dim,) within spans (m,).

    The first is above the last, or neither is a number, where a law is never there.
    """
    ends = np.broadcast_to(span[:, None], p.shape)
    times = [np.zeros_like(p), ends]
    with np.errstate(all="ignore"):
        for side in (-room, room):  # squares of tiny speeds are 0
            root = np.where(a == 0.0, np.abs(v), np.sqrt(v * v - 2.0 * a * (p - side)))
            larger = -v - np.copysign(root, v)
            times += [larger / a, 2.0 * (p - side) / larger]
        t: Any = np.stack(times)
        far = np.abs(p) + t * (np.abs(v) + np.abs(a) * t)
        there = np.array(np.abs(p + t * (v + 0.5 * a * t)) <= room * (1.0 + 1e-9) + LOSS * far)
        there[1] = np.where(np.isinf(ends), (v == 0.0) & (a == 0.0) & there[0], there[1])
        there &= (t >= 0.0) & (t <= ends)
        speed, along = (v * v).sum(axis=1), (p * v).sum(axis=1)
        outside = (p * p).sum(axis=1) - room.max() ** 2
        half = np.sqrt((1.0 + LOSS) * along * along - speed * outside)  # straight through the ball
        straight = (speed > 0.0) & ~a.any(axis=1)
        enter, leave = (np.where(straight, (side * half - along) / speed, 0.0) for side in (-1, 1))
    first = np.where(there, t, math.inf).min(axis=0).max(axis=1)
    last = np.where(there, t, -math.inf).max(axis=0).min(axis=1)
    return np.maximum(first, enter), np.where(straight, np.minimum(last, leave), last)
