"""A gate: the way to the target opens at a moment, and the hand has to wait for it.

A body that stands nearer to the shoulder than the elbow keeps the upper arm from turning past it.
So a resting body on one side of the upper arm and a gate on its other side lock the arm in, however
long the way round. The gate opens in one of two ways. A *bolt* is a bar that points at the shoulder
and slides outwards; it is open when its inner end is farther than the elbow. A *runner* is a ball
that passes the shoulder and runs ahead of the arm. It is open when it has passed the direction that
the upper arm has at the target. Both start from rest, so a front is there before.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from gcm_learn.arms import Arm
from gcm_learn.families import ranges
from gcm_learn.families.layout import TRIES, Event, anywhere, elbow_at, polar, way_time
from gcm_learn.families.piece_family import InSpace, PieceFamily
from gcm_learn.families.pieces import PlanarPiece, Vector, solid_body
from gcm_learn.situation import Body

STEEPEST = 1.2  # [rad] runners would have to run far if the target were farther behind
LONGEST = 0.5  # straight way to the target, in ways that the hand can make within the horizon


class Lock(NamedTuple):
    """Directions seen from the shoulder [rad], and where the target is."""

    arm: float
    """Of the upper arm at the start."""
    ahead: float
    """1 if the way to the target turns counter-clockwise, else -1."""
    gate: float
    """Of the gate at first."""
    behind: float
    """Angle from there to the upper arm that reaches the target."""
    meet: Vector
    """Hand at the target [forearms]."""


@dataclass(frozen=True)
class Gate(PieceFamily):
    """A resting target behind a gate; the arm is locked in until the gate opens."""

    name = "gate"
    summary = "a gate that locks the arm in until it slides away or runs ahead"

    obstacles: ranges.Counts = ranges.counts(2, 4, 2)
    """Number of obstacles, the gate and the body on the arm's other side included."""
    opening: ranges.Range = ranges.span(0.05, 0.4, 0.01, 0.95)
    """Instant at which the gate opens, as shares of the time from when the hand could be at the
    target, if there were no gate, until the horizon."""
    bolts: float = ranges.number(0.6)
    """Share of gates that are bolts; the others are runners."""
    before: ranges.Range = ranges.span(0.15, 0.5, most=1.5)
    """Angle at the shoulder from the limb to the gate [rad]."""
    behind: ranges.Range = ranges.span(0.3, 0.8, most=1.2)
    """Angle from the gate to the limb that reaches the target [rad]."""
    back: ranges.Range = ranges.span(0.4, 1.2, most=2.0)
    """Angle from the upper arm to the resting body on its other side [rad]."""
    bend: ranges.Range = ranges.span(0.6, 2.2, 0.1, 3.0)
    """Angle of the elbow at the target, 0 being a straight arm [rad]."""
    near: ranges.Range = ranges.span(0.15, 0.45, 0.05, 0.9)
    """Distance of bolt, runner and resting body from the shoulder at first [upper arms]."""
    bolt: ranges.Range = ranges.span(0.4, 0.8, 0.2)
    """Half the length of bolts [forearms]."""
    runner: ranges.Range = ranges.span(0.03, 0.07, 1e-3)
    """Radius of runners and of the resting body [forearms]."""

    def pieces(self, rng: np.random.Generator, arm: Arm, horizon: float) -> tuple[PlanarPiece, ...]:
        """The target, the gate, the body on the other side, others that rest."""
        for _ in range(TRIES):
            lock = self._lock(rng, arm)
            way = way_time(arm, lock.meet)
            if way <= LONGEST * horizon:
                break
        target = PlanarPiece("target", "target", self.sizes.ball_to_catch(rng), lock.meet)
        opens = way + ranges.pick(rng, self.opening) * max(horizon - way, 0.1 * horizon)
        bolted = rng.random() < self.bolts or lock.behind > STEEPEST
        gate = (self._bolt if bolted else self._runner)(rng, arm, lock, opens)
        side = lock.arm - lock.ahead * ranges.pick(rng, self.back)
        place = polar(ranges.pick(rng, self.near) * arm.upper_arm, side)
        post = PlanarPiece("obstacle", "post", (ranges.pick(rng, self.runner),), place)
        event = Event(target, lock.meet, opens, horizon, lock.ahead)
        others = ranges.pick_count(rng, self.obstacles) - 2
        return target, gate, post, *self.fitting(rng, arm, event, others)

    def _lock(self, rng: np.random.Generator, arm: Arm) -> Lock:
        """Draw a gate beside the limb, and a target behind the gate."""
        first = math.atan2(*reversed(elbow_at(arm, arm.hand)))
        ahead = ranges.pick_sign(rng)
        forearm = 1.0 if arm.elbow == "right" else -1.0  # to which side of the upper arm
        spread = math.remainder(math.atan2(arm.hand[1], arm.hand[0]) - first, math.tau)
        gate = first + ahead * (max(ahead * spread, 0.0) + ranges.pick(rng, self.before))
        bend, behind = ranges.pick(rng, self.bend), ranges.pick(rng, self.behind)
        if forearm != ahead:  # the forearm points back to the gate
            behind += math.atan2(math.sin(bend), arm.upper_arm + math.cos(bend))
        meet = _hand_of(arm, gate + ahead * behind, forearm * bend)
        return Lock(first, ahead, gate, behind, meet)

    def obstacle(self, rng: np.random.Generator, arm: Arm, event: Event, k: int) -> PlanarPiece:
        """A body at rest that the arm can dodge."""
        size, angle = self.sizes.any(rng), ranges.pick_angle(rng)
        return PlanarPiece(
            "obstacle", f"obstacle {k + 1}", size, anywhere(rng, arm, 0.0), angle=angle
        )

    def _bolt(self, rng: np.random.Generator, arm: Arm, lock: Lock, opens: float) -> PlanarPiece:
        """Draw a bar along the gate's direction; its inner end passes the elbow at time `opens`."""
        half, inner = ranges.pick(rng, self.bolt), ranges.pick(rng, self.near) * arm.upper_arm
        pull = 2.0 * (arm.upper_arm - inner) / opens**2
        size = (half, ranges.pick(rng, self.sizes.half_width))
        return PlanarPiece(
            "obstacle", "bolt", size, polar(inner, lock.gate),
            acceleration=polar(pull, lock.gate), angle=lock.gate, offset=half,
        )  # fmt: skip

    def _runner(self, rng: np.random.Generator, arm: Arm, lock: Lock, opens: float) -> PlanarPiece:
        """Draw a ball that runs at right angles to the gate, past the upper arm at the target."""
        # It has to get there before it is farther from the shoulder than the elbow.
        near = min(ranges.pick(rng, self.near), 0.9 * math.cos(lock.behind)) * arm.upper_arm
        pull = 2.0 * near * math.tan(lock.behind) / opens**2
        return PlanarPiece(
            "obstacle", "runner", (ranges.pick(rng, self.runner),), polar(near, lock.gate),
            acceleration=polar(pull, lock.gate + lock.ahead * math.pi / 2),
        )  # fmt: skip


