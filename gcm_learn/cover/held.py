"""Held catches: one movement for a whole cell, proven in a single, harder situation.

Parameters move bodies and change their velocities, and nothing else. So no obstacle of a cell is
farther from its place in the middle than `now + rate t`. A margin says the same. The grasp is
smaller by how far a target may be off, the relative speed by how much its velocity may differ. A
movement that is verified under these margins and limits holds in all of the cell.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from gcm_learn.cover.catches import HAIR, WIDER, Doubt, StoredCatch
from gcm_learn.cover.families import ParametricFamily
from gcm_learn.cover.limits import SAFETY
from gcm_learn.errors import FamilyError
from gcm_learn.motion import Ask, Failure, rules_of, verify
from gcm_learn.planners import solve
from gcm_learn.scene import pack
from gcm_learn.situation import Margin

LEAST = 0.25
"""Share of grasp and relative speed that a cell must leave before it is planned for."""
NAMES = {Failure.COLLISION: "clearance", Failure.NOT_HELD: "grasp", Failure.SLIPS: "relative speed"}
"""Names of doubts, by what failed."""


def harder(
    family: ParametricFamily, centre: np.ndarray, half: np.ndarray, until: float, least: float = 0.0
) -> Any:
    """Return a situation whose catches hold in a whole cell, if their holds end by `until`.

    Parameters
    ----------
    family : ParametricFamily
    centre, half : (K,) ndarray
        Middle of the cell, and half its sides.
    until : float
        [s]
    least : float
        Share of grasp and relative speed that has to be left.

    Returns
    -------
    Situation or Doubt
        The doubt about the cell where too little of grasp or relative speed is left.
    """
    middle = family.situation(centre)
    most = np.einsum("kbld,k->bld", np.abs(family.slopes[:, :, :2]), half + WIDER)
    grasp, bodies = middle.arm.grasp, []
    for k, body in enumerate(middle.bodies):
        now, rate = np.linalg.norm(most[k], axis=-1).tolist()
        if body.role == "obstacle":
            had = body.margin or Margin(0.0, 0.0)
            bodies.append(replace(body, margin=Margin(had.now + now, had.rate + rate)))
            continue
        if body.hold is None or body.place is not None:
            raise FamilyError(body.name, "is to be held and not placed, where anything is held")
        off = now + rate * until + HAIR
        turned = float(np.linalg.norm(body.motion.spin)) * off
        fast = body.hold.relative_speed - rate - turned - HAIR
        grasp = min(grasp, middle.arm.grasp - off)
        if fast <= least * body.hold.relative_speed:
            return _doubt(family, Failure.SLIPS, half, until, k)
        if grasp <= least * middle.arm.grasp:
            return _doubt(family, Failure.NOT_HELD, half, until, k)
        bodies.append(replace(body, hold=replace(body.hold, relative_speed=fast)))
    return replace(middle, arm=replace(middle.arm, grasp=grasp), bodies=tuple(bodies))


def _doubt(
    family: ParametricFamily, failure: Failure, half: np.ndarray, when: float, target: int
) -> Doubt:
    """Return the doubt for a failure, with how much each parameter adds to the bound that fails."""
    others = [k for k, body in enumerate(family.middle.bodies) if body.role == "obstacle"]
    bodies = others if failure is Failure.COLLISION else [target]
    slipping = failure is Failure.SLIPS
    moved = np.linalg.norm(family.drifts(np.array([when]))[0][:, bodies], axis=-1)
    if slipping:
        turned = float(np.linalg.norm(family.middle.bodies[target].motion.spin))  # type: ignore[union-attr]
        moved = np.linalg.norm(family.slopes[:, bodies, 1], axis=-1) + turned * moved
    shares = half * moved.max(axis=1, initial=0.0)
    return Doubt(NAMES.get(failure, failure.name.lower().replace("_", " ")), shares)


def held_doubt(
    family: ParametricFamily, catch: StoredCatch, centre: np.ndarray, half: np.ndarray
) -> Doubt | None:
    """Prove that a held catch holds in a whole cell, or return the doubt; see `doubt_of`."""
    span: Any = catch.span
    hard = harder(family, centre, half, span[1])
    if isinstance(hard, Doubt):
        return hard
    scene = pack(hard)
    touch = scene.limb.thickness + (SAFETY + HAIR) * scene.limb.length
    rules, ask = rules_of(scene)._replace(touch=touch), Ask.of(hard, [(catch.body, *span)])
    verdict = verify(scene, rules, catch.movement(family, centre), catch.body, ask)
    if verdict.reason is None:
        return None
    when = span[1] if verdict.collision_time is None else verdict.collision_time
    return _doubt(family, verdict.reason.failure, half, when, catch.body)


def held_catch(
    family: ParametricFamily, centre: np.ndarray, half: np.ndarray
) -> StoredCatch | Doubt:
    """Plan a held catch for a whole cell at once; return a doubt if no catch is proven."""
    middle = family.middle
    last = middle.horizon + max(body.hold.seconds for body in middle.bodies if body.hold)
    hard = harder(family, centre, half, last, LEAST)
    if isinstance(hard, Doubt):
        return hard
    plan: Any = solve(hard)
    if plan.trajectory is None:
        moved = np.linalg.norm(family.drifts(np.array([last]))[0], axis=-1).max(axis=1)
        return Doubt(plan.status, half * moved)
    moves, names = plan.trajectory, [body.name for body in hard.bodies]
    body, span = names.index(plan.catch_body), (plan.catch_time, plan.held_until)
    still, fixed = np.zeros(moves.time.size), np.zeros((moves.joints.shape[1], centre.size))
    catch = StoredCatch(centre, moves.time, moves.joints, still, fixed, body, moves.rates, span)
    return held_doubt(family, catch, centre, half) or catch
