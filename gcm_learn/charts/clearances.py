"""Distances of obstacles and limb, in every posture of a lattice in space."""

from __future__ import annotations

from typing import Any

import numpy as np

from gcm_learn.charts.cube import Cube
from gcm_learn.collision.postures import Desk, desk_of, distance_at
from gcm_learn.compiled import njit
from gcm_learn.scene import Scene, pack
from gcm_learn.situation import Situation


def cell_clearances(
    situation: Situation[Any], lattice: Cube, t: float, joints: np.ndarray | None = None
) -> np.ndarray:
    """Clearance of the limb in every cell's posture at time t.

    Parameters
    ----------
    situation : Situation
    lattice : Cube
        Of its arm.
    t : float
        Time [s].
    joints : (nodes, dof) ndarray, optional
        Postures that a front found, NaN where it never came; by default those of a rule.

    Returns
    -------
    (n, n, n) ndarray
        In the lattice's shape: distance of the nearest obstacle less the limb's thickness, negative
        where they touch; infinite where there is no posture.
    """
    scene, out = pack(situation), np.full(lattice.size, np.inf)
    chart: Any = lattice
    there = chart.inside if joints is None else np.isfinite(joints[:, 0])
    found = chart.joints.astype(float) if joints is None else joints
    _rooms(scene, found, np.flatnonzero(there), t, desk_of(scene), out)
    return out.reshape(lattice.shape) - situation.arm.thickness


@njit(_nrt=False)
def _rooms(
    scene: Scene, joints: np.ndarray, cells: np.ndarray, t: float, desk: Desk, out: np.ndarray
) -> None:
    for k in range(cells.size):
        out[cells[k]] = distance_at(scene, joints[cells[k]], t, desk)
