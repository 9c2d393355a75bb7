"""The body: kinematics, hand-space and the clearance of movements."""

from gcm_learn.arm.clearance import clearance
from gcm_learn.arm.extended import extended_obstacle, extended_outline, upper_arm_image
from gcm_learn.arm.kinematics import elbow_position, forward, joint_angles
from gcm_learn.arm.lattice import Lattice
from gcm_learn.arm.occupancy import occupied_cells
from gcm_learn.arm.trajectory import Trajectory

__all__ = [
    "Lattice",
    "Trajectory",
    "clearance",
    "elbow_position",
    "extended_obstacle",
    "extended_outline",
    "forward",
    "joint_angles",
    "occupied_cells",
    "upper_arm_image",
]
