"""Table by kind of arm: the bending of stored movements, and their bounds over a whole cell."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from gcm_learn.arms import CHAIN, PLANAR, SIDE, ByKind, Chain
from gcm_learn.cover.limits import (
    CATCH_SAFETY,
    LARGEST_TURN,
    STRAY,
    derivative,
    hand_room_at_catch,
    hand_speeds,
    room_at_catch,
    turn_bounds,
)
from gcm_learn.errors import FamilyError
from gcm_learn.motion import Movement, joint_turns
from gcm_learn.scene import Scene
from gcm_learn.situation import AnySituation, arm_frame

TURN = 0.04
"""Largest turn of both joints between two samples of a planar arm's stored movement [rad]."""
DAMPING = 0.02
"""Of the inverse of the hand's derivative, as a share of the longest lever."""
HELD_BACK = 0.9
"""Share of the safety of catches that a proof keeps; verification asks for half of it."""


class Bundle(NamedTuple):
    """All movements of a cell: the way in the cell's middle, and bounds of deviations elsewhere."""

    time: np.ndarray
    """(n,) [s]"""
    way: np.ndarray
    """(n, m): hand of a planar arm, joints of others."""
    ramp: np.ndarray
    """(n,): share of the whole deviation, growing from 0 to 1."""
    most: np.ndarray
    """(m,): bound of the deviation at the end."""
    body: int
    """Index of the target."""

    @property
    def steps(self) -> np.ndarray:
        """(n - 1, m) float: largest changes between samples; they are largest in a corner."""
        ramps = np.diff(self.ramp)[:, None] * self.most
        return np.abs(np.diff(self.way, axis=0)) + ramps


class Bending(NamedTuple):
    """Functions of a kind of arm."""

    grasp: float
    """Share of the grasp within which is planned; the rest is for what the rule leaves."""
    way: Callable[[Movement], tuple[np.ndarray, np.ndarray]]
    """Times (n,) and places (n, m) of a movement."""
    slope: Callable[[Scene, np.ndarray], np.ndarray]
    """Derivative (3, m) of the hand by a place (m,), in the arm's coordinates."""
    inverse: Callable[[Scene, np.ndarray], np.ndarray]
    """Change (m, 3) of the last place (m,) for a way of the hand, in the arm's coordinates."""
    fault: Callable[[Scene, Bundle], str]
    """First limit that some movement may break; empty if none can."""
    over: Callable[[Scene, Bundle, np.ndarray, np.ndarray], float]
    """Bound of the distance of hand and target beyond the grasp; not above 0 is a catch.

    It takes what the rule leaves of the target's way, (3, K), and half the cell's sides (K,)."""
    movement: Callable[[Any, np.ndarray, np.ndarray], Movement]
    """Movement of an arm from times (n,) and places (n, m)."""


def _held_back(arm: Any, share: float, margin: float) -> Any:
    """Return the arm with a share of its speed limits, thicker by a margin."""
    hand, joints = arm.max_hand_speed, arm.max_joint_speed
    return replace(
        arm,
        max_hand_speed=None if hand is None else share * hand,
        max_joint_speed=None if joints is None else tuple(share * top for top in joints),
        thickness=arm.thickness + margin,
    )


def _chain_held_back(arm: Chain, share: float, margin: float) -> Chain:
    """Return the chain with a share of its speeds, and links thicker by a margin.

    Pairs of links are left to the proof: thicker ones would touch each other at the start.
    """
    return arm.slower(share).thicker(margin).without_pairs()


_HELD_BACK: ByKind[Callable[[Any, float, float], Any]] = ByKind(
    {CHAIN: _chain_held_back}, default=_held_back
)


def prepared(situation: AnySituation, share: float, margin: float) -> AnySituation:
    """Return the situation to plan in: with a slower and thicker arm, and a smaller grasp.

    Raises
    ------
    FamilyError
        If accelerations are limited.
    """
    arm: Any = situation.arm
    if getattr(arm, "max_joint_acceleration", None) is not None:
        raise FamilyError("arm.max_joint_acceleration", "cannot be kept by covers of touches")
    held = _HELD_BACK.of(situation)(arm, share, margin)
    held = replace(held, grasp=BENDING.of(situation).grasp * arm.grasp)
    return replace(situation, arm=held)


