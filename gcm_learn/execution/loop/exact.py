"""An arm in space that follows trajectories exactly, judged at every instant."""

from __future__ import annotations

import numpy as np

from gcm_learn.arms import JOINTS, SpatialArm, forward_in_space
from gcm_learn.arms.curves import hermite, line, part
from gcm_learn.collision.postures import desk_of, least_on
from gcm_learn.compiled import njit
from gcm_learn.execution.arena.kernels.world import CAUGHT, COLLIDED, LATE, RUNNING
from gcm_learn.motion import Movement, rules_of
from gcm_learn.motion.joint_interception import first_meeting
from gcm_learn.scene import Scene, pack
from gcm_learn.situation import Situation

JUMP = 1e-6  # joints of a trajectory may be off by this where it is taken up [rad]
_NARROWEST = 1e-6  # how exactly the moment of a touch is found [shares of a move]
_ANY = 1e300  # resolution of distances: whether the limb touches is exact whatever it is


class ExactPlant:
    """A kinematic arm in its world: a `LedPlant`.

    A catch is the first moment at which a target is within grasp, a collision the first one at
    which the limb touches an obstacle.

    Parameters
    ----------
    situation : Situation
    """

    def __init__(self, situation: Situation[SpatialArm]) -> None:
        self.situation = situation
        self.time = 0.0
        self.joints = np.array(situation.arm.joints)
        self.rates = np.array(situation.arm.joint_rates or (0.0,) * JOINTS)
        self.outcome = RUNNING
        self.catch_time: float | None = None
        self._scene: Scene = pack(situation)
        self._shortest = rules_of(self._scene).instant
        self._desk = desk_of(self._scene)

    @property
    def hand(self) -> np.ndarray:
        """(3,), in the world."""
        return forward_in_space(self.situation.arm, self.joints[None])[1][0]

    def follow(self, trajectory: Movement, until: float) -> None:
        """Let the world go on until a time, or until the episode is over.

        Parameters
        ----------
        trajectory : Movement
            On the world's clock; it is now where the arm is.
        until : float
            [s]
        """
        off = np.abs(trajectory.joints_at(self.time) - self.joints).max()
        if off > JUMP:
            raise ValueError(
                f"trajectory: is {off:.2g} rad away from the joints at {self.time:g} s"
            )
        horizon = self.situation.horizon
        end = min(until, horizon)
        inner = trajectory.time[(trajectory.time > self.time) & (trajectory.time < end)]
        for t in (*inner.tolist(), end):
            if self.outcome == RUNNING and t > self.time:
                self._go(trajectory, t)
        if self.outcome == RUNNING and self.time >= horizon:
            self.outcome = LATE

    def _go(self, trajectory: Movement, until: float) -> None:
        """Go on to a time before which the trajectory has no other sample."""
        curve = _move(trajectory, self.time, until)
        code, when = _happens(self._scene, curve, self.time, until, self._shortest, self._desk)
        self.outcome = int(code)
        if code == CAUGHT:
            self.catch_time = float(when)
        self.time = float(when)
        joints, rates, _ = trajectory.states_at(np.array([self.time]))
        self.joints, self.rates = joints[0], rates[0]


def _move(trajectory: Movement, since: float, until: float) -> np.ndarray:
    """The move (4, 4) between two times; between them, or at one of them, there is no sample."""
    time, joints, rates = trajectory.time, trajectory.joints, trajectory.rates
    move, whole = np.empty((JOINTS, 4)), np.empty((JOINTS, 4))
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
    """Return the first event on a move, or RUNNING, and its time [s]."""
    met, _ = first_meeting(scene, curve, since, until, scene.limits.grasp, shortest, desk.poses)
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
        return COLLIDED, since + last * (until - since)
    if met >= 0.0:
        return CAUGHT, met
    return RUNNING, until


@njit(_nrt=False)
def _touches(scene, curve, first, last, since, until, desk):
    """Return whether the limb is touched between two shares of a move."""
    part(curve, first, last, desk.curve)
    span = until - since
    touch = scene.limb.thickness
    best, _ = least_on(scene, since + first * span, since + last * span, touch, _ANY, _ANY, desk)
    return best <= touch
