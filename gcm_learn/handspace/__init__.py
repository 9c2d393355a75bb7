"""Hand-space: its charts, and what obstacles are in it."""

from gcm_learn.handspace.chart import SMALLEST_LATTICE, Chart
from gcm_learn.handspace.extended import extended_obstacle, upper_arm_image
from gcm_learn.handspace.joints import JointLattice, joint_lattice
from gcm_learn.handspace.kinds import chart_of, lattice_of
from gcm_learn.handspace.lattice import (
    LARGEST_LATTICE,
    START_RADIUS,
    Lattice,
    cell_joints,
    hand_space,
)
from gcm_learn.handspace.occupied import occupied_cells
from gcm_learn.handspace.room import room_in_space
from gcm_learn.handspace.space import (
    LARGEST_IN_SPACE,
    MOST_POSTURES,
    SpaceLattice,
    ring_leap,
    space_of,
)

__all__ = [
    "Chart",
    "LARGEST_IN_SPACE",
    "JointLattice",
    "LARGEST_LATTICE",
    "Lattice",
    "MOST_POSTURES",
    "SMALLEST_LATTICE",
    "START_RADIUS",
    "SpaceLattice",
    "cell_joints",
    "chart_of",
    "extended_obstacle",
    "hand_space",
    "joint_lattice",
    "lattice_of",
    "occupied_cells",
    "ring_leap",
    "room_in_space",
    "space_of",
    "upper_arm_image",
]