def _hand_way(movement: Movement) -> tuple[np.ndarray, np.ndarray]:
    """Return times and hands, so dense that joints turn little between samples.

    Joints that are linear between the samples then lead the hand along a nearly straight line.
    """
    arm, keep = movement.arm, np.append(np.diff(movement.time) > 0.0, True)
    time, hand = movement.time[keep], movement.hand[keep]
    turns = joint_turns(hand, arm.upper_arm, SIDE[arm.elbow], 4).sum(axis=1)
    counts = np.maximum(np.ceil(turns / TURN).astype(int), 1)
    parts = [k + np.arange(count) / count for k, count in enumerate(counts)]
    places, order = np.concatenate([*parts, [float(len(counts))]]), np.arange(len(time))
    dense = [np.interp(places, order, column) for column in hand.T]
    return np.interp(places, order, time), np.stack(dense, axis=1)


def stray(turns: np.ndarray, rho: float) -> np.ndarray:
    """Bound how far hands (n,) stray from straight lines while joints turn evenly by (n, 2).

    An eighth of the second derivative is a bound.
    """
    first, second = turns.T
    bound: np.ndarray = 0.125 * (rho * first**2 + (first + second) ** 2)
    return bound


def _hand_fault(scene: Scene, bundle: Bundle) -> str:
    """Name the first limit that some movement of a planar arm may break."""
    limits, rho, spans = scene.limits, scene.limb.rho, np.diff(bundle.time)
    way = np.hypot(*bundle.steps.T)
    if (way > limits.speed * spans).any():
        return "hand speed"
    far = bundle.ramp * np.hypot(*bundle.most)
    turns = turn_bounds(bundle.way, far, rho) * way[:, None]
    if turns.max() > LARGEST_TURN or stray(turns, rho).max() > STRAY:  # the first may be 1e300
        return "reach"
    most = np.array([limits.shoulder, limits.elbow])
    return "joint speed" if (turns > most * spans[:, None]).any() else ""


def _joint_fault(scene: Scene, bundle: Bundle) -> str:
    """Name the first limit that some movement in the joints may break."""
    limits, limb, steps = scene.limits, scene.limb, bundle.steps
    spans, away = np.diff(bundle.time)[:, None], bundle.ramp[:, None] * bundle.most
    if (steps > limits.joint_speed * spans).any():
        return "joint speed"
    if (bundle.way - away < limb.low).any() or (bundle.way + away > limb.high).any():
        return "joint range"
    fast = limits.speed < np.inf and (hand_speeds(limb, steps / spans) > limits.speed).any()
    return "hand speed" if fast else ""


def _hand_over(scene: Scene, bundle: Bundle, left: np.ndarray, half: np.ndarray) -> float:
    """Bound a planar hand's excess over the grasp as in the middle: hand and target move alike."""
    room = hand_room_at_catch(scene, *bundle.way[-1], bundle.time[-1], bundle.body)
    off = float(np.linalg.norm(np.abs(left) @ half))
    return float(room) + off - scene.limits.grasp + HELD_BACK * CATCH_SAFETY


def _joints_over(scene: Scene, bundle: Bundle, left: np.ndarray, half: np.ndarray) -> float:
    """Bound a hand's distance beyond the grasp by the rule's first order and a second-order bound.

    A second derivative of the hand by two joints is at most as long as the longest lever.
    """
    q = bundle.way[-1]
    room = room_at_catch(scene, q, bundle.time[-1], bundle.body)
    bent = 0.5 * derivative(scene.limb, q)[1] * float(bundle.most.sum()) ** 2
    off = float(np.linalg.norm(np.abs(left) @ half)) + bent
    return float(room) + off - scene.limits.grasp + HELD_BACK * CATCH_SAFETY * scene.limb.length


def _joint_inverse(scene: Scene, q: np.ndarray) -> np.ndarray:
    """Return the damped inverse of the hand's derivative at joints q (m,)."""
    slope, lever = derivative(scene.limb, q)
    damped = slope @ slope.T + (DAMPING * lever) ** 2 * np.eye(3)
    result: np.ndarray = np.linalg.solve(damped, slope).T
    return result


BENDING: ByKind[Bending] = ByKind(
    {
        PLANAR: Bending(
            1.0,
            _hand_way,
            lambda scene, hand: np.eye(3, 2),
            lambda scene, hand: np.eye(2, 3),
            _hand_fault,
            _hand_over,
            Movement.of_hand,
        )
    },
    default=Bending(
        0.4,
        lambda movement: (movement.time, movement.joints),
        lambda scene, q: derivative(scene.limb, q)[0],
        _joint_inverse,
        _joint_fault,
        _joints_over,
        Movement,
    ),
)


def in_arm(situation: AnySituation, vectors: np.ndarray) -> np.ndarray:
    """Turn vectors (..., 2 or 3) of the world into the arm's coordinates (..., 3)."""
    turn, _ = arm_frame(situation)
    whole = np.zeros((*vectors.shape[:-1], 3))
    whole[..., : vectors.shape[-1]] = vectors
    result: np.ndarray = whole @ turn.T
    return result
