"""Arms: records, kinematics, and the registry of their kinds."""

from typing import TYPE_CHECKING

from gcm_learn import late
from gcm_learn.arms.chain import FROM_MODEL as FROM_MODEL, Chain as Chain
from gcm_learn.arms.chain_limb import ChainLimb as ChainLimb, limb_of_chain as limb_of_chain
from gcm_learn.arms.chain_model import (
    JOINT_TYPES as JOINT_TYPES,
    ChainJoint as ChainJoint,
    ChainModel as ChainModel,
    Hand as Hand,
    Link as Link,
)
from gcm_learn.arms.followers import Follows as Follows
from gcm_learn.arms.kinds import (
    CHAIN as CHAIN,
    PLANAR as PLANAR,
    SPATIAL as SPATIAL,
    ByKind as ByKind,
    Kind as Kind,
    check_kind as check_kind,
    is_arm as is_arm,
    kind_named as kind_named,
    kind_of as kind_of,
    kinds as kinds,
    register_kind as register_kind,
    solution_format as solution_format,
)
from gcm_learn.arms.kinematics import (
    forward_in_space as forward_in_space,
    hand_frame as hand_frame,
    hand_speed as hand_speed,
    hands_along as hands_along,
    links_along as links_along,
    off_segment as off_segment,
)
from gcm_learn.arms.planar import ELBOWS as ELBOWS, Arm as Arm
from gcm_learn.arms.planar_limb import (
    SIDE as SIDE,
    PlanarLimb as PlanarLimb,
    elbow_of as elbow_of,
    elbow_position as elbow_position,
    forward as forward,
    joint_angles as joint_angles,
    joints_of as joints_of,
    planar_limb_of as planar_limb_of,
)
from gcm_learn.arms.rotations import (
    IDENTITY as IDENTITY,
    Base as Base,
    quaternion_of as quaternion_of,
    rotation_of as rotation_of,
    rotations_of as rotations_of,
    turned_by as turned_by,
    unit_quaternion as unit_quaternion,
)
from gcm_learn.arms.spatial import (
    AXES as AXES,
    JOINTS as JOINTS,
    OTHER_ARMS as OTHER_ARMS,
    SpatialArm as SpatialArm,
)
from gcm_learn.arms.spatial_limb import (
    inverse_in_space as inverse_in_space,
    spatial_limb_of as spatial_limb_of,
    swivel_in_space as swivel_in_space,
)

if TYPE_CHECKING:
    from gcm_learn.arms.robots import (
        Fitted as Fitted,
        Inertial as Inertial,
        Robot as Robot,
        chain_of as chain_of,
        frames_at as frames_at,
        read_robot as read_robot,
    )


__getattr__ = late.late_names(
    __name__, {"robots": ("Fitted", "Inertial", "Robot", "chain_of", "frames_at", "read_robot")}
)
