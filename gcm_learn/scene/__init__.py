"""A situation compiled: bodies and limb as arrays, their poses, bounds of their motion."""

from gcm_learn.scene.bodies import LIMB, PART, TOP_SPEED, Bodies, poses_at
from gcm_learn.scene.limb import SIDE, elbow_of, elbow_position, forward, joint_angles, joints_of
from gcm_learn.scene.outlines import outline
from gcm_learn.scene.packing import integrate_swing, pack, pack_bodies, pose
from gcm_learn.scene.scene import Scene

__all__ = [
    "Bodies",
    "LIMB",
    "PART",
    "SIDE",
    "Scene",
    "TOP_SPEED",
    "elbow_of",
    "elbow_position",
    "forward",
    "integrate_swing",
    "joint_angles",
    "joints_of",
    "outline",
    "pack",
    "pack_bodies",
    "pose",
    "poses_at",
]
