"""Extended obstacles as curves (Eqs. 4-9): images of the world's points in hand-space.

Planning tests single cells instead (`collision.occupancy`); curves serve figures and check that.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from gcm_learn.arms import SIDE
from gcm_learn.charts.lattice import Lattice, hand_space
from gcm_learn.collision import blocked_cells, postures_of
from gcm_learn.scene import pack_bodies, poses_at
from gcm_learn.situation import Situation


def reach_angle(point: ArrayLike, upper_arm: float = 1.0) -> float:
    """Return phi_max of Eq. 5, with the argument of the arccos clipped (erratum 2).

    Parameters
    ----------
    point : (2,) array_like
        Point obstacle [forearm lengths].

    Returns
    -------
    float
        Largest angle between upper arm and point at which the forearm can still touch it [rad].
    """
    r = float(np.hypot(*np.asarray(point, dtype=float)))
    cosine = (upper_arm**2 + r * r - 1.0) / (2.0 * upper_arm * r)
    return float(np.arccos(np.clip(cosine, -1.0, 1.0)))


def extended_obstacle(
    point: ArrayLike, upper_arm: float = 1.0, elbow: str = "right", n: int = 64
) -> np.ndarray:
    """Image of a point under the forearm: E(x) of Eq. 9, sampled.

    Parameters
    ----------
    point : (2,) array_like
        Point obstacle with 0 < |x| < upper_arm + 1; |x| = upper_arm is singular (erratum 4).
    upper_arm : float
        rho.
    elbow : {"right", "left"}
        "right" is the paper's arm, phi in [-phi_max, 0] (erratum 3); "left" is its mirror image.
    n : int
        Number of samples.

    Returns
    -------
    (n, 2) ndarray
        Hand positions at which the forearm touches the point, from the point itself outwards (to
        (rho + 1) x/|x|, or to (rho - 1) x/|x| for a point within the upper arm's reach).
    """
    x = np.asarray(point, dtype=float)
    r = float(np.hypot(*x))
    phi = np.linspace(-reach_angle(x, upper_arm), 0.0, n)
    # Eq. 4 with erratum 1: the distance of elbow and obstacle is |x_e - x|.
    distance = np.sqrt(np.maximum(upper_arm**2 + r * r - 2.0 * upper_arm * r * np.cos(phi), 1e-18))[
        :, None
    ]
    side = SIDE[elbow]
    turned = np.stack([np.cos(phi), side * np.sin(phi)], axis=-1)
    rotation = np.array([[x[0], -x[1]], [x[1], x[0]]]) / r  # Eq. 7
    return x / distance - upper_arm * (1.0 / distance - 1.0) * turned @ rotation.T  # Eq. 8


def occupied_cells(situation: Situation, lattice: Lattice, t: float) -> np.ndarray:
    """Mark the cells in which the limb touches an obstacle at time t (Gamma of Eq. 11).

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
