"""Catches of arms with mass, judged as everywhere: by the distance of the hand to a target's solid.

Scenes come as plain tuples, since finding the types of named ones takes long; the types choose the
kernels.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from gcm_learn.arms.limbs import hand_of, place
from gcm_learn.collision.solids import point_distance
from gcm_learn.compiled import njit
from gcm_learn.motion.joint_interception import met_at
from gcm_learn.scene import Bodies, Scene


@cache
def first_met_in(limb_type: Any, limits_type: Any) -> Any:
    """Return the kernel that finds a catch, for types of limbs and of limits."""

    @njit
    def first_met(parts, joints, first, last, step, poses):
        """First step from `first` to `last` with a target within grasp, and which; -1 if none."""
        scene = Scene(Bodies(*parts[0]), limb_type(*parts[1]), limits_type(*parts[2]))
        for k in range(first, last + 1):
            b = met_at(scene, joints[k], k * step, scene.limits.grasp, poses)
            if b >= 0:
                return k, b
        return -1, -1

    return first_met


@njit
def grasped(scene, b, joints, poses, room):
    """Return whether the hand grasps body b at all joints (n, dof) and poses of it (n, 12).

    Parameters
    ----------
    room : (bodies, 12) ndarray
        Its row b is overwritten.
    """
    for k in range(joints.shape[0]):
        room[b] = poses[k]
        x, y, z = hand_of(scene.limb, place(scene.limb, joints[k]))
        if point_distance(scene.bodies, room, b, x, y, z) > scene.limits.grasp:
            return False
    return True
