"""Kinds of catches that are the same in the plane and in space: how the hand goes.

A movement is held against the arm's own straight one between the same ends: straight for the hand
in the plane, straight in the joints in space. So a straight reach is the same kind for both.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from sklearn.cluster import KMeans

from gcm_learn.arms import Arm, SpatialArm, forward_in_space
from gcm_learn.situation import Situation

FEATURES = (
    "straight way",
    "roundabout",
    "rests early",
    "rests late",
    "drawn in",
    "stretched out",
    "aside",
    "turn",
    "outwards",
    "late",
)
"""Length of the straight movement [reaches]; the share of the way that it would save; shares of the
time to the catch in which the hand rests, in its first and its second half; by how much the hand
comes nearer to the shoulder than on the straight movement, and farther away [reaches]; by what
angle it leaves it to a side [rad]; the angle between its directions at both ends [rad]; by how much
it is farther out at the end [reaches]; when it catches [horizons]."""
WAY, ROUND, EARLY, LATER, IN, OUT = range(6)
AMOUNTS = slice(ROUND, 7)
COUNT = 6  # kinds
WAITS, BENT = 0.1, 0.05  # of a kind's medians: shares of time and way from which it waits, is bent
NEAR_FAR = ("near", "far")
INSTANTS = 128
SHARES = np.linspace(0.0, 1.0, 33)  # of their ways at which two movements are compared
SLOW = 0.1  # of its top speed: a hand that is slower rests
STILL = 0.02  # [reaches]: a shorter way is none
ASIDE, TURNS, BENDS = (-2.0, 2.0), (-4.0, 4.0), (0.02, 3.1)  # of lifted arms' joints [rad]
BRISK = 3.0  # rates of their joints, in hand speeds [rad / forearm]


def features_of(situation: Any, trajectory: Any) -> np.ndarray:
    """Return the features of a movement to a catch (len(FEATURES),), of either kind of arm."""
    hand, line = (way / situation.arm.reach for way in ways_of(trajectory))
    steps, least = (np.linalg.norm(np.diff(way, axis=0), axis=1) for way in (hand, line))
    resting = steps < SLOW * np.quantile(steps, 0.95)
    half, moved = len(steps) // 2, steps.sum() > STILL
    if not moved:
        resting[:] = True
    here, there = evenly(hand), evenly(line)
    off = np.linalg.norm(here, axis=1) - np.linalg.norm(there, axis=1)
    return np.array([
        least.sum(),
        max(1.0 - least.sum() / steps.sum(), 0.0) if moved else 0.0,
        resting[:half].sum() / len(steps),
        resting[half:].sum() / len(steps),
        max(-off.min(), 0.0),
        max(off.max(), 0.0),
        angles(here, there).max(),
        float(angles(hand[0], hand[-1])),
        np.linalg.norm(hand[-1]) - np.linalg.norm(hand[0]),
        trajectory.duration / situation.horizon,
    ])  # fmt: skip


def ways_of(trajectory: Any) -> tuple[np.ndarray, np.ndarray]:
    """The hand from the shoulder (INSTANTS, d), evenly in time: a movement, and a straight one."""
    time = np.linspace(0.0, trajectory.duration, INSTANTS)
    share = np.linspace(0.0, 1.0, INSTANTS)[:, None]
    hand = trajectory.hand_at(time)
    if trajectory.path is not None:
        return hand, hand[0] + share * (hand[-1] - hand[0])
    first, last = trajectory.joints[0], trajectory.joints[-1]
    _, line = forward_in_space(trajectory.arm, first + share * (last - first))
    shoulder = np.asarray(trajectory.arm.base.origin)
    return hand - shoulder, line - shoulder


def evenly(way: np.ndarray) -> np.ndarray:
    """Places of a way (n, d) at even shares of its length (len(SHARES), d)."""
    steps = np.linalg.norm(np.diff(way, axis=0), axis=1)
    share = np.append(0.0, np.cumsum(steps))
    if share[-1] <= 0.0:
        return np.repeat(way[:1], len(SHARES), axis=0)
    share /= share[-1]
    return np.stack([np.interp(SHARES, share, column) for column in way.T], axis=1)


def angles(one: np.ndarray, other: np.ndarray) -> Any:
    """Angles between vectors (..., d) [rad]."""
    sizes = np.linalg.norm(one, axis=-1) * np.linalg.norm(other, axis=-1)
    cosine = (one * other).sum(axis=-1) / np.maximum(sizes, 1e-12)
    return np.arccos(np.clip(cosine, -1.0, 1.0))


class Kinds(NamedTuple):
    """Clusters of movements, each feature on the scale of the world that they were found in."""

    centre: np.ndarray
    spread: np.ndarray
    fit: KMeans

    @classmethod
    def of(cls, rows: np.ndarray, count: int = COUNT, seed: int = 0, starts: int = 10) -> Kinds:
        """Found among movements (n, len(FEATURES)), the best of some starts."""
        rows = even(rows)
        centre, spread = rows.mean(axis=0), rows.std(axis=0)
        scaled = (rows - centre) / spread
        return cls(centre, spread, KMeans(count, n_init=starts, random_state=seed).fit(scaled))

    def scaled(self, rows: np.ndarray) -> np.ndarray:
        """Movements (n, len(FEATURES)) on the scale."""
        return np.asarray((even(rows) - self.centre) / self.spread)

    def __call__(self, rows: np.ndarray) -> np.ndarray:
        """The kinds (n,) of movements (n, len(FEATURES))."""
        return np.asarray(self.fit.predict(self.scaled(rows)))

    def named(self, rows: np.ndarray) -> dict[int, str]:
        """Return a name for each kind, by the medians of its movements."""
        mine = self(rows)
        middle = np.array([np.median(rows[mine == k], axis=0) for k in range(self.fit.n_clusters)])
        way, straight, round_ = middle[:, WAY], [], {}
        for k, row in enumerate(middle):
            waits = "wait, " if row[EARLY] + row[LATER] > WAITS else ""
            if row[ROUND] < BENT:
                straight += [] if waits else [k]
                round_[k] = waits + "straight"
            else:
                round_[k] = waits + ("round inside" if row[IN] > row[OUT] else "round outside")
        for k, word in zip(sorted(straight, key=lambda k: way[k]), NEAR_FAR, strict=False):
            round_[k] = f"straight, {word}"
        return round_


def even(rows: np.ndarray) -> np.ndarray:
    """Amounts that are mostly near zero (n, len(FEATURES)) as their roots."""
    out = rows.copy()
    out[:, AMOUNTS] = np.sqrt(rows[:, AMOUNTS])
    return out


def lifted(situation: Situation, *, held: bool) -> Situation[SpatialArm]:
    """A canonical planar situation among solids, with an arm in space in place of the planar one.

    Its bones are as long, its hand is where the other's is and as fast.  It stands in the plane at
    t = 0, and cannot leave it if it is held.
    """
    arm = situation.arm
    bend, turn = posture_of(arm)
    aside = (0.0, 0.0) if held else ASIDE
    ranges = (aside, TURNS, aside, (min(BENDS[0], bend), BENDS[1]))
    spatial = SpatialArm(
        upper_arm=(arm.upper_arm, 0.0, 0.0),
        forearm=(1.0, 0.0, 0.0),
        joints=(0.0, turn, 0.0, bend),
        joint_range=ranges,
        max_joint_speed=(BRISK * arm.max_hand_speed,) * 4,
        grasp=arm.grasp,
        max_hand_speed=arm.max_hand_speed,
        thickness=arm.thickness,
    )
    return Situation(situation.name, situation.horizon, spatial, situation.bodies)


def posture_of(arm: Arm) -> tuple[float, float]:
    """Return the angles of a planar arm with its elbow on the right: elbow and direction [rad]."""
    x, y = arm.hand
    cosine = (x * x + y * y - arm.upper_arm**2 - 1.0) / (2.0 * arm.upper_arm)
    bend = math.acos(min(max(cosine, -1.0), 1.0))
    inner = math.atan2(math.sin(bend), arm.upper_arm + math.cos(bend))
    return bend, math.atan2(y, x) - inner
