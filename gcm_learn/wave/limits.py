"""Speed and terms of a front, and the limbs over a lattice of the plane."""

from __future__ import annotations

import numpy as np

from gcm_learn.arms import joints_of
from gcm_learn.charts import Chart, Lattice, cell_joints, hand_space
from gcm_learn.collision import Postures, postures_of
from gcm_learn.scene import Scene
from gcm_learn.wave.kernels import Terms
from gcm_learn.wave.params import MarchingParams, WaveParams, WaveRun


def fastest_in_plane(scene: Scene) -> float:
    """Bound of the speed of a planar arm's hand, and so that of the front [forearm lengths / s]."""
    limits = scene.limits
    return min(limits.speed, (scene.limb.rho + 1.0) * limits.shoulder + limits.elbow)


def hand_of(scene: Scene) -> tuple[float, float]:
    """Hand at t = 0, where the front starts [forearm lengths]."""
    return scene.limb.x, scene.limb.y


def contact_distance(scene: Scene, chart: Chart, params: WaveParams | MarchingParams) -> float:
    """Distance of a cell's centre and a target at which they are in contact.

    It is at least half a cell's diagonal, or a small target would slip between the centres.
    """
    h = chart.spacing
    return max(scene.limits.grasp + params.slack * h, chart.half_diagonal * h)


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
    """Bind the limbs with their hands in the cells of a lattice."""
    space = hand_space(lattice)
    return postures_of(scene.bodies, space.limb, gaps(scene, space.stride, margin, widening))


def terms_of(
    scene: Scene,
    chart: Chart,
    params: WaveParams | MarchingParams,
    kappa: float,
    ignore: float,
    speed: float,
) -> Terms:
    """Bind the terms of a front whose unit of time is kappa seconds.

    Parameters
    ----------
    ignore : float
        Contacts before this time do not count [s].
    speed : float
        Speed of the front where it is fastest [lengths/s].
    """
    return Terms(
        kappa=kappa,
        shortest=(params.step if isinstance(params, WaveParams) else 0.03) * kappa,
        grasp=contact_distance(scene, chart, params),
        ignore=ignore / kappa,
        end=scene.limits.horizon / kappa,
        explore=params.until == "horizon",
        lookback=1.0 if isinstance(params, WaveParams) else params.lookback,
        speed=speed,
    )


def run_of(params: WaveParams, quiet: float, slowness: float) -> WaveRun:
    """Bind the numbers by which a wave is run.

    Parameters
    ----------
    quiet : float
        Change of a potential below which a block of cells counts as settled [1/tau].
    slowness : float
        Inverse speed of the fastest front [tau per cell].
    """
    return WaveRun(
        held=params.frozen == "held",
        diffusion=params.diffusion,
        epsilon=params.epsilon,
        quiet=quiet,
        step=params.step,
        lag=2 * max(1, int(0.6 / params.step + 1e-9)) * params.step,
        slowness=slowness,
        threshold=params.threshold,
    )


def turns_of(scene: Scene, lattice: Lattice) -> tuple[np.ndarray, float]:
    """Joint angles in every cell, then the hand's (n * n + 1, 2), and a shoulder's full turn.

    They count as times of turning, in crossings of a cell at the fastest speed.  Joints without
    limits have no rows.
    """
    limits, limb = scene.limits, scene.limb
    unit = np.array([limits.shoulder, limits.elbow]) * lattice.spacing / fastest_in_plane(scene)
    if unit.min() >= 2.0 * np.pi:  # no turn takes longer than the hand to the next cell
        return np.empty((0, 2)), 1.0
    hand = joints_of(np.array([[limb.x, limb.y]]), limb.rho, limb.side)
    joints = np.vstack([cell_joints(lattice), hand])
    return joints / unit, float(2.0 * np.pi / unit[0])
