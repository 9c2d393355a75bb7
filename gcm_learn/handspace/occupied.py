"""Extended obstacles as sets of cells."""

from __future__ import annotations

import numpy as np

from gcm_learn.collision.occupancy import blocked_cells
from gcm_learn.handspace.lattice import Lattice, hand_space
from gcm_learn.scene.bodies import poses_at
from gcm_learn.scene.packing import pack_bodies
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
    bodies = pack_bodies(situation)
    poses = np.zeros((len(situation.bodies), 12))
    poses_at(bodies, t, poses)
    space = hand_space(lattice)
    cells = np.flatnonzero(space.inside)
    gap = np.full(space.inside.size, situation.arm.thickness)
    blocked = np.empty(cells.size, dtype=np.bool_)
    since = np.full(cells.size, t)
    blocked_cells(
        bodies, poses, space.limb, gap, cells, since, cells.size, t, 1.0, blocked, poses.copy()
    )
    occupied = np.zeros(space.inside.size, dtype=np.bool_)
    occupied[cells] = blocked
    return occupied.reshape(lattice.n, lattice.n)
