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
from gcm_learn.scene.outlines import outline
from gcm_learn.scene.packing import integrate_swing, pack, pack_bodies, pose
from gcm_learn.scene.scene import JointLimits, Limits, Scene

__all__ = [
    "ACCELERATION",
    "Bodies",
    "COLUMNS",
    "DISC",
    "HAND",
    "KIND",
    "LIMB",
    "Limits",
    "PART",
    "POSITION",
    "SIZE",
    "Scene",
    "JointLimits",
    "TOP_SPEED",
    "VELOCITY",
    "integrate_swing",
    "later",
    "outline",
    "pack",
    "pack_bodies",
    "pose",
    "pose_at",
    "poses_at",
]
