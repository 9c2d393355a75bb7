"""A situation compiled: bodies and limb as arrays, their poses, bounds of their motion."""

from gcm_learn.scene.bodies import (
    ACCELERATION as ACCELERATION,
    BALL as BALL,
    COLUMNS as COLUMNS,
    HAND as HAND,
    LIMB as LIMB,
    PART as PART,
    POSITION as POSITION,
    SIZE as SIZE,
    SWING as SWING,
    TOP_SPEED as TOP_SPEED,
    VELOCITY as VELOCITY,
    Bodies as Bodies,
    no_bodies as no_bodies,
    pose_at as pose_at,
    poses_at as poses_at,
)
from gcm_learn.scene.laws import (
    bodies_later as bodies_later,
    integrate_swing as integrate_swing,
    later as later,
)
from gcm_learn.scene.outlines import outline as outline
from gcm_learn.scene.packing import (
    JointLimits as JointLimits,
    Limits as Limits,
    Scene as Scene,
    pack as pack,
    pack_bodies as pack_bodies,
    pose as pose,
)
from gcm_learn.scene.shapes.choice import entry_of as entry_of, gap as gap
