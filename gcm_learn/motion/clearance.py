"""Continuous clearance of a trajectory: no instant between samples is missed."""

from __future__ import annotations

from gcm_learn.collision import least_distance
from gcm_learn.motion.movement import Movement
from gcm_learn.scene import Scene, pack
from gcm_learn.situation import Situation

RESOLUTION = 2e-4  # the reported clearance is at most this above the true one [forearm lengths]


def clearance(
    situation: Situation, trajectory: Movement, scene: Scene | None = None
) -> tuple[float, float]:
    """Smallest distance between limb and obstacles along a trajectory, less the thickness.

    Parameters
    ----------
    situation : Situation
    trajectory : Movement
        Linear between its samples.
    scene : Scene, optional
        The situation packed, if the caller has it at hand.

    Returns
    -------
    clearance : float
        [forearm lengths], within 2e-4 of the true one; infinite without obstacles, and not
        above zero if the limb touches at any instant.
    when : float
        The time of it [s].
    """
    scene = pack(situation) if scene is None else scene
    thickness = scene.limb.thickness
    distance, when = least_distance(scene, trajectory.time, trajectory.hand, thickness, RESOLUTION)
    return (float("inf") if distance > 1e200 else distance - thickness), when
