"""Hand-space: its lattice, and what obstacles are in it."""

from gcm_learn.handspace.extended import extended_obstacle, extended_outline, upper_arm_image
from gcm_learn.handspace.lattice import Lattice
from gcm_learn.handspace.occupied import occupied_cells

__all__ = ["Lattice", "extended_obstacle", "extended_outline", "occupied_cells", "upper_arm_image"]
