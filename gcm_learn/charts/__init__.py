"""Hand-space: its charts, and what obstacles are in it."""

from gcm_learn.charts.chart import SMALLEST_LATTICE as SMALLEST_LATTICE, Chart as Chart
from gcm_learn.charts.clearances import cell_clearances as cell_clearances
from gcm_learn.charts.cube import LARGEST_POSTURE_LATTICE as LARGEST_POSTURE_LATTICE, Cube as Cube
from gcm_learn.charts.extended import (
    extended_obstacle as extended_obstacle,
    occupied_cells as occupied_cells,
)
from gcm_learn.charts.hand_lattice import (
    HandLattice as HandLattice,
    PulledNodes as PulledNodes,
    hand_lattice_of as hand_lattice_of,
)
from gcm_learn.charts.kinds import chart_of as chart_of, lattice_of as lattice_of
from gcm_learn.charts.lattice import (
    LARGEST_LATTICE as LARGEST_LATTICE,
    START_RADIUS as START_RADIUS,
    Lattice as Lattice,
    cell_joints as cell_joints,
    hand_space as hand_space,
)
from gcm_learn.charts.posture_lattice import (
    MOST_POSTURES as MOST_POSTURES,
    Nodes as Nodes,
    PostureLattice as PostureLattice,
    posture_lattice_of as posture_lattice_of,
    ring_leap as ring_leap,
)
