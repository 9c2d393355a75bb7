"""Engines by the kind of arm: the only file of this folder that asks which kind it has."""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from gcm_learn.arms import CHAIN, PLANAR, SPATIAL, ByKind
from gcm_learn.charts import Chart
from gcm_learn.motion import fastest_hand
from gcm_learn.scene import Scene
from gcm_learn.wave import causal
from gcm_learn.wave.front import Front
from gcm_learn.wave.limits import fastest_in_plane
from gcm_learn.wave.params import MarchingParams, WaveParams
from gcm_learn.wave.posture_solver import kappa_in_space, kappa_of_hand, propagate_in_space
from gcm_learn.wave.solver import kappa_in_plane, propagate_in_plane
from gcm_learn.wave.waiting import propagate_layers_in_plane


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
        """Return the front."""


_FASTEST: ByKind[Any] = ByKind(
    {PLANAR: fastest_in_plane, SPATIAL: fastest_hand, CHAIN: fastest_hand}, who="a front"
)
_KAPPA: ByKind[Any] = ByKind(
    {PLANAR: kappa_in_plane, SPATIAL: kappa_in_space, CHAIN: kappa_of_hand}, who="a wave"
)
_MARCHING: ByKind[Engine] = ByKind(
    {
        PLANAR: causal.march_in_plane,
        SPATIAL: causal.march_in_space,
        CHAIN: causal.march_in_space,
    },
    who="marching",
)
_PATIENT_MARCHING: ByKind[Engine] = ByKind(
    {PLANAR: causal.march_layers_in_plane, SPATIAL: causal.march_layers_in_space},
    who="marching that may wait",
)
_WAVE: ByKind[Engine] = ByKind(
    {PLANAR: propagate_in_plane, SPATIAL: propagate_in_space}, who="a wave"
)
_PATIENT_WAVE: ByKind[Engine] = ByKind(
    {PLANAR: propagate_layers_in_plane}, who="a wave that may wait"
)


def engine_of(subject: Any, params: WaveParams | MarchingParams, wait: bool) -> Engine:
    """Return the engine for a kind of arm.

    Parameters
    ----------
    subject : Situation, Scene or Kind
        A kind of arm, or what has an arm.
    params : WaveParams or MarchingParams
        Their class chooses between the wave and marching.
    wait : bool
        The hand may wait.

    Raises
    ------
    ArmKindError
        If there is no such engine for arms of this kind.
    """
    if isinstance(params, MarchingParams):
        return (_PATIENT_MARCHING if wait else _MARCHING).of(subject)
    return (_PATIENT_WAVE if wait else _WAVE).of(subject)


def fastest(scene: Scene) -> float:
    """Speed that the hand nowhere exceeds, so that of the front [lengths/s]."""
    return float(_FASTEST.of(scene)(scene))


def kappa_of(scene: Scene, chart: Chart, params: WaveParams) -> float:
    """Seconds per unit of mental time, such that a free front does not outrun the hand."""
    return float(_KAPPA.of(chart.kind)(scene, chart, params))


def march(
    scene: Scene,
    chart: Chart,
    params: MarchingParams,
    *,
    ignore: float = 0.0,
    widening: np.ndarray | None = None,
) -> Front:
    """Map arrivals of a front at hand speed by causal marching; the meaning is the wave's.

    Parameters
    ----------
    scene : Scene
    chart : Chart
        A chart of ``params.n`` cells a side. In space the limb must be free on every step, so that
        there is no lookback, and the margin counts in halves of what a step moves it.
    params : MarchingParams
    ignore : float
        Contacts before this time do not count [s].
    widening : (nodes,) ndarray, optional
        Margin of every node beyond that of the parameters, in the same unit.

    Returns
    -------
    Front
        A front of one sheet.
    """
    return _MARCHING.of(chart.kind)(scene, chart, params, ignore=ignore, widening=widening)


def march_layers(
    scene: Scene,
    chart: Chart,
    params: MarchingParams,
    *,
    ignore: float = 0.0,
    widening: np.ndarray | None = None,
) -> Front:
    """March over nodes and safe intervals until a contact; the hand may wait.

    Parameters
    ----------
    params : MarchingParams
        Until contact only states from which a target may still be met are kept, and nothing after
        the contact; until the horizon all are.

    The others and what is returned are as for `march`.
    """
    engine = _PATIENT_MARCHING.of(chart.kind)
    return engine(scene, chart, params, ignore=ignore, widening=widening)


def propagate(
    scene: Scene,
    chart: Chart,
    params: WaveParams,
    *,
    ignore: float = 0.0,
    widening: np.ndarray | None = None,
) -> Front:
    """Run the wave of Eq. 10 from the hand until contact, the end of hand-space or the horizon.

    Parameters
    ----------
    chart : Chart
        A chart of ``params.n`` cells a side, with one posture in a cell.
    params : WaveParams

    The others and what is returned are as for `march`.
    """
    return _WAVE.of(chart.kind)(scene, chart, params, ignore=ignore, widening=widening)


def propagate_layers(
    scene: Scene,
    chart: Chart,
    params: WaveParams,
    *,
    ignore: float = 0.0,
    widening: np.ndarray | None = None,
) -> Front:
    """Run the wave of Eq. 10 until a contact or the horizon; the hand may wait.

    A cell is excited as long as the hand can be there: obstacles inhibit it while they are there.

    Parameters
    ----------
    params : WaveParams
        `frozen` says how an inhibited cell acts on its neighbours: "insulating" cuts its
        couplings, "held" leaves it to be seen, clamped at rest.

    The others and what is returned are as for `march`.
    """
    engine = _PATIENT_WAVE.of(chart.kind)
    return engine(scene, chart, params, ignore=ignore, widening=widening)
