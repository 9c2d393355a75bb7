"""A situation as numbers: for twins, distances and neighbours in the space of raw parameters.

All numbers are lengths (velocities times the horizon, accelerations times half its square, angles
and turns times the body's radius), so that one unit of distance means about the same everywhere.
"""

from __future__ import annotations

import hashlib
import math

import numpy as np

from gcm_learn.arms import Arm, Chain, SpatialArm, rotation_of
from gcm_learn.checks import quote
from gcm_learn.errors import SituationError
from gcm_learn.motion import fastest_hand
from gcm_learn.scene import pack
from gcm_learn.situation import (
    AnySituation,
    Body,
    Box,
    Capsule,
    Cylinder,
    Disc,
    Pendulum,
    PlanarQuadratic,
    Polygon,
    SolidQuadratic,
    Sphere,
    planar,
)

DIGITS = 5  # of parameters that twins share [powers of ten of a forearm length]


def structure_of(situation: AnySituation) -> str:
    """What parameters of a situation mean: arm and kinds of bodies, e.g. ``arm|disc|polygon4``.

    Only situations of the same structure can be compared number by number.
    """
    return "|".join([_arm_kind(situation), *map(_kind, _in_order(situation))])


def _arm_kind(situation: AnySituation) -> str:
    arm = situation.arm
    if isinstance(arm, SpatialArm):
        hand = "" if arm.max_hand_speed is None else "+hand"
        return f"space{hand}{'' if arm.max_joint_acceleration is None else '+acceleration'}"
    joints = "" if arm.max_joint_speed is None else "+joints"
    return f"{'solid' if situation.is_solid else 'planar'}{joints}"


def parameters_of(situation: AnySituation) -> np.ndarray:
    """Numbers (m,) float32 of a canonical situation; what they mean is its structure.

    Targets come first; the obstacles' order is that of their distance from the shoulder, so that it
    does not matter in which they were listed.
    """
    arm, horizon = situation.arm, situation.horizon
    if isinstance(arm, SpatialArm):
        numbers = _spatial_arm_numbers(arm, horizon)
    else:
        numbers = _arm_numbers(planar(situation, "a data set").arm, horizon)
    for body in _in_order(situation):
        numbers += _motion_numbers(body, horizon)
        numbers += _shape_numbers(body)
    unit = forearm_of(arm)
    return np.array(numbers if unit == 1.0 else [n / unit for n in numbers], dtype=np.float32)


def forearm_of(arm: Arm | SpatialArm | Chain) -> float:
    """Length of the forearm in the situation's unit."""
    return math.hypot(*arm.forearm) if isinstance(arm, SpatialArm) else 1.0


def _arm_numbers(arm: Arm, horizon: float) -> list[float]:
    joints = arm.max_joint_speed or ()
    numbers = [arm.hand[0], arm.upper_arm, arm.max_hand_speed * horizon, arm.thickness, arm.grasp]
    return [*numbers, *(limit * horizon for limit in joints)]


def _spatial_arm_numbers(arm: SpatialArm, horizon: float) -> list[float]:
    """Angles count as the way of the hand that they turn about the elbow."""
    unit = forearm_of(arm)
    ends = [end for ends in arm.joint_range for end in ends]
    turns = [*arm.joints, *ends, *(limit * horizon for limit in arm.max_joint_speed)]
    if arm.max_joint_acceleration is not None:
        turns += [0.5 * limit * horizon**2 for limit in arm.max_joint_acceleration]
        turns += [rate * horizon for rate in arm.joint_rates or ()]
    hand = [] if arm.max_hand_speed is None else [arm.max_hand_speed * horizon]
    bones = [*arm.upper_arm, *arm.forearm, *hand, arm.thickness, arm.grasp]
    return bones + [unit * turn for turn in turns]


def twin_key(structure: str, parameters: np.ndarray) -> int:
    """Key (63 bits) that situations share when their parameters agree to DIGITS digits."""
    rounded = np.round(parameters.astype(float), DIGITS) + 0.0  # no negative zeros
    digest = hashlib.blake2b(structure.encode() + rounded.tobytes(), digest_size=8).digest()
    return int.from_bytes(digest, "little") >> 1


