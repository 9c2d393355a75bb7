"""A stop after a catch: movements that end at rest, verified like the movements before."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np

from gcm_learn.arms import PLANAR, ByKind, forward
from gcm_learn.errors import SituationError, StopError
from gcm_learn.motion.movement import REST, Movement
from gcm_learn.motion.rules import rules_of
from gcm_learn.motion.verification import verify
from gcm_learn.scene import pack
from gcm_learn.situation import AnySituation, Body, Disc, PlanarQuadratic, SolidQuadratic, Sphere

SPANS = (0.2, 0.1, 0.3, 0.05)
"""Times of braking that are tried where accelerations have no limits [s]."""
STRETCHES = (1.0, 1.5, 2.5)
"""Times of braking that are tried under limits of acceleration, in the shortest possible."""
SPARE = 1.0 + 1e-6
"""Share of the shortest time by which braking is longer, against rounding."""
SHORTEST = 0.01
"""Of joints that are near the end of their range [s]."""
ROOM = 0.99
"""Share of the way to the end of a range that braking may use."""
INSTANT = 1e-6
"""Times of braking are whole multiples [s]."""
PIECES = 24
"""Of a stop that is linear between samples."""
_NO_ROOM = 1e-7  # at the end of its range a joint stops within this [rad]
_AT_ONCE = 1e-9  # what stops sooner rests, and what stops this much apart stops together [s]
NAME = "(place of the stop)"
"""Name of the target of verification."""


def with_stop(situation: AnySituation, trajectory: Movement) -> Movement:
    """Append braking to a movement, so that it ends at rest.

    All joints slow down evenly and rest at the same time; the hand of a planar arm brakes on its
    straight way, or with its joints. The whole movement is verified: limits, and no touch of an
    obstacle until the arm rests. Bodies may come near it later.

    A stop jerks, so an arm with limits of jerk gets none; `situation.with_end` asks for a plan that
    ends at rest. Without limits of acceleration the arm brakes in the first of `SPANS` in which it
    can, joints near the end of their range sooner. Give the arm limits for a stop that a robot can
    make.

    Parameters
    ----------
    situation : Situation
        Situation of the movement.
    trajectory : Movement
        Catch in this situation.

    Returns
    -------
    Movement
        The same movement, if it rests at its end.

    Raises
    ------
    StopError
        If no way to brake is free.
    """
    rates = _last_rates(situation, trajectory)
    if np.abs(rates).max(initial=0.0) <= REST:
        return trajectory
    if getattr(situation.arm, "max_joint_jerk", None) is not None:
        raise StopError(f"{situation.name!r}: limits of jerk need a plan that ends at rest")
    reason = "no way to brake"
    for made in _candidates(situation, trajectory, rates):
        fault = _fault(situation, made)
        if fault is None:
            return made
        reason = fault
    message = "the movement ends in motion, and no verified stop was found"
    raise StopError(f"{situation.name!r}: {message} ({reason})")


def _last_rates(situation: AnySituation, moves: Movement) -> np.ndarray:
    """Rates (dof,) of the joints at the end of a movement [rad/s]."""
    if moves.rates is not None:
        return moves.rates[-1]
    spans = np.diff(moves.time)
    lasting = np.flatnonzero(spans > 0.0)
    if not len(lasting):
        start = getattr(situation.arm, "joint_rates", None)
        return np.zeros(moves.joints.shape[1]) if start is None else np.array(start)
    rates: np.ndarray = np.diff(moves.joints, axis=0)[lasting[-1]] / spans[lasting[-1]]
    return rates


def _candidates(situation: AnySituation, moves: Movement, rates: np.ndarray) -> Iterator[Movement]:
    """Ways to brake, the preferred first."""
    limits = getattr(situation.arm, "max_joint_acceleration", None)
    if limits is not None:
        least = SPARE * np.abs(rates) / np.array(limits)
        for stretch in STRETCHES:
            yield _braked(moves, rates, np.full_like(least, stretch * least.max()))
        yield _braked(moves, rates, least)
        return
    for span in SPANS:
        yield from _UNLIMITED.of(situation)(situation, moves, rates, span)


def _with_hand(
    situation: AnySituation, moves: Movement, rates: np.ndarray, span: float
) -> Iterator[Movement]:
    """Ways of a planar arm to brake in a time."""
    yield _straight_on(moves, span)
    yield _hand_with_joints(moves, rates, span)


def _with_joints(
    situation: AnySituation, moves: Movement, rates: np.ndarray, span: float
) -> Iterator[Movement]:
    """Yield movements that brake within `span`, for an arm that moves in its joints."""
    yield _braked(moves, rates, np.full_like(rates, span))
    yield _braked(moves, rates, _spans_in_range(situation.arm, moves, rates, span))


_UNLIMITED = ByKind({PLANAR: _with_hand}, default=_with_joints)
"""Ways to brake without limits of acceleration."""


def _spans_in_range(arm: Any, moves: Movement, rates: np.ndarray, span: float) -> np.ndarray:
    """Times of braking (dof,) that keep joints within their ranges, `span` at most [s]."""
    low, high = np.array(arm.joint_range).T
    room = np.where(rates > 0.0, high - moves.joints[-1], moves.joints[-1] - low)
    speed = np.maximum(np.abs(rates), REST)
    return np.clip(2.0 * ROOM * room / speed, SHORTEST, span)


def _braked(moves: Movement, rates: np.ndarray, spans: np.ndarray) -> Movement:
    """Slow each joint down evenly, within its own time `spans` (dof,) [s].

    The cubic curves of a movement with rates hold this exactly; others get many samples.
    """
    spans = INSTANT * np.ceil(spans / INSTANT)
    times = spans if moves.rates is not None else np.append(spans, _even(spans.max()))
    after = INSTANT * np.unique(np.rint(times[times > 0.0] / INSTANT))
    during = np.minimum(after[:, None], spans)
    share = np.divide(during, spans, out=np.ones_like(during), where=spans > 0.0)
    joints = moves.joints[-1] + rates * during * (1.0 - 0.5 * share)
    slowed = None if moves.rates is None else np.vstack([moves.rates, rates * (1.0 - share)])
    return replace(
        moves,
        time=np.append(moves.time, moves.duration + after),
        joints=np.vstack([moves.joints, joints]),
        rates=slowed,
    )


def _even(span: float) -> np.ndarray:
    """Return evenly spaced times (m,) of a stop, with its end [s]."""
    return span * np.arange(1, PIECES + 1) / PIECES


def _slowing(moves: Movement, span: float) -> tuple[np.ndarray, np.ndarray]:
    """Return times (m,) of a stop after a movement, and the way by then per initial speed [s]."""
    after = _even(span)
    return moves.duration + after, after - 0.5 * after**2 / span


def _straight_on(moves: Movement, span: float) -> Movement:
    """Slow the hand of a planar arm down on the straight line of its last segment."""
    spans = np.diff(moves.time)
    last = np.flatnonzero(spans > 0.0)[-1]
    velocity = np.diff(moves.hand, axis=0)[last] / spans[last]
    time, share = _slowing(moves, span)
    return _on_path(moves, time, moves.hand[-1] + share[:, None] * velocity)


def _hand_with_joints(moves: Movement, rates: np.ndarray, span: float) -> Movement:
    """Let both joints of a planar arm slow down evenly."""
    time, share = _slowing(moves, span)
    joints = moves.joints[-1] + share[:, None] * rates
    return _on_path(moves, time, forward(joints, moves.arm.upper_arm))


def _on_path(moves: Movement, time: np.ndarray, hand: np.ndarray) -> Movement:
    return Movement.of_hand(
        moves.arm, np.append(moves.time, time), np.concatenate([moves.hand, hand])
    )


def _fault(situation: AnySituation, moves: Movement) -> str | None:
    """Return the reason that speaks against a movement with a stop, or None.

    Verification asks for a target at the end, so one rests there instead of the caught one.
    """
    goal = _goal(situation, moves.hand[-1])
    horizon = max(situation.horizon, moves.duration)
    try:
        changed = replace(situation, bodies=(goal, *situation.obstacles), horizon=horizon)
    except SituationError as error:
        return f"the world is unknown after its horizon: {error}"
    scene = pack(changed)
    rules = rules_of(scene)._replace(touch=scene.limb.thickness)
    reason = verify(scene, rules, moves, 0).reason
    return None if reason is None else str(reason)


def _goal(situation: AnySituation, hand: np.ndarray) -> Body:
    """Return a target that rests at a hand (2 or 3)."""
    size = max(situation.arm.grasp, 1e-3)
    if hand.size == 2 and situation.plane is None:
        return Body("target", NAME, Disc(size), PlanarQuadratic(tuple(hand), *2 * ((0.0, 0.0),)))
    if situation.plane is not None:
        plane = situation.plane
        hand = np.array(plane.origin) + np.array([plane.x, plane.y]).T @ hand
    return Body("target", NAME, Sphere(size), SolidQuadratic(tuple(hand), *2 * ((0.0,) * 3,)))


def braked(plan: Movement, limits: np.ndarray) -> Movement:
    """Extend a movement until each joint rests, as soon as its limit of acceleration allows.

    A joint that would leave its range loses the rest of its speed at the end: it brakes harder than
    the limits.  A movement that is linear between samples knows no accelerations, and stops at its
    end.

    Parameters
    ----------
    plan : Movement
    limits : (dof,) ndarray
        Of the accelerations [rad/s^2].
    """
    if plan.rates is None:
        return plan
    rates, (low, high) = plan.rates[-1], np.array(plan.arm.joint_range).T
    room = np.where(rates > 0.0, high - plan.joints[-1], plan.joints[-1] - low)
    most = np.maximum(limits, rates**2 / (2.0 * np.maximum(room, _NO_ROOM)))
    stops = np.abs(rates) / most
    time = np.sort(stops[stops > _AT_ONCE])
    time = time[np.append(np.diff(time) > _AT_ONCE, True)] if time.size else time
    passed = np.minimum(time[:, None], stops)
    force = -np.sign(rates) * most
    return replace(
        plan,
        time=np.append(plan.time, plan.duration + time),
        joints=np.vstack([plan.joints, plan.joints[-1] + passed * (rates + 0.5 * force * passed)]),
        rates=np.vstack([plan.rates, rates + force * passed]),
    )
