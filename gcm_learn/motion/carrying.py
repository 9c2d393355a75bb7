"""Carrying: from the end of the hold to its place, the target is one more link of the arm."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from gcm_learn.arms import Chain, Hand, Link, hand_frame, hands_along
from gcm_learn.motion.failures import Failure
from gcm_learn.motion.movement import SAME, Movement
from gcm_learn.motion.rules import rules_of
from gcm_learn.motion.verification import judge_joints
from gcm_learn.scene import bodies_later, pack, pack_bodies, pose_at
from gcm_learn.situation import Body, Situation, SolidQuadratic, Sphere

LINK = "(carried)"
"""Name of the link that a carried target is."""
PLACE = "(place)"
"""Name of the target that stands for a place."""
DEPTH = 0.5
"""Share of the distance to a place that a plan may use."""
SLACK = 5e-7
"""Distance from a place that is granted; the contract grants twice as much."""


def capsule_of(shape: Any) -> tuple[np.ndarray, float]:
    """Return half the axis (3,), in the body's frame, and the radius of a carried shape."""
    if shape.kind != "box":
        return np.array([0.0, 0.0, getattr(shape, "half_length", 0.0)]), shape.radius
    half = np.array(shape.half_extents)
    axis = np.eye(3)[half.argmax()] * half.max()
    return axis, float(np.linalg.norm(half - axis))


def _gripped(
    situation: Situation[Any], index: int, joints: np.ndarray, held: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return place (3,) and axes (3, 3) of a target in the frame of the hand's joint."""
    poses = np.zeros((len(situation.bodies), 12))
    poses[index, 3:] = np.eye(3).ravel()  # spheres leave it so
    pose_at(pack_bodies(situation, max(situation.horizon, held)), index, held, poses)
    turn, origin = hand_frame(situation.arm, joints)
    return turn.T @ (poses[index, :3] - origin), turn.T @ poses[index, 3:].reshape(3, 3)


def carrier(situation: Situation[Any], index: int, joints: np.ndarray, held: float) -> Chain:
    """Return the arm with a target as a link of its hand; the hand's point is the target's origin.

    Parameters
    ----------
    situation : Situation
    index : int
        Position of the target in ``situation.bodies``.
    joints : (n,) ndarray
        Posture at the end of the hold.
    held : float
        When that is [s].
    """
    arm, target = situation.arm, situation.bodies[index]
    centre, axes = _gripped(situation, index, joints, held)
    half, radius = capsule_of(target.shape)
    half = axes @ half
    joint = arm.model.hand.joint
    link = Link(joint, tuple(centre - half), tuple(centre + half), radius, LINK)
    hand = Hand(joint, tuple(centre), arm.model.hand.axis)
    return arm.with_model(replace(arm.model, links=(*arm.model.links, link), hand=hand))


@dataclass(frozen=True)
class Carry:
    """A carried target, from the end of its hold to its place."""

    situation: Situation[Any]
    number: int
    """Position of the target in ``situation.bodies``."""
    moves: Movement
    """Movement that holds the target, and may go on."""
    held: float
    """End of the hold [s]."""

    @property
    def target(self) -> Body:
        """The target."""
        return self.situation.bodies[self.number]

    @cached_property
    def _carrier(self) -> Chain:
        return carrier(self.situation, self.number, self.moves.joints_at(self.held), self.held)

    def poses(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return places (k, 3) and axes (k, 3, 3) of the target in the hand, in the world."""
        joints, arm = self.moves.joints_at(times), self._carrier
        _, axes = _gripped(self.situation, self.number, self.moves.joints_at(self.held), self.held)
        places, shown = np.empty(0), []
        for axis in axes.T:
            hand = replace(arm.model.hand, axis=tuple(axis))
            places, along = hands_along(replace(arm, model=replace(arm.model, hand=hand)), joints)
            shown.append(along)
        return places, np.stack(shown, axis=-1)

    def at(
        self, since: float, horizon: float, ignores: bool, moves: Movement | None = None
    ) -> Situation[Chain]:
        """Return the situation of one part of the carry; its target is the place to reach.

        Parameters
        ----------
        since : float
            Begin of the part [s].
        horizon : float
            Time in which the target has to be placed [s].
        ignores : bool
            Whether supports are ignored.
        moves : Movement, optional
            By which the target is carried, if that is another one.
        """
        situation, target = self.situation, self.target
        assert target.place is not None
        arm = _standing(self._carrier, moves or self.moves, since)
        supports = tuple((LINK, name) for name in target.ignore if ignores)
        size, still = DEPTH * target.place.within, (0.0, 0.0, 0.0)
        law = SolidQuadratic(target.place.position, still, still)
        return replace(
            situation,
            arm=replace(arm, grasp=0.5 * size, ignore=(*arm.ignore, *supports)),
            bodies=(
                Body("target", PLACE, Sphere(0.5 * size), law),
                *bodies_later(situation.obstacles, since),
            ),
            horizon=horizon,
            catch="any",
            end="rest",
            end_by=None if situation.end_by is None else situation.end_by - since,
        )

    def fault(
        self, placed: float, moves: Movement | None = None
    ) -> tuple[Failure | None, float, float]:
        """Return the failure of a movement up to `placed` or None, its clearance, and a time [s].

        The movement is the carry's own by default.
        """
        least, whole = np.inf, moves or self.moves
        for since, until, ignores in self._parts(placed):
            part = self.at(since, until - since, ignores, whole)
            scene, piece = pack(part, until - since), _between(whole, since, until, part.arm)
            rules = rules_of(scene)._replace(touch=scene.limb.thickness)
            failure, distance, when = judge_joints(scene, rules, piece, -1)
            if failure is not None:
                return failure, 0.0, since + when
            least = min(least, distance)
        end = hands_along(part.arm, piece.joints[-1:])[0][0]
        off = float(np.linalg.norm(end - np.array(self.target.place.position)))  # type: ignore[union-attr]
        far = off > self.target.place.within + SLACK  # type: ignore[union-attr]
        return Failure.MISPLACED if far else None, least, placed

    def _parts(self, placed: float) -> Iterator[tuple[float, float, bool]]:
        """Yield parts of the carry: begin, end [s], and whether supports are ignored."""
        brief, held = self.target.ignore_for, self.held
        if not self.target.ignore or brief is None or held + brief >= placed - brief:
            yield held, placed, bool(self.target.ignore)
            return
        yield held, held + brief, True
        yield held + brief, placed - brief, False
        yield placed - brief, placed, True


def _standing(arm: Chain, moves: Movement, t: float) -> Chain:
    """Return the arm with its state at t = 0 taken from a movement at t [s]."""
    joints, rates, forces = (rows[0] for rows in moves.states_at(np.array([t])))
    speed, most = np.array(arm.max_joint_speed), np.array(arm.max_joint_acceleration)
    joints = np.clip(joints, *np.array(arm.joint_range).T)
    begun = None if arm.max_joint_jerk is None else tuple(np.clip(forces, -most, most).tolist())
    return replace(
        arm,
        joints=tuple(joints.tolist()),
        joint_rates=tuple(np.clip(rates, -speed, speed).tolist()),
        joint_accelerations=begun,
    )


def _between(moves: Movement, since: float, until: float, arm: Chain) -> Movement:
    """Return a part of a movement, from t = 0 on."""
    inside = moves.time[(moves.time > since + SAME) & (moves.time < until - SAME)]
    time = np.concatenate([[since], inside, [until]])
    joints, rates, _ = moves.states_at(time)
    joints[0], rates[0] = arm.joints, arm.joint_rates
    return Movement(arm, time - since, joints, rates)
