"""Arms in joints that are led along trajectories, and their events at every instant.

Trajectories are on the world's clock here: the first sample is the beginning.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, NamedTuple, TypeVar

import numpy as np

from gcm_learn.arms import Chain
from gcm_learn.arms.curves import hermite, line, part
from gcm_learn.collision.postures import desk_of, least_on
from gcm_learn.compiled import njit
from gcm_learn.execution.arena.kernels.world import CAUGHT, COLLIDED, RUNNING
from gcm_learn.motion import Movement, braked, rules_of
from gcm_learn.motion.joint_interception import first_meeting
from gcm_learn.planners import Plan
from gcm_learn.scene import Scene

_NARROWEST = 1e-6  # how exactly the moment of a collision is found [shares of a move]
_ANY = 1e300  # resolution of distances: collision is exact whatever it is


class JointEvents:
    """Catches and collisions in a scene.

    Parameters
    ----------
    scene : Scene
    """

    def __init__(self, scene: Scene) -> None:
        self._scene, self._shortest = scene, rules_of(scene).instant
        self._desk = desk_of(scene)

    def first(self, trajectory: Movement, since: float, until: float) -> tuple[int, float, int]:
        """Return outcome, time [s] and target of the first event between two times, or RUNNING."""
        inner = trajectory.time[(trajectory.time > since) & (trajectory.time < until)]
        for end in (*inner.tolist(), until):
            curve = _move(trajectory, since, end)
            code, when, body = _happens(self._scene, curve, since, end, self._shortest, self._desk)
            if code != RUNNING:
                return int(code), float(when), int(body)
            since = end
        return RUNNING, until, -1


def _move(trajectory: Movement, since: float, until: float) -> np.ndarray:
    """Return the move (dof, 4) between two times that have no sample between them."""
    time, joints, rates = trajectory.time, trajectory.joints, trajectory.rates
    dof = joints.shape[1]
    move, whole = np.empty((dof, 4)), np.empty((dof, 4))
    if since >= time[-1] or until <= time[0]:
        rest = joints[-1 if since >= time[-1] else 0]
        line(rest, rest, move)
        return move
    k = int(np.searchsorted(time, since, side="right")) - 1
    span = time[k + 1] - time[k]
    if rates is None:
        line(joints[k], joints[k + 1], whole)
    else:
        hermite(joints[k], rates[k], joints[k + 1], rates[k + 1], span, whole)
    part(whole, (since - time[k]) / span, (until - time[k]) / span, move)
    return move


@njit
def _happens(scene, curve, since, until, shortest, desk):
    """Return outcome (RUNNING if none), time [s] and target of the first event on a move."""
    met, body = first_meeting(scene, curve, since, until, scene.limits.grasp, shortest, desk.poses)
    end = met if met >= 0.0 else until
    last = (end - since) / (until - since)
    if _touches(scene, curve, 0.0, last, since, until, desk):
        free = 0.0
        while last - free > _NARROWEST:
            middle = 0.5 * (free + last)
            if _touches(scene, curve, free, middle, since, until, desk):
                last = middle
            else:
                free = middle
        return COLLIDED, since + last * (until - since), -1
    if met >= 0.0:
        return CAUGHT, met, body
    return RUNNING, until, -1


@njit(_nrt=False)
def _touches(scene, curve, first, last, since, until, desk):
    """Return whether the limb collides between two shares of a move."""
    part(curve, first, last, desk.curve)
    span = until - since
    touch = scene.limb.thickness
    best, _ = least_on(scene, since + first * span, since + last * span, touch, _ANY, _ANY, desk)
    return best <= touch


class Grip(NamedTuple):
    """Closing of the hand about a target; times since the movement's beginning [s]."""

    body: str
    """Name of the target."""
    closes: float
    opens: float | None
    """When it lets go; None if it carries the target to the end."""


@dataclass(frozen=True)
class Gripping(Movement):
    """A movement of an arm whose hand closes and opens."""

    grips: tuple[Grip, ...] = ()
    """In order."""


def gripped(plan: Plan) -> Gripping:
    """Return a plan's movement, with a grip at the end of each hold or at each touch."""
    moves: Any = plan.trajectory
    grips = (
        Grip(one["body"], one.get("held_until", one["time"]), one.get("placed"))
        for one in plan.catches
    )
    return Gripping(moves.arm, moves.time, moves.joints, moves.rates, grips=tuple(grips))


Led = TypeVar("Led", bound=Chain)


def begun(arm: Led, plan: Movement, since: float) -> Movement:
    """Return a plan that begins at a time [s]; after its end the arm brakes to rest."""
    clocked = replace(plan, arm=arm, time=plan.time + since)
    if arm.max_joint_acceleration is None:
        return clocked
    return braked(clocked, np.array(arm.max_joint_acceleration))


def at_first(arm: Led) -> Movement:
    """Return the trajectory of an arm without a plan: it rests, or comes to rest."""
    rates = None if arm.joint_rates is None else np.array([arm.joint_rates])
    return begun(arm, Movement(arm, np.zeros(1), np.array([arm.joints]), rates), 0.0)


def led(arm: Led, trajectory: Movement, t: float) -> Led:
    """Return the arm as it stands and moves at a time [s] of a trajectory.

    Values are clipped to the arm's limits, against rounding.  Without limits of acceleration the
    arm may rest at any time, so its rates do not count.
    """
    joints, rates, _ = trajectory.states_at(np.array([t]))
    low, high = np.array(arm.joint_range).T
    there: Any = tuple(np.clip(joints[0], low, high).tolist())
    if arm.max_joint_acceleration is None:
        return replace(arm, joints=there)
    most = np.array(arm.max_joint_speed)
    moving: Any = tuple(np.clip(rates[0], -most, most).tolist())
    return replace(arm, joints=there, joint_rates=moving)


def gap(arm: Led, trajectory: Movement, t: float) -> float:
    """Largest difference between an arm's joints and a trajectory's at a time [rad]."""
    return float(np.abs(trajectory.joints_at(t) - np.array(arm.joints)).max())


def rest_of(trajectory: Movement, now: float) -> Movement:
    """Return the rest of a trajectory from now on [s], on a clock that begins now."""
    joints, rates, _ = trajectory.states_at(np.array([now]))
    after, moving = trajectory.time > now, None
    if trajectory.rates is not None:
        moving = np.vstack([rates.reshape(1, -1), trajectory.rates[after]])
    return Movement(
        trajectory.arm,
        np.append(0.0, trajectory.time[after] - now),
        np.vstack([joints, trajectory.joints[after]]),
        moving,
    )
