"""Extended obstacles as sets of cells."""

from __future__ import annotations

import numpy as np

from gcm_learn.charts.lattice import Lattice, hand_space
from gcm_learn.collision import blocked_cells, postures_of
from gcm_learn.scene import pack_bodies, poses_at
from gcm_learn.situation import Situation


def occupied_cells(situation: Situation, lattice: Lattice, t: float) -> np.ndarray:
    """Cells whose hand position makes the limb touch an obstacle at time t (Gamma of Eq. 11).

    Parameters
    ----------
    situation : Situation
    lattice : Lattice
        Its upper arm and elbow side are those of the limb that is tested.
    t : float
        Time [s].

    Returns
    -------
    (n, n) bool ndarray
        Indexed [iy, ix]; False outside the reachable ring.
    """
    space = hand_space(lattice)
    gap = np.full(space.inside.size, situation.arm.thickness)
    postures = postures_of(pack_bodies(situation), space.limb, gap)
    poses_at(postures.bodies, t, postures.poses)
    cells = np.flatnonzero(space.inside)
    blocked = np.empty(cells.size, dtype=np.bool_)
    blocked_cells(postures, cells, np.full(cells.size, t), cells.size, t, 1.0, blocked)
    occupied = np.zeros(space.inside.size, dtype=np.bool_)
    occupied[cells] = blocked
    return occupied.reshape(lattice.n, lattice.n)