def _hand_of(arm: Arm, first: float, second: float) -> Vector:
    """Return the hand's place at joint angles: the upper arm's direction, the forearm's turn."""
    rho = arm.upper_arm
    return (
        rho * math.cos(first) + math.cos(first + second),
        rho * math.sin(first) + math.sin(first + second),
    )


@dataclass(frozen=True)
class GateSolid(InSpace, Gate):
    """Gates of solids; some bolts leave the plane along its normal instead of sliding in it."""

    name = "gate-solid"
    summary = "a gate of solids that slides away, runs ahead or is pulled out of the plane"

    pulled: float = ranges.number(0.5)
    """Share of bolts that leave along the plane's normal."""

    def _bolt(self, rng: np.random.Generator, arm: Arm, lock: Lock, opens: float) -> PlanarPiece:
        """Draw a bolt that slides in the plane, or a bolt that leaves the plane from rest."""
        bolt = super()._bolt(rng, arm, lock, opens)
        if rng.random() >= self.pulled:
            return bolt
        return bolt._replace(acceleration=(0.0, 0.0), leaves=opens)

    def body(self, rng: np.random.Generator, piece: PlanarPiece, arm: Arm) -> Body:
        """Make a piece's body; gates neither lean nor come through the plane by chance."""
        is_gate = piece.name in ("bolt", "runner")
        return solid_body(rng, piece, self.space, arm.max_hand_speed, firm=is_gate)
