"""Waypoint trajectories: catches as memory keeps them, in few knots and a frame of their own."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from gcm_learn.arms import Arm
from gcm_learn.compiled import njit
from gcm_learn.motion import Trajectory
from gcm_learn.motion.timing import segment_times
from gcm_learn.planners import Plan
from gcm_learn.recall.kernels import ANGLE, EARLIEST, KNOTS, RING, TIME
from gcm_learn.scene.bodies import pose_at
from gcm_learn.scene.packing import pack_bodies
from gcm_learn.situation import Situation, frame_of

CLOSE = 1e-5  # knots are put where the hand would be farther off than this [forearm lengths]
SLOW = 2.0  # a piece that takes this much longer than it must is a wait


class Waypoints(NamedTuple):
    """A catch as memory keeps it.

    Directions are measured from that of the hand at t = 0, counter-clockwise if the elbow is on the
    right, else clockwise; a share of the ring is 0 at its inner rim and 1 at its outer one, so that
    a trajectory means the same to arms of other proportions: how far the arm is stretched.
    """

    knots: np.ndarray
    """(KNOTS, 4) float32: direction of the hand [rad], its share of the ring, time [s], and the
    earliest time at which it should be there [s]: that time after a wait, else 0."""
    goal: np.ndarray
    """(2,) float32: direction and share of the target's centre when it is caught."""

    @property
    def catch_time(self) -> float:
        """Of the last knot [s]."""
        return float(self.knots[-1, TIME])


@njit
def knot_times(time, places, count, close):
    """Times (count,) at which a path, linear in between, stays as near to itself as it can.

    Beginning with its ends, the sample that is farthest from where the path would be at its time is
    added, until none is farther than `close` (Ramer, Douglas and Peucker's rule with synchronous
    distances, so that waits are corners, too). Knots that are left over halve the longest pieces.
    """
    out, here, there = np.empty(count), np.empty(places.shape[1]), np.empty(places.shape[1])
    out[0], out[1] = time[0], time[-1]
    used = 2
    while used < count:
        far, when = close, -1.0
        for k in range(used - 1):
            first = np.searchsorted(time, out[k], side="right")
            last = np.searchsorted(time, out[k + 1], side="left")
            _place_at(time, places, out[k], here)
            _place_at(time, places, out[k + 1], there)
            for j in range(first, last):
                s, off2 = (time[j] - out[k]) / (out[k + 1] - out[k]), 0.0
                for a in range(here.size):
                    off2 += (here[a] + s * (there[a] - here[a]) - places[j, a]) ** 2
                off = np.sqrt(off2)
                if off > far:
                    far, when = off, time[j]
        if when < 0.0:
            break
        used = _insert(out, used, when)
    while used < count:
        longest, when = -1.0, 0.0
        for k in range(used - 1):
            _place_at(time, places, out[k], here)
            _place_at(time, places, out[k + 1], there)
            length = np.sqrt(((there - here) ** 2).sum())
            if length > longest:
                longest, when = length, 0.5 * (out[k] + out[k + 1])
        used = _insert(out, used, when)
    return out


@njit
def _insert(values, used, value):
    """Insert into the first `used` values, which increase; how many there are then."""
    k = used
    while k > 0 and values[k - 1] > value:
        values[k] = values[k - 1]
        k -= 1
    values[k] = value
    return used + 1


@njit
def _place_at(time, places, t, out):
    """Write the place on a path at time t into `out`."""
    k = np.searchsorted(time, t, side="right") - 1
    if k >= time.size - 1:
        out[:] = places[time.size - 1]
        return
    s = (t - time[k]) / (time[k + 1] - time[k]) if time[k + 1] > time[k] else 0.0
    for a in range(out.size):
        out[a] = places[k, a] + s * (places[k + 1, a] - places[k, a])


def ring_share(arm: Arm, radius: np.ndarray | float) -> np.ndarray | float:
    """Share of the ring of hands at a radius: 0 at the inner rim, 1 at the outer one."""
    return (radius - arm.inner_reach) / (arm.reach - arm.inner_reach)


def waypoints_in_plane(situation: Situation, plan: Plan) -> Waypoints:
    """The catch of a plan as memory keeps it.

    Parameters
    ----------
    situation : Situation
        In any frame; those of a situation and of its canonical form are the same.
    plan : Plan
        A catch in it.
    """
    if plan.trajectory is None or plan.catch_body is None:
        raise ValueError(f"plan: {plan.status}, only catches can be remembered")
    body = [b.name for b in situation.bodies].index(plan.catch_body)
    poses = np.zeros((len(situation.bodies), 12))
    pose_at(pack_bodies(situation), body, plan.trajectory.duration, poses)
    return waypoints_of_path(situation, plan.trajectory, poses[body, :2])


def waypoints_of_path(situation: Situation, trajectory: Trajectory, goal: np.ndarray) -> Waypoints:
    """A path as memory keeps it.

    Parameters
    ----------
    situation : Situation
    trajectory : Trajectory
    goal : (2,) ndarray
        Centre of the target at the path's end, in arm-plane coordinates.
    """
    arm, frame = situation.arm, frame_of(situation)
    side = -1.0 if frame.mirrored else 1.0
    time = knot_times(trajectory.time, trajectory.hand, KNOTS, CLOSE)
    hand = trajectory.hand_at(time)
    knots = np.zeros((KNOTS, 4), dtype=np.float32)
    angles = np.unwrap(np.arctan2(hand[:, 1], hand[:, 0]))
    knots[:, ANGLE] = side * (angles - angles[0])
    knots[:, RING] = ring_share(arm, np.hypot(*hand.T))
    knots[:, TIME] = time
    slow = np.diff(time) > SLOW * segment_times(arm, hand) + 1e-6
    knots[1:, EARLIEST] = np.where(slow, time[1:], 0.0)
    last = float(knots[-1, ANGLE])
    turn = side * (math.atan2(goal[1], goal[0]) - frame.angle) - last
    turn = last + math.remainder(turn, 2.0 * math.pi)
    share = ring_share(arm, math.hypot(*goal))
    return Waypoints(knots, np.array([turn, share], dtype=np.float32))


def path_of(waypoints: Waypoints, arm: Arm) -> tuple[np.ndarray, np.ndarray]:
    """Times (KNOTS,) and hands (KNOTS, 2) of an arm in canonical coordinates."""
    knots = waypoints.knots.astype(float)
    radius = arm.inner_reach + knots[:, RING] * (arm.reach - arm.inner_reach)
    angle = knots[:, ANGLE]
    hand = radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    return knots[:, TIME], hand
