"""What a scene and a chart say about a front: how fast it is, and what occupies a cell."""

from __future__ import annotations

import numpy as np

from gcm_learn.arms import SpatialLimb, joints_of
from gcm_learn.collision import Postures, postures_of
from gcm_learn.handspace import Chart, Lattice, SpaceLattice, cell_joints, hand_space
from gcm_learn.motion import fastest_hand
from gcm_learn.scene import Scene
from gcm_learn.wave.kernels import Terms
from gcm_learn.wave.params import MarchingParams, WaveParams

CONTACT_RADIUS = 0.71  # at least half a cell's diagonal, or a small target slips between centres
CONTACT_RADIUS_IN_SPACE = 0.87  # the same of a cube


def fastest(scene: Scene) -> float:
    """Speed that the hand nowhere exceeds, so that of the front [forearm lengths / s]."""
    limits = scene.limits
    if isinstance(scene.limb, SpatialLimb):
        return float(fastest_hand(scene))
    return min(limits.speed, (scene.limb.rho + 1.0) * limits.shoulder + limits.elbow)


def hand_of(scene: Scene) -> tuple[float, float]:
    """Where the front starts [forearm lengths]."""
    return scene.limb.x, scene.limb.y


def contact_distance(scene: Scene, chart: Chart, params: WaveParams | MarchingParams) -> float:
    """Distance of a cell's centre and a target at which they are in contact."""
    h, radius = chart.spacing, CONTACT_RADIUS
    if isinstance(chart, SpaceLattice):
        radius = CONTACT_RADIUS_IN_SPACE
    return max(scene.limits.grasp + params.slack * h, radius * h)


def gaps(
    scene: Scene, stride: np.ndarray, margin: float, widening: np.ndarray | None
) -> np.ndarray:
    """Distance (m,) at which an obstacle occupies a cell [forearm lengths].

    Parameters
    ----------
    stride : (m,) ndarray
        What half a cell's step moves the limb.
    margin : float
        That of the front's parameters, in strides.
    widening : (m,) ndarray, optional
        Margin of every cell beyond that.
    """
    wide = margin if widening is None else margin + widening
    return scene.limb.thickness + wide * stride


def postures(
    scene: Scene, lattice: Lattice, margin: float, widening: np.ndarray | None
) -> Postures:
    """The limbs with their hands in the cells of a lattice."""
    space = hand_space(lattice)
    return postures_of(scene.bodies, space.limb, gaps(scene, space.stride, margin, widening))


def terms_of(
    scene: Scene, chart: Chart, params: WaveParams | MarchingParams, kappa: float, ignore: float
) -> Terms:
    """What counts for a front whose unit of time is kappa seconds; `ignore` [s]."""
    return Terms(
        kappa=kappa,
        shortest=(params.step if isinstance(params, WaveParams) else 0.03) * kappa,
        grasp=contact_distance(scene, chart, params),
        ignore=ignore / kappa,
        end=scene.limits.horizon / kappa,
        explore=params.until == "horizon",
        lookback=1.0 if isinstance(params, WaveParams) else params.lookback,
        speed=fastest(scene),
    )


def turns_of(scene: Scene, lattice: Lattice) -> tuple[np.ndarray, float]:
    """Joint angles in every cell, then the hand's (n * n + 1, 2), and a shoulder's full turn.

    As times that it takes to turn so far, in crossings of a cell at the fastest speed; no rows
    if the joints are not limited.
    """
    limits, limb = scene.limits, scene.limb
    unit = np.array([limits.shoulder, limits.elbow]) * lattice.spacing / fastest(scene)
    if unit.min() >= 2.0 * np.pi:  # no turn takes longer than the hand to the next cell
        return np.empty((0, 2)), 1.0
    hand = joints_of(np.array([[limb.x, limb.y]]), limb.rho, limb.side)
    joints = np.vstack([cell_joints(lattice), hand])
    return joints / unit, float(2.0 * np.pi / unit[0])
