"""From a situation to its cognitive map, by any engine."""

from __future__ import annotations

import numpy as np

from gcm_learn.charts import Chart, chart_of
from gcm_learn.maps.cognitive_map import CognitiveMap, Interception
from gcm_learn.maps.kinds import MAPS
from gcm_learn.scene import Scene, pack
from gcm_learn.situation import AnySituation
from gcm_learn.wave import Front, MarchingParams, WaveParams, engine_of, kappa_of


def build_map(
    situation: AnySituation,
    params: WaveParams | MarchingParams | None = None,
    *,
    wait: bool = False,
    chart: Chart | None = None,
    scene: Scene | None = None,
    ignore: float = 0.0,
    widening: np.ndarray | None = None,
) -> CognitiveMap:
    """Let a front spread from the hand and keep what it met (Eqs. 10-12).

    Parameters
    ----------
    situation : Situation
    params : WaveParams or MarchingParams, optional
        Their class chooses the engine.  By default the published wave in the plane, and marching
        if the hand may wait, and in space.
    wait : bool
        Whether the hand may wait: then there is a sheet of arrivals for every safe interval.
    chart : Chart, optional
        Where the front can be; the lattice of the arm's hand-space by default.
    scene : Scene, optional
        The situation packed, if the caller has it at hand.
    ignore : float
        Interceptions before this time do not stop the front [s].
    widening : (nodes,) ndarray, optional
        Margin of every node beyond that of `params`, in the same unit.

    Returns
    -------
    CognitiveMap
        Whether the target was met is its `interception`.
    """
    if params is None:
        params = MarchingParams() if wait else MAPS.of(situation).params
    engine = engine_of(situation, params, wait)
    scene = pack(situation) if scene is None else scene
    chart = chart_of(situation, params.n) if chart is None else chart
    front = engine(scene, chart, params, ignore=ignore, widening=widening)
    return map_of(situation, scene, front, params)


def explore(
    scene: Scene,
    chart: Chart,
    params: WaveParams | MarchingParams,
    *,
    wait: bool = False,
    ignore: float = 0.0,
    widening: np.ndarray | None = None,
) -> Front:
    """Let a front spread over a chart; the arguments mean the same as in `build_map`.

    Raises
    ------
    ArmKindError
        If there is no such engine for charts of this kind.
    """
    engine = engine_of(chart.kind, params, wait)
    return engine(scene, chart, params, ignore=ignore, widening=widening)


def map_of(
    situation: AnySituation, scene: Scene, front: Front, params: WaveParams | MarchingParams
) -> CognitiveMap:
    """The map that a front with some parameters has left behind.

    Its effective obstacles are the nodes in which an obstacle was when a front came; where the hand
    may wait these may have arrivals, later ones.
    """
    sheets, masked = front.sheets()
    interception, wave = None, params if isinstance(params, WaveParams) else None
    if front.met_state >= 0:
        node = int(front.nodes[front.met_state])
        interception = Interception(
            cell=tuple(int(i) for i in np.unravel_index(node, front.chart.shape)),
            position=front.chart.hand_at(node),
            time=front.met_time,
            body=situation.bodies[front.met_body].name,
        )
    kind = MAPS.of(front.chart.kind)
    return CognitiveMap(
        chart=front.chart,
        hand=kind.hand(situation.arm, front.chart),
        arrival=np.ma.MaskedArray(sheets[0], mask=masked[0]),
        effective_obstacles=front.refused,
        effective_target=front.met,
        interception=interception,
        kappa=kappa_of(scene, front.chart, wave or WaveParams()),
        engine="layered" if front.waits else "wave" if wave else "marching",
        later=np.ma.MaskedArray(sheets[1:], mask=masked[1:]) if len(sheets) > 1 else None,
        via=None if front.waits or front.via is None else front.via.reshape(front.chart.shape),
        joints=front.joints,
    )
