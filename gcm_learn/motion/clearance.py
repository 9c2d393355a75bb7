"""Continuous clearance of a trajectory: no instant between samples is missed."""

from __future__ import annotations

from gcm_learn.collision.sweep import least_distance
from gcm_learn.motion.trajectory import Trajectory
from gcm_learn.scene.bodies import Bodies
from gcm_learn.scene.limb import SIDE
from gcm_learn.scene.packing import pack
from gcm_learn.situation import Situation

RESOLUTION = 2e-4  # the reported clearance is at most this above the true one [forearm lengths]


def clearance(
    situation: Situation, trajectory: Trajectory, bodies: Bodies | None = None
) -> tuple[float, float]:
    """Smallest distance between limb and obstacles along a trajectory, less the thickness.

    Parameters
    ----------
    situation : Situation
    trajectory : Trajectory
        Linear between its samples.
    bodies : Bodies, optional
        The situation packed, if the caller has it at hand.

    Returns
    -------
    clearance : float
        [forearm lengths], within 2e-4 of the true one; infinite without obstacles, and not
        above zero if the limb touches at any instant.
    when : float
        The time of it [s].
    """
    arm = situation.arm
    distance, when = least_distance(
        pack(situation) if bodies is None else bodies,
        trajectory.time,
        trajectory.hand,
        arm.upper_arm,
        SIDE[arm.elbow],
        arm.thickness,
        RESOLUTION,
    )
    return (float("inf") if distance > 1e200 else distance - arm.thickness), when
