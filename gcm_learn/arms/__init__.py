"""Arms: records, kinematics, and the registry of their kinds."""

from typing import TYPE_CHECKING

from gcm_learn.arms.chain import (
    JOINT_TYPES,
    Chain,
    ChainJoint,
    ChainModel,
    Hand,
    Link,
    unknown_obstacle,
)
from gcm_learn.arms.chain_limb import ChainLimb, limb_of_chain
from gcm_learn.arms.followers import Follows
from gcm_learn.arms.kinds import (
    CHAIN,
    PLANAR,
    SPATIAL,
    ByKind,
    Kind,
    is_arm,
    kind_named,
    kind_of,
    kinds,
    register_kind,
    solution_format,
)
from gcm_learn.arms.kinematics import hand_speed, hands_along, links_along, off_segment
from gcm_learn.arms.planar import ELBOWS, Arm
from gcm_learn.arms.planar_limb import (
    SIDE,
    PlanarLimb,
    elbow_of,
    elbow_position,
    forward,
    joint_angles,
    joints_of,
    planar_limb_of,
)
from gcm_learn.arms.rotations import (
    quaternion_of,
    rotation_of,
    rotations_of,
    turned_by,
    unit_quaternion,
)
from gcm_learn.arms.spatial import IDENTITY, JOINTS, OTHER_ARMS, Base, SpatialArm
from gcm_learn.arms.spatial_limb import SpatialLimb, forward_in_space, spatial_limb_of
from gcm_learn.arms.swivels import inverse_in_space, swivel_in_space
from gcm_learn.late import late_names

if TYPE_CHECKING:
    from gcm_learn.arms.robots import (
        Fitted,
        Inertial,
        Robot,
        chain_of,
        frames_at,
        read_robot,
    )

__all__ = [
    "Arm",
    "Base",
    "ByKind",
    "CHAIN",
    "Chain",
    "ChainJoint",
    "ChainLimb",
    "ChainModel",
    "ELBOWS",
    "Fitted",
    "Follows",
    "Hand",
    "IDENTITY",
    "Inertial",
    "JOINTS",
    "JOINT_TYPES",
    "Kind",
    "Link",
    "OTHER_ARMS",
    "PLANAR",
    "PlanarLimb",
    "Robot",
    "SIDE",
    "SPATIAL",
    "SpatialArm",
    "SpatialLimb",
    "chain_of",
    "elbow_of",
    "elbow_position",
    "forward",
    "forward_in_space",
    "frames_at",
    "hand_speed",
    "hands_along",
    "inverse_in_space",
    "is_arm",
    "joint_angles",
    "joints_of",
    "kind_named",
    "kind_of",
    "kinds",
    "limb_of_chain",
    "links_along",
    "off_segment",
    "planar_limb_of",
    "quaternion_of",
    "read_robot",
    "register_kind",
    "rotation_of",
    "rotations_of",
    "solution_format",
    "spatial_limb_of",
    "swivel_in_space",
    "turned_by",
    "unit_quaternion",
    "unknown_obstacle",
]


__getattr__ = late_names(
    __name__,
    {
        "robots": (
            "Fitted",
            "Inertial",
            "Robot",
            "chain_of",
            "frames_at",
            "read_robot",
        ),
    },
)
