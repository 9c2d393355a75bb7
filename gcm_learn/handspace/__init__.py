"""Hand-space: its charts, and what obstacles are in it."""

from gcm_learn.handspace.chart import Chart, Steps
from gcm_learn.handspace.extended import extended_obstacle, extended_outline, upper_arm_image
from gcm_learn.handspace.lattice import LARGEST_LATTICE, Lattice, hand_space
from gcm_learn.handspace.occupied import occupied_cells

__all__ = [
    "Chart",
    "LARGEST_LATTICE",
    "Lattice",
    "Steps",
    "extended_obstacle",
    "extended_outline",
    "hand_space",
    "occupied_cells",
    "upper_arm_image",
]
