"""Distances of obstacles and limb, in the postures that a front found."""

from __future__ import annotations

from typing import Any

import numpy as np

from gcm_learn.charts.hand_lattice import HandLattice
from gcm_learn.collision.postures import Desk, desk_of, distance_at
from gcm_learn.compiled import njit
from gcm_learn.scene import Scene, pack
from gcm_learn.situation import Situation


def cell_clearances(
    situation: Situation[Any], lattice: HandLattice, t: float, joints: np.ndarray
) -> np.ndarray:
    """Clearance of the limb in every cell's posture at time t.

    Parameters
    ----------
    situation : Situation
    lattice : HandLattice
        Of its arm.
    t : float
        Time [s].
    joints : (nodes, dof) ndarray
        Postures that a front found, NaN where it never came.

    Returns
    -------
    (n, n, n) ndarray
        In the lattice's shape: distance of the nearest obstacle less the limb's thickness, negative
        where they touch; infinite where there is no posture.
    """
    scene, out = pack(situation), np.full(lattice.size, np.inf)
    _rooms(scene, joints, np.flatnonzero(np.isfinite(joints[:, 0])), t, desk_of(scene), out)
    return out.reshape(lattice.shape) - situation.arm.thickness


@njit(_nrt=False)
def _rooms(
    scene: Scene, joints: np.ndarray, cells: np.ndarray, t: float, desk: Desk, out: np.ndarray
) -> None:
    for k in range(cells.size):
        out[cells[k]] = distance_at(scene, joints[cells[k]], t, desk)
