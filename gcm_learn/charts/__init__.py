"""Hand-space: its charts, and what obstacles are in it."""

from gcm_learn.charts.chart import SMALLEST_LATTICE, Chart
from gcm_learn.charts.clearances import cell_clearances
from gcm_learn.charts.cube import LARGEST_POSTURE_LATTICE, Cube
from gcm_learn.charts.extended import extended_obstacle, occupied_cells
from gcm_learn.charts.hand_lattice import HandLattice, PulledNodes, hand_lattice_of
from gcm_learn.charts.kinds import chart_of, lattice_of
from gcm_learn.charts.lattice import (
    LARGEST_LATTICE,
    START_RADIUS,
    Lattice,
    cell_joints,
    hand_space,
)
from gcm_learn.charts.posture_lattice import (
    MOST_POSTURES,
    Nodes,
    PostureLattice,
    posture_lattice_of,
    ring_leap,
)

__all__ = [
    "Chart",
    "Cube",
    "HandLattice",
    "LARGEST_POSTURE_LATTICE",
    "LARGEST_LATTICE",
    "Lattice",
    "MOST_POSTURES",
    "SMALLEST_LATTICE",
    "START_RADIUS",
    "Nodes",
    "PostureLattice",
    "PulledNodes",
    "cell_joints",
    "chart_of",
    "extended_obstacle",
    "hand_lattice_of",
    "hand_space",
    "lattice_of",
    "occupied_cells",
    "ring_leap",
    "cell_clearances",
    "posture_lattice_of",
]
