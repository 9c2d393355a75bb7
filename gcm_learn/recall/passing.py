"""On which side of obstacles a path passes: what cannot change without touching them.

In space-time an obstacle is a tube, and a movement is a thread from the hand at t = 0 to the catch.
Two threads with the same ends that pass a tube on different sides cannot be moved into each other
without cutting it. They differ in how much the direction from the body to the hand turns until
then. So "behind it" and "before it comes" are sides, too. Such integrals classify paths among
obstacles in Bhattacharya, Likhachev and Kumar (Autonomous Robots 33, 2012). In the frame of moving
bodies they do in Mavrogiannis and Knepper (IJRR 38, 2019).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from gcm_learn.arms.planar_limb import SIDE, elbows_of
from gcm_learn.collision.distance import arm_distance
from gcm_learn.compiled import njit
from gcm_learn.motion import Movement
from gcm_learn.recall.waypoints import Waypoints, path_of
from gcm_learn.scene.bodies import HAND, PART, pose_at
from gcm_learn.scene.packing import pack_bodies
from gcm_learn.situation import Situation, frame_of

NEAR = 0.3  # limbs that come this near to an obstacle pass it [forearm lengths]
PASSED = 0.5 * np.pi  # from this turn on an obstacle has been passed [rad]
INSTANTS = 256  # between which the direction turns by far less than half a turn


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
        """Letters of the obstacles that are passed nearby, in the order of passing: l for one that
        is left on the hand's left, r on its right. Empty if none is.
        """
        passed = np.flatnonzero((self.clearance <= NEAR) & (np.abs(self.turn) >= PASSED))
        order = passed[np.argsort(self.when[passed], kind="stable")]
        return "".join("l" if self.turn[k] > 0.0 else "r" for k in order)


def passing(situation: Situation, trajectory: Movement) -> Passing:
    """Return how a movement passes the obstacles of a situation, in any frame."""
    arm, bodies = situation.arm, pack_bodies(situation)
    obstacles = np.flatnonzero(bodies.rows[:, PART] != HAND)
    time = np.linspace(0.0, trajectory.duration, INSTANTS)
    hand = trajectory.hand_at(time)
    elbow = elbows_of(hand, arm.upper_arm, SIDE[arm.elbow])
    turn, clearance, when = _passing(bodies, obstacles, time, hand, elbow)
    side = -1.0 if frame_of(situation).mirrored else 1.0
    return Passing(side * turn, clearance, when)


def passing_of(situation: Situation, waypoints: Waypoints) -> Passing:
    """Return how a memory passes the obstacles of its own situation, which is canonical."""
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
