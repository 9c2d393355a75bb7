"""Static situations that stand for dynamic ones: bodies rest where a map's front met them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.ndimage import minimum_filter

from gcm_learn.charts import hand_space
from gcm_learn.collision import arm_distance
from gcm_learn.errors import SituationError
from gcm_learn.maps.cognitive_map import CognitiveMap
from gcm_learn.motion import start_clearance
from gcm_learn.scene import HAND, PART, TOP_SPEED, Bodies, pack, pack_bodies, pose, poses_at
from gcm_learn.situation import Body, PlanarQuadratic, Situation

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
    """Return the times at which the front met each obstacle, one for each cell near it [s]."""
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
    """Return a body as it is at time t, at rest."""
    centre, rotation = pose(situation, index, t)
    place = (float(centre[0]), float(centre[1]))
    turn = float(np.arctan2(rotation[1, 0], rotation[0, 0]))
    still = PlanarQuadratic(place, (0.0, 0.0), (0.0, 0.0), turn)
    return replace(situation.bodies[index], name=name, motion=still)
