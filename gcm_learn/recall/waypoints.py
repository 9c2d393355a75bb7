"""Waypoints: catches as memory keeps them, in few knots and a frame of their own.

A path passes an obstacle on a side, which cannot change without touching it. In space-time an
obstacle is a tube, and a movement is a thread from the hand at t = 0 to the catch. Threads on
different sides differ in how much the direction from the body to the hand turns until then. Such
integrals classify paths in Bhattacharya, Likhachev and Kumar (Autonomous Robots 33, 2012), and in
the frame of moving bodies in Mavrogiannis and Knepper (IJRR 38, 2019).
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from gcm_learn.arms import Arm
from gcm_learn.arms.planar_limb import SIDE, elbows_of
from gcm_learn.collision.distance import arm_distance
from gcm_learn.compiled import njit
from gcm_learn.motion import Movement, opening
from gcm_learn.motion.timing import segment_times
from gcm_learn.planners import study_of
from gcm_learn.recall.hand_paths import ANGLE, KNOTS as HAND_KNOTS, RING
from gcm_learn.recall.headings import heading_of
from gcm_learn.recall.joint_moves import AFTER, KNOTS as JOINT_KNOTS, centre_of, least_times
from gcm_learn.scene import pack
from gcm_learn.scene.bodies import HAND, PART, pose_at
from gcm_learn.scene.packing import pack_bodies
from gcm_learn.situation import Situation, canonical, frame_of

CLOSE = 1e-5  # largest distance of a hand path from its knots [forearm lengths]
CLOSE_JOINTS = 1e-2  # largest distance of a joint movement from its knots [rad]
SLOW = 2.0  # a piece that takes this much longer than it must is a wait
RESTS = 10.0  # the same of a movement that takes time to come to its speed
INSTANTS = 97  # of a curved movement, at which knots may lie
GOAL = 6  # numbers of the goal of a joint movement
TIME, EARLIEST = -2, -1  # columns of a knot, after its place


class Waypoints(NamedTuple):
    """A catch in the form that memories store: knots and a goal.

    Knots of a planar arm are hands: direction and share of the ring; so is its goal. Directions are
    measured from that of the hand at t = 0, counter-clockwise if the elbow is on the right, else
    clockwise. A share of the ring is 0 at its inner rim and 1 at its outer one. So a path means
    the same to arms of other proportions.

    Knots of a spatial arm are joints of a left arm [rad]. Its goal is the target's centre, and the
    hand from there, in the frame of the left arm's base [reaches]. A chain is turned about its
    first joint until the target is ahead; see `recall.headings`.
    """

    knots: np.ndarray
    """(24, 4) or (12, joints + 2) float32: place, time [s], and earliest time [s]: after a wait
    that time, else 0; AFTER past the catch, for the ends of a hold and of its movement."""
    goal: np.ndarray
    """(2,) or (6,) float32: place of the target's centre when it is caught."""

    @property
    def catch_time(self) -> float:
        """Time of the catch [s]."""
        return float(self.knots[self.knots[:, EARLIEST] >= 0.0, TIME][-1])


@njit
def knot_times(time, places, count, close):
    """Return times (count,) of knots between which linear interpolation stays near the path.

    Beginning with its ends, the sample that is farthest from the path at its time is added, until
    all are as near as `close`. This is the rule of Ramer, Douglas and Peucker with synchronous
    distances, so that waits are corners, too. Knots that are left over halve the longest pieces.
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
    """Insert into the first `used` values, which increase; return their new number."""
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
    """Return the share of the ring at a radius: 0 at the inner rim, 1 at the outer one."""
    return (radius - arm.inner_reach) / (arm.reach - arm.inner_reach)


def hand_waypoints(situation: Situation, path: Movement, body: int) -> Waypoints:
    """Return the waypoints of a planar arm's movement to a body."""
    poses = np.zeros((len(situation.bodies), 12))
    pose_at(pack_bodies(situation), body, path.duration, poses)
    arm, frame, goal = situation.arm, frame_of(situation), poses[body, :2]
    side = -1.0 if frame.mirrored else 1.0
    time = knot_times(path.time, path.hand, HAND_KNOTS, CLOSE)
    hand = path.hand_at(time)
    angles = np.unwrap(np.arctan2(hand[:, 1], hand[:, 0]))
    places = np.empty((len(time), 2))
    places[:, ANGLE], places[:, RING] = (
        side * (angles - angles[0]),
        ring_share(arm, np.hypot(*hand.T)),
    )
    knots = _knots(places, time, SLOW * segment_times(arm, hand))
    last = float(knots[-1, ANGLE])
    turn = side * (math.atan2(goal[1], goal[0]) - frame.angle) - last
    turn = last + math.remainder(turn, 2.0 * math.pi)
    share = ring_share(arm, math.hypot(*goal))
    return Waypoints(knots, np.array([turn, share], dtype=np.float32))


