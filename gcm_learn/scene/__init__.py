"""A situation compiled: bodies and limb as arrays, their poses, bounds of their motion."""

from gcm_learn.scene.bodies import (
    ACCELERATION,
    COLUMNS,
    DISC,
    HAND,
    KIND,
    LIMB,
    PART,
    POSITION,
    SIZE,
    TOP_SPEED,
    VELOCITY,
    Bodies,
    pose_at,
    poses_at,
)
from gcm_learn.scene.later import later
from gcm_learn.scene.limb import SIDE, elbow_of, elbow_position, forward, joint_angles, joints_of
from gcm_learn.scene.outlines import outline
from gcm_learn.scene.packing import integrate_swing, pack, pack_bodies, pose
from gcm_learn.scene.scene import Limb, Limits, Scene, SpatialLimits
from gcm_learn.scene.spatial_limb import (
    SpatialLimb,
    forward_in_space,
    inverse_in_space,
    spatial_limb,
    swivel_in_space,
)

__all__ = [
    "ACCELERATION",
    "Bodies",
    "COLUMNS",
    "DISC",
    "HAND",
    "KIND",
    "LIMB",
    "Limb",
    "Limits",
    "PART",
    "POSITION",
    "SIDE",
    "SIZE",
    "Scene",
    "SpatialLimb",
    "SpatialLimits",
    "TOP_SPEED",
    "VELOCITY",
    "elbow_of",
    "elbow_position",
    "forward",
    "forward_in_space",
    "integrate_swing",
    "inverse_in_space",
    "joint_angles",
    "joints_of",
    "later",
    "outline",
    "pack",
    "pack_bodies",
    "pose",
    "pose_at",
    "poses_at",
    "spatial_limb",
    "swivel_in_space",
]
