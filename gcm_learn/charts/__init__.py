"""Charts of hand-space, clearances of their cells, and obstacles extended into hand-space."""

from gcm_learn.charts.chart import SMALLEST_LATTICE as SMALLEST_LATTICE, Chart as Chart
from gcm_learn.charts.clearances import cell_clearances as cell_clearances
from gcm_learn.charts.extended import (
    extended_obstacle as extended_obstacle,
    occupied_cells as occupied_cells,
)
from gcm_learn.charts.hand_lattice import (
    LARGEST_HAND_LATTICE as LARGEST_HAND_LATTICE,
    HandLattice as HandLattice,
    Nodes as Nodes,
)
from gcm_learn.charts.kinds import chart_of as chart_of, lattice_of as lattice_of
from gcm_learn.charts.lattice import (
    LARGEST_LATTICE as LARGEST_LATTICE,
    START_RADIUS as START_RADIUS,
    Lattice as Lattice,
    cell_joints as cell_joints,
    hand_space as hand_space,
)
