"""Stored catches: movements that bend with the parameters, and their proofs for whole cells."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from gcm_learn.cover.families import ParametricFamily
from gcm_learn.cover.kinds import BENDING, Bundle, in_arm, prepared
from gcm_learn.cover.limits import SAFETY
from gcm_learn.cover.reaching import ITSELF, NOWHERE, first_touch
from gcm_learn.motion import Ask, Movement, Verdict, rules_of, verify
from gcm_learn.planners import solve
from gcm_learn.scene import Scene, pack

HAIR = 1e-5
"""Clearance that a proof keeps beyond that of plans, against rounding [forearm lengths]."""
WIDER = 1e-9
"""By how much proven cells are larger than their sides say, against rounding."""
BEGINS = (0.0, 0.5)
"""Shares of a movement at which its deviation begins; both are tried."""
LADDER = ((0.75, 0.2), (0.8, 0.1), (0.85, 0.05), (0.9, 0.025), (0.95, 0.008))
"""Shares of speeds and further clearances [forearms] with which is planned, until one is found."""


@dataclass(frozen=True)
class StoredCatch:
    """A movement that bends linearly with the parameters.

    ``place(t; theta) = way(t) + ramp(t) gain (theta - anchor)``. The place is the hand of a planar
    arm, and the joints of another arm.
    """

    anchor: np.ndarray
    """(K,) float: parameters for which it was planned."""
    time: np.ndarray
    """(n,) float: [s], from 0 on."""
    way: np.ndarray
    """(n, m) float: places."""
    ramp: np.ndarray
    """(n,) float: from 0 to 1, growing."""
    gain: np.ndarray
    """(m, K) float: change of the last place for a unit of each parameter."""
    body: int
    """Index of the target."""
    rates: np.ndarray | None = None
    """(n, m) float: of the joints, where the target is held; such a movement does not bend."""
    span: tuple[float, float] | None = None
    """When a held target is caught, and until when it is held [s]."""

    def places(self, theta: np.ndarray) -> np.ndarray:
        """Places (n, m) for parameters theta (K,)."""
        bent: np.ndarray = self.way + self.ramp[:, None] * (self.gain @ (theta - self.anchor))
        return bent

    def movement(self, family: ParametricFamily, theta: np.ndarray) -> Movement:
        """Return the movement for parameters theta (K,)."""
        arm = family.middle.arm
        if self.rates is not None:
            return Movement(arm, self.time, self.way, self.rates)
        return BENDING.of(arm).movement(arm, self.time, self.places(theta))

    def verdict(self, family: ParametricFamily, theta: np.ndarray) -> Verdict:
        """Verify the movement for parameters theta (K,)."""
        movement = self.movement(family, theta)
        return verdict_of(family.situation(theta), movement, self.body, self.span)


def verdict_of(
    situation: Any, movement: Movement, body: int, span: tuple[float, float] | None
) -> Verdict:
    """Verify a movement that touches a target at its end, or holds the target for a span [s]."""
    scene = pack(situation)
    ask = None if span is None else Ask.of(situation, [(body, *span)])
    return verify(scene, rules_of(scene), movement, body, ask)


@dataclass(frozen=True)
class Doubt:
    """The first thing that is not proven of a stored catch in a cell."""

    reason: str
    """Name of a limit, "clearance" or "grasp", or why there is no movement."""
    shares: np.ndarray
    """(K,) float: how much each parameter adds to what is bounded; the largest is to be split."""


def doubt_of(
    family: ParametricFamily, catch: StoredCatch, centre: np.ndarray, half: np.ndarray, scene: Scene
) -> Doubt | None:
    """Prove that a stored catch holds in a whole cell, or return the first doubt.

    Parameters
    ----------
    family : ParametricFamily
    catch : StoredCatch
    centre, half : (K,) ndarray
        Middle of the cell, and half its sides.
    scene : Scene
        The situation of the middle.

    Returns
    -------
    Doubt or None
        None if the movement of every theta in the cell keeps start, limits, clearance and grasp.
    """
    half = half + WIDER
    bending, unit = BENDING.of(scene), getattr(scene.limb, "length", 1.0)
    most = np.abs(catch.gain) @ half
    bundle = Bundle(catch.time, catch.places(centre), catch.ramp, most, catch.body)
    own = half * np.abs(catch.gain).sum(axis=0)
    fault = bending.fault(scene, bundle)
    if fault:
        return Doubt(fault, own)
    drifts = in_arm(family.middle, family.drifts(catch.time))
    left = drifts[-1, :, catch.body].T - bending.slope(scene, bundle.way[-1]) @ catch.gain
    if bending.over(scene, bundle, left, half) > 0.0:
        return Doubt("grasp", own)
    # Each coordinate of a body's place is linear in t and theta, so its bound is convex in t.
    off = np.linalg.norm(np.einsum("nkbd,k->nbd", np.abs(drifts), half), axis=-1)
    moves = (bundle.time, bundle.way, bundle.ramp[:, None] * most)
    touch = scene.limb.thickness + (SAFETY + HAIR) * unit
    body, when = first_touch(scene, moves, off, touch)
    if body == NOWHERE:
        return None
    if body == ITSELF:
        return Doubt("clearance", own)
    moved = np.linalg.norm(
        in_arm(family.middle, family.drifts(np.array([when])))[0, :, body], axis=1
    )
    return Doubt("clearance", own * np.interp(when, catch.time, catch.ramp) + half * moved)


def planned(family: ParametricFamily, theta: np.ndarray) -> tuple[list[StoredCatch], str]:
    """Plan for parameters theta (K,), with as much to spare as there is a plan for.

    Returns
    -------
    catches : list of StoredCatch
        The movement, with a ramp from each of `BEGINS`.
    reason : str
        Reason for an empty list.
    """
    situation = family.situation(theta)
    scene = pack(situation)
    bending, unit = BENDING.of(scene), getattr(scene.limb, "length", 1.0)
    names, reason = [body.name for body in situation.bodies], ""
    for share, margin in LADDER:
        asked: Any = prepared(situation, share, margin * unit)
        plan = solve(asked)
        if plan.trajectory is None or plan.catch_body is None:
            reason = plan.status
            continue
        if plan.trajectory.time.size < 2:
            return [], "caught at t = 0"
        time, way = bending.way(plan.trajectory)
        body = names.index(plan.catch_body)
        drift = in_arm(situation, family.drifts(time[-1:])[0, :, body])
        gain = bending.inverse(scene, way[-1]) @ drift.T
        bare = StoredCatch(theta, time, way, time, gain, body)
        return [_ramped(bare, begin) for begin in BEGINS], ""
    return [], reason


def _ramped(catch: StoredCatch, begin: float) -> StoredCatch:
    """Return the catch with a deviation that begins at a share of the movement's time."""
    first, last = begin * catch.time[-1], catch.time[-1]
    time = catch.time
    if not (np.abs(time - first) < 1e-9 * last).any():  # a sample where the ramp begins
        time = np.sort(np.append(time, first))
    way = np.stack([np.interp(time, catch.time, column) for column in catch.way.T], axis=1)
    ramp = np.clip((time - first) / (last - first), 0.0, 1.0)
    ramp[np.abs(time - first) < 1e-9 * last] = 0.0
    ramp[-1] = 1.0
    return StoredCatch(catch.anchor, time, way, ramp, catch.gain, catch.body)
