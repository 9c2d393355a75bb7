"""Planar arms that follow trajectories exactly, and the events on the way.

Trajectories are on the world's clock here: the first sample is the beginning.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from gcm_learn.arms import Arm
from gcm_learn.collision import least_distance
from gcm_learn.execution.arena.kernels.world import CAUGHT, COLLIDED, RUNNING
from gcm_learn.motion import Movement, first_catch, rules_of
from gcm_learn.scene import Scene

_NARROWEST = 1e-6  # how exactly the moment of a collision is found [shares of a move]
_ANY = 1e300  # resolution of distances: collision is exact whatever it is


def begun(arm: Arm, plan: Movement, since: float) -> Movement:
    """Return a plan that begins at a time [s]; after its end the hand rests."""
    return replace(plan, arm=arm, time=plan.time + since)


def at_first(arm: Arm) -> Movement:
    """Return the trajectory of an arm without a plan: it rests."""
    return Movement.of_hand(arm, np.zeros(1), np.array([arm.hand]))


def led(arm: Arm, trajectory: Movement, t: float) -> Arm:
    """Return the arm at a time [s] of a trajectory, its hand clipped to the reach."""
    x, y = trajectory.hand_at(t).tolist()
    away = math.hypot(x, y)
    within = min(max(away, arm.inner_reach), arm.reach)
    share = within / away if away > 0.0 else 1.0
    return replace(arm, hand=(share * x, share * y))


def gap(arm: Arm, trajectory: Movement, t: float) -> float:
    """Distance of an arm's hand to a trajectory's at a time [forearm lengths]."""
    return math.dist(trajectory.hand_at(t), arm.hand)


def rest_of(trajectory: Movement, now: float) -> Movement:
    """Return the rest of a trajectory from now on [s], on a clock that begins now."""
    after = trajectory.time > now
    return Movement(
        trajectory.arm,
        np.append(0.0, trajectory.time[after] - now),
        np.vstack([trajectory.joints_at(now), trajectory.joints[after]]),
        path=np.vstack([trajectory.hand_at(now), trajectory.hand[after]]),
    )


class HandEvents:
    """Catches and collisions in a scene.

    Parameters
    ----------
    scene : Scene
    """

    def __init__(self, scene: Scene) -> None:
        self._scene, self._shortest = scene, rules_of(scene).instant

    def first(self, trajectory: Movement, since: float, until: float) -> tuple[int, float, int]:
        """Return outcome, time [s] and target of the first event between two times, or RUNNING."""
        ends = trajectory.time[-1:]  # a plan catches there, and perhaps nowhere else
        for end in (*ends[(ends > since) & (ends < until)].tolist(), until):
            code, when, body = self._on(trajectory, since, end)
            if code != RUNNING:
                return code, when, body
            since = end
        return RUNNING, until, -1

    def _on(self, trajectory: Movement, since: float, until: float) -> tuple[int, float, int]:
        """Return the same of a span within which the trajectory does not end."""
        bodies, grasp = self._scene.bodies, self._scene.limits.grasp
        met, body = first_catch(bodies, *_part(trajectory, since, until), grasp, self._shortest)
        last = met if met >= 0.0 else until
        if not self._collides(trajectory, since, last):
            return (CAUGHT, met, int(body)) if met >= 0.0 else (RUNNING, until, -1)
        free, narrowest = since, _NARROWEST * (until - since)
        while last - free > narrowest:
            middle = 0.5 * (free + last)
            if self._collides(trajectory, free, middle):
                last = middle
            else:
                free = middle
        return COLLIDED, last, -1

    def _collides(self, trajectory: Movement, since: float, until: float) -> bool:
        """Return whether the limb collides between two times."""
        touch = self._scene.limb.thickness
        time, hand = _part(trajectory, since, until)
        return bool(least_distance(self._scene, time, hand, touch, _ANY)[0] <= touch)


def _part(trajectory: Movement, since: float, until: float) -> tuple[np.ndarray, np.ndarray]:
    """Times (n,) and hands (n, 2) of a trajectory between two times."""
    inner = (trajectory.time > since) & (trajectory.time < until)
    time = np.concatenate([[since], trajectory.time[inner], [until]])
    return time, trajectory.hand_at(time)