def _in_order(situation: AnySituation) -> list[Body]:
    obstacles = sorted(situation.obstacles, key=lambda body: (_kind(body), _distance(body)))
    return [*situation.targets, *obstacles]


def _place(body: Body) -> tuple[float, ...]:
    motion = body.motion
    return motion.pivot if isinstance(motion, Pendulum) else _quadratic(body).position


def _quadratic(body: Body) -> PlanarQuadratic | SolidQuadratic:
    """Return the motion of a body that has one quadratic law."""
    if isinstance(body.motion, PlanarQuadratic | SolidQuadratic):
        return body.motion
    reason = f"{quote(body.motion.kind)} is not for data sets"
    raise SituationError(f"{body.name}.motion.kind", reason)


def _distance(body: Body) -> float:
    return math.hypot(*_place(body))


def _kind(body: Body) -> str:
    shape = body.shape
    corners = len(shape.vertices) if isinstance(shape, Polygon) else ""
    swing = "~" if isinstance(body.motion, Pendulum) else ""
    return f"{shape.kind}{corners}{swing}"


def _motion_numbers(body: Body, horizon: float) -> list[float]:
    """Where it is, how far it gets, how it turns."""
    motion, radius = body.motion, body.shape.bounding_radius
    if isinstance(motion, Pendulum):
        swing = [motion.angle, motion.rate * horizon, motion.damping * horizon]
        fall = 0.5 * motion.gravity * horizon**2
        lengths = [motion.length, motion.hang_distance, fall]
        turns = [motion.length * s for s in swing]
        return [*motion.pivot, *motion.axis, *motion.down, *lengths, *turns]
    motion = _quadratic(body)
    numbers = [*motion.position, *(v * horizon for v in motion.velocity)]
    numbers += [0.5 * a * horizon**2 for a in motion.acceleration]
    if isinstance(body.shape, Disc | Sphere):
        return numbers  # nobody can see them turn
    if isinstance(motion, PlanarQuadratic):
        c, s = math.cos(motion.angle), math.sin(motion.angle)
        return [*numbers, radius * c, radius * s, radius * motion.spin * horizon]
    axes = rotation_of(motion.orientation)
    seen = axes[:, 2] if isinstance(body.shape, Capsule | Cylinder) else axes[:, ::2].ravel()
    turn = (radius * s * horizon for s in motion.spin)
    return [*numbers, *(radius * seen).tolist(), *turn]


def _shape_numbers(body: Body) -> list[float]:
    shape = body.shape
    if isinstance(shape, Polygon):
        return [value for corner in shape.vertices for value in corner]
    if isinstance(shape, Box):
        return list(shape.half_extents)
    if isinstance(shape, Capsule | Cylinder):
        return [shape.radius, shape.half_length]
    return [shape.radius]


def quantities_of(situation: AnySituation, top_speed: float) -> dict[str, float]:
    """What range splits ask about; lengths in forearms.

    Parameters
    ----------
    situation : Situation
    top_speed : float
        Largest speed of any body within the horizon [lengths / s].
    """
    obstacles, arm, unit = situation.obstacles, situation.arm, forearm_of(situation.arm)
    if isinstance(arm, SpatialArm):
        upper_arm, hand_speed = math.hypot(*arm.upper_arm), float(fastest_hand(pack(situation)))
    else:
        upper_arm = planar(situation, "a data set").arm.upper_arm
        hand_speed = planar(situation, "a data set").arm.max_hand_speed
    return {
        "upper_arm": upper_arm / unit,
        "max_hand_speed": hand_speed / unit,
        "horizon": situation.horizon,
        "obstacles": float(len(obstacles)),
        "top_speed": top_speed / hand_speed,
        "largest": max((body.shape.bounding_radius for body in obstacles), default=0.0) / unit,
    }