def joint_waypoints(
    situation: Situation[Any], path: Movement, body: int, held: tuple[float, float] | None = None
) -> Waypoints:
    """Return the waypoints of a spatial arm's or a chain's movement to a body.

    Parameters
    ----------
    situation : Situation
    path : Movement
    body : int
        The target.
    held : (float, float), optional
        Times of the catch and of letting go [s]; then the last knots are the end of the hold and
        that of the movement.
    """
    turned, frame = canonical(situation)
    caught = path.duration if held is None else held[0]
    after = [] if held is None else [held[1], path.duration]
    seen = path.time if path.rates is None else np.linspace(0.0, caught, INSTANTS)
    joints = frame.canonical_joints(path.joints_at(seen))
    time = knot_times(seen, joints, JOINT_KNOTS - len(after), CLOSE_JOINTS)
    time = np.concatenate([time, after])
    at, scene = frame.canonical_joints(path.joints_at(time)), pack(turned)
    least = least_times(study_of(scene, opening(scene).rules), at)
    heading = heading_of(scene.limb, scene)
    knots = _knots(at - heading.shift, time, (SLOW if path.rates is None else RESTS) * least)
    knots[len(time) - len(after) :, EARLIEST] = AFTER
    places = frame.canonical(path.hand_at(caught)), centre_of(scene.bodies, body, caught)
    hand, centre = (np.stack(places) - heading.origin) @ heading.rows.T
    goal = np.concatenate([centre, hand - centre]) / situation.arm.reach
    return Waypoints(knots, goal.astype(np.float32))


def _knots(places: np.ndarray, time: np.ndarray, longest: np.ndarray) -> np.ndarray:
    """Return knots (n, m + 2) float32; a piece that takes longer than `longest` (n - 1,) waits."""
    knots = np.zeros((len(time), places.shape[1] + 2), dtype=np.float32)
    knots[:, :TIME], knots[:, TIME] = places, time
    knots[1:, EARLIEST] = np.where(np.diff(time) > longest + 1e-6, time[1:], 0.0)
    return knots


def path_of(waypoints: Waypoints, arm: Arm) -> tuple[np.ndarray, np.ndarray]:
    """Return times (n,) and hands (n, 2) of a planar arm in canonical coordinates."""
    knots = waypoints.knots.astype(float)
    radius = arm.inner_reach + knots[:, RING] * (arm.reach - arm.inner_reach)
    angle = knots[:, ANGLE]
    hand = radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    return knots[:, TIME], hand


NEAR = 0.3  # limbs that come this near to an obstacle pass it [forearm lengths]
PASSED = 0.5 * np.pi  # from this turn on an obstacle has been passed [rad]
LOOKS = 256  # between which the direction turns by far less than half a turn


class Passing(NamedTuple):
    """Sides on which a movement passes the obstacles, in their order (m,)."""

    turn: np.ndarray
    """By how much the direction from the body's centre to the hand turns, in the situation's
    canonical frame [rad]; positive if the hand leaves the body on its left."""
    clearance: np.ndarray
    """Least distance of the limb [forearm lengths]."""
    when: np.ndarray
    """And when it is so near [s]."""

    @property
    def sides(self) -> str:
        """Letters of obstacles passed nearby, in order: l left of the hand, r right; or empty."""
        passed = np.flatnonzero((self.clearance <= NEAR) & (np.abs(self.turn) >= PASSED))
        order = passed[np.argsort(self.when[passed], kind="stable")]
        return "".join("l" if self.turn[k] > 0.0 else "r" for k in order)


def passing(situation: Situation, trajectory: Movement) -> Passing:
    """Return how a movement passes the obstacles of a situation, in any frame."""
    arm, bodies = situation.arm, pack_bodies(situation)
    obstacles = np.flatnonzero(bodies.rows[:, PART] != HAND)
    time = np.linspace(0.0, trajectory.duration, LOOKS)
    hand = trajectory.hand_at(time)
    elbow = elbows_of(hand, arm.upper_arm, SIDE[arm.elbow])
    turn, clearance, when = _passing(bodies, obstacles, time, hand, elbow)
    side = -1.0 if frame_of(situation).mirrored else 1.0
    return Passing(side * turn, clearance, when)


def passing_of(situation: Situation, waypoints: Waypoints) -> Passing:
    """Return the passing of a memory by the obstacles of its own, canonical situation."""
    arm = situation.arm
    return passing(situation, Movement.of_hand(arm, *path_of(waypoints, arm)))


@njit
def _passing(bodies, obstacles, time, hand, elbow):
    """Turns, least distances and their times (m,) of some bodies."""
    poses = np.zeros((bodies.rows.shape[0], 12))
    turn, when = np.zeros(obstacles.size), np.zeros(obstacles.size)
    clearance = np.full(obstacles.size, np.inf)
    for i in range(obstacles.size):
        b = obstacles[i]
        x0, y0 = 0.0, 0.0
        for k in range(time.size):
            pose_at(bodies, b, time[k], poses)
            x, y = hand[k, 0] - poses[b, 0], hand[k, 1] - poses[b, 1]
            if k > 0:
                turn[i] += np.arctan2(x0 * y - y0 * x, x0 * x + y0 * y)
            x0, y0 = x, y
            gap = arm_distance(bodies, poses, b, hand[k, 0], hand[k, 1], elbow[k, 0], elbow[k, 1])
            if gap < clearance[i]:
                clearance[i], when[i] = gap, time[k]
    return turn, clearance, when
