"""Distances of obstacles and limb, in every posture of a lattice in space."""

from __future__ import annotations

import numpy as np

from gcm_learn.arms import SpatialArm
from gcm_learn.charts.posture_lattice import PostureLattice
from gcm_learn.collision.postures import Desk, desk_of, distance_at
from gcm_learn.compiled import njit
from gcm_learn.scene import Scene, pack
from gcm_learn.situation import Situation


def cell_clearances(
    situation: Situation[SpatialArm], lattice: PostureLattice, t: float
) -> np.ndarray:
    """Clearance of the limb in every cell's posture at time t.

    Parameters
    ----------
    situation : Situation
    lattice : PostureLattice
        Of its arm.
    t : float
        Time [s].

    Returns
    -------
    (n, n, n) ndarray
        In the lattice's shape: distance of the nearest obstacle less the limb's thickness, negative
        where they touch; infinite where there is no posture.
    """
    scene, out = pack(situation), np.full(lattice.size, np.inf)
    cells = np.flatnonzero(lattice.inside)
    _rooms(scene, lattice.joints.astype(float), cells, t, desk_of(scene), out)
    return out.reshape(lattice.shape) - situation.arm.thickness


@njit(_nrt=False)
def _rooms(
    scene: Scene, joints: np.ndarray, cells: np.ndarray, t: float, desk: Desk, out: np.ndarray
) -> None:
    for k in range(cells.size):
        out[cells[k]] = distance_at(scene, joints[cells[k]], t, desk)
