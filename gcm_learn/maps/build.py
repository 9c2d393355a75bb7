"""Cognitive maps of situations, made by any engine, and static twins of situations."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gcm_learn.charts import Chart, chart_of, hand_space
from gcm_learn.collision import arm_distance
from gcm_learn.errors import SituationError
from gcm_learn.maps.cognitive_map import MAPS, CognitiveMap, Interception
from gcm_learn.motion import start_clearance
from gcm_learn.scene import HAND, PART, TOP_SPEED, Bodies, Scene, pack, pack_bodies, pose, poses_at
from gcm_learn.situation import AnySituation, Body, PlanarQuadratic, Situation
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
    """Let a front spread from the hand; return arrivals and contacts as a map (Eqs. 10-12).

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
        Its `interception` is None if no target was met.
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


CLEAR = 1e-3  # copies nearer to the limb at t = 0 are left out [forearm lengths]


def static_twin(situation: Situation, made: CognitiveMap, poses: int = 1) -> Situation:
    """Replace the bodies of a planar situation by resting copies.

    Parameters
    ----------
    situation : Situation
    made : CognitiveMap
        Its map; the target rests where the front met it.
    poses : int
        Copies of an obstacle that moves. One stands where the obstacle was at the median of the
        times at which the front met it, several at even shares of these, from first to last.

    Raises
    ------
    SituationError
        If the front met no target.
    """
    hit = made.interception
    if hit is None:
        raise SituationError("map", "its front met no target, so there is no place for one")
    target = [body.name for body in situation.bodies].index(hit.body)
    caught = _still(situation, target, hit.time, hit.body)
    bodies, shares = pack_bodies(situation), np.linspace(0.0, 1.0, poses)
    copies = []
    for b, times in _meetings(bodies, made).items():
        several = poses > 1 and bodies.rows[b, TOP_SPEED] > 0.0
        for k, t in enumerate(np.quantile(times, shares if several else [0.5])):
            copy = _still(situation, b, float(t), f"{situation.bodies[b].name} {k}")
            if start_clearance(pack(replace(situation, bodies=(caught, copy)))) > CLEAR:
                copies.append(copy)
    return replace(situation, name=f"twin of {situation.name}", bodies=(caught, *copies))


def _meetings(bodies: Bodies, made: CognitiveMap) -> dict[int, np.ndarray]:
    """Map each obstacle's index to the times when the front met it, one per blocked cell [s]."""
    from scipy.ndimage import minimum_filter  # takes a fifth of a second to load

    when = minimum_filter(made.arrival.filled(np.inf), size=3)  # walls have none of their own
    walls = made.effective_obstacles & np.isfinite(when)
    limbs = hand_space(made.lattice).limb.reshape(*walls.shape, 4)[walls]
    obstacles = np.flatnonzero(bodies.rows[:, PART] != HAND)
    poses, nearest = np.zeros((len(bodies.rows), 12)), []
    for t, limb in zip(when[walls], limbs, strict=True):
        poses_at(bodies, t, poses)
        gaps = [arm_distance(bodies, poses, b, *limb) for b in obstacles]
        nearest.append(obstacles[np.argmin(gaps)])
    return {int(b): when[walls][np.array(nearest) == b] for b in np.unique(nearest)}


def _still(situation: Situation, index: int, t: float, name: str) -> Body:
    """Return a copy of a body that rests at the pose of time t."""
    centre, rotation = pose(situation, index, t)
    place = (float(centre[0]), float(centre[1]))
    turn = float(np.arctan2(rotation[1, 0], rotation[0, 0]))
    still = PlanarQuadratic(place, (0.0, 0.0), (0.0, 0.0), turn)
    return replace(situation.bodies[index], name=name, motion=still)
