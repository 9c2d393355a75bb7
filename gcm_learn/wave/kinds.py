"""Engines by the kind of arm; no other file of this folder branches on the kind."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from gcm_learn.arms import PLANAR, ByKind
from gcm_learn.charts import Chart
from gcm_learn.errors import LatticeError
from gcm_learn.motion import fastest_hand
from gcm_learn.scene import Scene
from gcm_learn.wave import causal
from gcm_learn.wave.front import Front
from gcm_learn.wave.limits import fastest_in_plane
from gcm_learn.wave.params import MarchingParams, WaveParams
from gcm_learn.wave.solver import front_speed, propagate_in_plane


class Engine(Protocol):
    """A function that lets a front spread over a chart."""

    def __call__(
        self,
        scene: Scene,
        chart: Any,
        params: Any,
        /,
        *,
        ignore: float = 0.0,
        widening: np.ndarray | None = None,
    ) -> Front:
        """Return the front.

        Parameters
        ----------
        scene : Scene
        chart : Chart
            A chart of ``params.n`` cells a side. In space the limb must be free on every step, so
            that there is no lookback, and the margin counts in halves of what a step moves it.
        params : WaveParams or MarchingParams
            A front that may wait and stops at its contact keeps only states from which a target
            may still be met.
        ignore : float
            Contacts before this time do not count [s].
        widening : (nodes,) ndarray, optional
            Margin of every node beyond that of the parameters, in the same unit.
        """


_FASTEST: ByKind[Any] = ByKind({PLANAR: fastest_in_plane}, default=fastest_hand)
_WAVE: ByKind[Engine] = ByKind({PLANAR: propagate_in_plane}, who="a wave")
_MARCHING: ByKind[Engine] = ByKind({PLANAR: causal.march_in_plane}, default=causal.march_in_space)
_PATIENT: ByKind[Engine] = ByKind(
    {PLANAR: causal.march_layers_in_plane}, who="marching that may wait"
)


def engine_of(subject: Any, params: WaveParams | MarchingParams, wait: bool = False) -> Engine:
    """Return the engine for a kind of arm.

    Parameters
    ----------
    subject : Situation, Scene or Kind
        A kind of arm, or what has an arm.
    params : WaveParams or MarchingParams
        Their class chooses between the wave of Eq. 10 and marching.
    wait : bool
        The hand may wait.

    Raises
    ------
    ArmKindError
        If there is no such engine for arms of this kind.
    LatticeError
        If a wave is to wait.
    """
    if isinstance(params, MarchingParams):
        return (_PATIENT if wait else _MARCHING).of(subject)
    if wait:
        raise LatticeError("wait: a wave freezes for ever what it meets; take MarchingParams")
    return _WAVE.of(subject)


def fastest(scene: Scene) -> float:
    """Speed that the hand nowhere exceeds, so that of the front [lengths/s]."""
    return float(_FASTEST.of(scene)(scene))


def kappa_of(scene: Scene, chart: Chart, params: WaveParams) -> float:
    """Seconds per unit of mental time, such that a free front does not outrun the hand.

    At the paper's setting (80 cells over 4 forearm lengths, d = 0.2) and 3.4 forearm lengths a
    second this is the paper's kappa = 1/400 s.  Arms that move in their joints have no wave: their
    marching fronts are told in the time of one in the plane.
    """
    return front_speed(params).fastest * chart.spacing / fastest(scene)
