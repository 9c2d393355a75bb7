"""A situation compiled: bodies and limb as arrays, their poses, bounds of their motion."""

from gcm_learn.scene.bodies import (
    ACCELERATION,
    BALL,
    COLUMNS,
    HAND,
    LIMB,
    PART,
    POSITION,
    SIZE,
    SWING,
    TOP_SPEED,
    VELOCITY,
    Bodies,
    no_bodies,
    pose_at,
    poses_at,
)
from gcm_learn.scene.laws import bodies_later, integrate_swing, later
from gcm_learn.scene.outlines import outline
from gcm_learn.scene.packing import AimedLimits, JointLimits, Limits, Scene, pack, pack_bodies, pose
from gcm_learn.scene.shapes.choice import entry_of, gap

__all__ = [
    "ACCELERATION",
    "BALL",
    "AimedLimits",
    "Bodies",
    "COLUMNS",
    "HAND",
    "LIMB",
    "Limits",
    "PART",
    "POSITION",
    "SIZE",
    "SWING",
    "Scene",
    "JointLimits",
    "TOP_SPEED",
    "VELOCITY",
    "bodies_later",
    "entry_of",
    "gap",
    "integrate_swing",
    "later",
    "no_bodies",
    "outline",
    "pack",
    "pack_bodies",
    "pose",
    "pose_at",
    "poses_at",
]
