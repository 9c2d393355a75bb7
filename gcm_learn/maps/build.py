"""From a situation to its cognitive map, by either engine."""

from __future__ import annotations

import numpy as np

from gcm_learn.arm.lattice import Lattice
from gcm_learn.maps.cognitive_map import CognitiveMap, Contact
from gcm_learn.situation import Situation
from gcm_learn.situation.bodies import pack
from gcm_learn.situation.kernels import Bodies
from gcm_learn.wave import MarchingParams, Task, WaveParams, kappa_of, march, propagate
from gcm_learn.wave.kernels import CONTACT, FROZEN


def build_map(
    situation: Situation,
    params: WaveParams | MarchingParams | None = None,
    *,
    bodies: Bodies | None = None,
    ignore: float = 0.0,
) -> CognitiveMap:
    """Let a front spread from the hand and keep what it met (Eqs. 10-12).

    Parameters
    ----------
    situation : Situation
    params : WaveParams or MarchingParams, optional
        The kind chooses the engine; the published wave by default.
    bodies : Bodies, optional
        The situation packed, if the caller has it at hand.
    ignore : float
        Contacts before this time do not stop the front [s].

    Returns
    -------
    CognitiveMap
        Whether the target was met is its `contact`.
    """
    params = WaveParams() if params is None else params
    arm = situation.arm
    task = Task(
        bodies=pack(situation) if bodies is None else bodies,
        lattice=Lattice(params.n, arm.upper_arm, arm.elbow),
        hand=arm.hand,
        speed=arm.max_hand_speed,
        horizon=situation.horizon,
        thickness=arm.thickness,
        grasp=arm.grasp,
        ignore=ignore,
    )
    wave = isinstance(params, WaveParams)
    front = propagate(task, params) if isinstance(params, WaveParams) else march(task, params)
    frozen = front.state == FROZEN
    contact = None
    if front.contact_cell >= 0:
        iy, ix = divmod(front.contact_cell, params.n)
        centres = task.lattice.centres
        contact = Contact(
            cell=(iy, ix),
            position=(float(centres[ix]), float(centres[iy])),
            time=front.contact_time,
            body=situation.bodies[front.contact_body].name,
        )
    return CognitiveMap(
        lattice=task.lattice,
        hand=arm.hand,
        arrival=np.ma.MaskedArray(front.arrival, mask=frozen | (front.arrival < 0.0)),
        effective_obstacles=frozen,
        effective_target=front.state == CONTACT,
        contact=contact,
        kappa=kappa_of(task, params if isinstance(params, WaveParams) else WaveParams(n=params.n)),
        engine="wave" if wave else "marching",
    )
