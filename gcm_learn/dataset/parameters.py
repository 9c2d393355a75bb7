"""A situation as numbers: for twins, distances and neighbours in the space of raw parameters.

All numbers are lengths, so that one unit of distance means about the same everywhere. Velocities
count times the horizon, accelerations times half its square, angles and turns times the body's
radius.
"""

from __future__ import annotations

import hashlib
import math

import numpy as np

from gcm_learn.arms import rotation_of
from gcm_learn.dataset.kinds import RECORDS
from gcm_learn.scene import entry_of
from gcm_learn.situation import (
    AnySituation,
    Body,
    Motion,
    Pendulum,
    Piecewise,
    PlanarQuadratic,
    Sampled,
    SolidQuadratic,
    numbers_of,
)

DIGITS = 5  # of parameters that twins share [powers of ten of a forearm length]


def structure_of(situation: AnySituation) -> str:
    """Name a situation's structure: arm and kinds of bodies, e.g. ``arm|disc|polygon4``.

    Only situations of the same structure can be compared number by number.
    """
    return "|".join([RECORDS.of(situation).word(situation), *map(_kind, _in_order(situation))])


def parameters_of(situation: AnySituation) -> np.ndarray:
    """Numbers (m,) float32 of a canonical situation; what they mean is its structure.

    Targets come first; the obstacles' order is that of their distance from the shoulder, so that it
    does not matter in which they were listed.
    """
    arm, horizon = situation.arm, situation.horizon
    numbers = RECORDS.of(situation).numbers(arm, horizon)
    for body in _in_order(situation):
        numbers += _motion_numbers(body, horizon)
        numbers += numbers_of(body.shape)
    unit = RECORDS.of(situation).forearm(arm)
    return np.array(numbers if unit == 1.0 else [n / unit for n in numbers], dtype=np.float32)


def twin_key(structure: str, parameters: np.ndarray) -> int:
    """Key (63 bits) that situations share when their parameters agree to DIGITS digits."""
    rounded = np.round(parameters.astype(float), DIGITS) + 0.0  # no negative zeros
    digest = hashlib.blake2b(structure.encode() + rounded.tobytes(), digest_size=8).digest()
    return int.from_bytes(digest, "little") >> 1


def _in_order(situation: AnySituation) -> list[Body]:
    obstacles = sorted(situation.obstacles, key=lambda body: (_kind(body), _distance(body)))
    return [*situation.targets, *obstacles]


def _place(body: Body) -> tuple[float, ...]:
    """Return the pivot of a swing, or the place of a body at t = 0."""
    motion = body.motion
    if isinstance(motion, Pendulum):
        return motion.pivot
    if isinstance(motion, Sampled):
        return motion.positions[0]
    return motion.pieces[0].motion.position if isinstance(motion, Piecewise) else motion.position


def _distance(body: Body) -> float:
    return math.hypot(*_place(body))


def _kind(body: Body) -> str:
    shape = body.shape
    corners = len(entry_of(shape).vertices(shape)) or ""
    approach = "" if body.approach is None else "<"
    return f"{shape.kind}{corners}{_law(body.motion)}{approach}"


def _law(motion: Motion) -> str:
    """Return the sign of a law of motion, which says how many numbers it has."""
    if isinstance(motion, Pendulum):
        return "~"
    if isinstance(motion, Piecewise):
        return f"^{len(motion.pieces)}"
    if isinstance(motion, Sampled):
        return f"*{len(motion.times)}{'' if motion.orientations is None else 'o'}"
    return ""


def _motion_numbers(body: Body, horizon: float) -> list[float]:
    """Return place, ways and turns of a body, and how it is approached."""
    motion, radius = body.motion, body.shape.bounding_radius
    numbers: list[float] = []
    if isinstance(motion, Pendulum):
        numbers = _swing_numbers(motion, horizon)
    elif isinstance(motion, Sampled):
        numbers = [horizon * t for t in motion.times]
        numbers += [x for place in motion.positions for x in place]
        for turn in () if entry_of(body.shape).is_ball else motion.orientations or ():
            numbers += (radius * _seen(body, turn)).tolist()
    elif isinstance(motion, Piecewise):
        for start, piece in motion.pieces:
            numbers += [horizon * start, *_flight_numbers(body, piece, horizon)]
    else:
        numbers = _flight_numbers(body, motion, horizon)
    if body.approach is not None:
        numbers += [radius * x for x in (*body.approach.axis, body.approach.within)]
    return numbers


def _swing_numbers(motion: Pendulum, horizon: float) -> list[float]:
    """Return the numbers of a swing."""
    swing = [motion.angle, motion.rate * horizon, motion.damping * horizon]
    fall = 0.5 * motion.gravity * horizon**2
    lengths = [motion.length, motion.hang_distance, fall]
    turns = [motion.length * s for s in swing]
    return [*motion.pivot, *motion.axis, *motion.down, *lengths, *turns]


def _flight_numbers(
    body: Body, motion: PlanarQuadratic | SolidQuadratic, horizon: float
) -> list[float]:
    """Return the numbers of one quadratic law of a body."""
    radius = body.shape.bounding_radius
    numbers = [*motion.position, *(v * horizon for v in motion.velocity)]
    numbers += [0.5 * a * horizon**2 for a in motion.acceleration]
    if entry_of(body.shape).is_ball:
        return numbers  # no turn can be seen
    if isinstance(motion, PlanarQuadratic):
        c, s = math.cos(motion.angle), math.sin(motion.angle)
        return [*numbers, radius * c, radius * s, radius * motion.spin * horizon]
    turn = (radius * s * horizon for s in motion.spin)
    return [*numbers, *(radius * _seen(body, motion.orientation)).tolist(), *turn]


def _seen(body: Body, orientation: tuple[float, ...]) -> np.ndarray:
    """Return the axes of a body that show how it is turned."""
    axes = rotation_of(orientation)
    seen: np.ndarray = axes[:, 2] if entry_of(body.shape).is_round else axes[:, ::2].ravel()
    return seen


def quantities_of(situation: AnySituation, top_speed: float) -> dict[str, float]:
    """Return the numbers that range splits compare; lengths in forearms.

    Parameters
    ----------
    situation : Situation
    top_speed : float
        Largest speed of any body within the horizon [lengths / s].
    """
    obstacles, kind = situation.obstacles, RECORDS.of(situation)
    unit, (upper_arm, hand_speed) = kind.forearm(situation.arm), kind.sizes(situation)
    return {
        "upper_arm": upper_arm / unit,
        "max_hand_speed": hand_speed / unit,
        "horizon": situation.horizon,
        "obstacles": float(len(obstacles)),
        "top_speed": top_speed / hand_speed,
        "largest": max((body.shape.bounding_radius for body in obstacles), default=0.0) / unit,
    }
