"""Bodies and their laws of motion: poses at any time, and bounds of the way in between."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from gcm_learn.referee.rotations import Array, rotations, turns, unit
from gcm_learn.referee.shapes import ball_of, point_gaps, ready
from gcm_learn.referee.tolerances import Unreadable

SWING = 4e-3
"""Step of a pendulum, as a share of the time in which it changes."""
MEETING = 2e-6
"""By which pieces of a motion may miss each other; twice what the contract grants."""
STEPS = 32
"""Into which a quadratic motion is cut for bounds of its speed."""
UNTURNED = (1.0, 0.0, 0.0, 0.0)


State = tuple[Array, Array, Array, Array]
"""Centres (k, 3), rotations (k, 3, 3) from the body to the world, velocities, spins (k, 3)."""


class Law(NamedTuple):
    """Motion of a body through the world."""

    states: Callable[[Array, Array], State]
    """From times (k,) to states; of pieces that meet there, that of a second time (k,) counts."""
    knots: Array
    """Times (m,) between which the bounds are linear [s]."""
    way: Array
    """Bound (m,) of the way of the centre since t = 0."""
    turn: Array
    """Bound (m,) of the angle by which the body has turned since t = 0 [rad]."""
    most: Array
    """Bounds (2, 3) of velocity and spin, and of their first and second derivatives."""
    breaks: Array = np.zeros(0)
    """Times at which the velocity may jump."""


def law_of(motion: dict[str, Any], end: float) -> Law:
    """Return the motion of a body, with bounds up to a time `end` [s]."""
    return LAWS[motion["kind"]](motion, max(end, 1e-9))


def _added(steps: Array) -> Array:
    return np.concatenate([[0.0], np.cumsum(steps)])


def _padded(vector: Any) -> Array:
    """Return a vector of the plane or of space as a vector (3,), padded with zeros."""
    return np.array([*vector, 0.0, 0.0], dtype=float)[:3]


def _flight(motion: dict[str, Any]) -> tuple[Array, Array, Array, Array, Array]:
    """Return position, velocity, acceleration, spin and orientation of a quadratic motion."""
    place = [_padded(motion[name]) for name in ("position", "velocity", "acceleration")]
    spin = motion.get("spin", 0.0)
    if np.ndim(spin) == 0 and len(motion["position"]) == 2:
        turn = turns([0.0, 0.0, 1.0], float(motion.get("angle", 0.0)))
        return place[0], place[1], place[2], np.array([0.0, 0.0, float(spin)]), turn
    turn = rotations(motion.get("orientation", UNTURNED))
    return place[0], place[1], place[2], np.array(motion.get("spin", [0.0] * 3), float), turn


def _flown(motion: dict[str, Any], t: Array) -> State:
    position, velocity, acceleration, spin, first = _flight(motion)
    s = t[:, None]
    turn = np.broadcast_to(first, (len(t), 3, 3))
    if spin.any():
        turn = turns(spin, np.linalg.norm(spin) * t) @ turn
    place = position + s * velocity + 0.5 * s * s * acceleration
    return place, turn, velocity + s * acceleration, np.broadcast_to(spin, place.shape)


def _most(motion: dict[str, Any], span: float) -> Array:
    """Return `Law.most` of a quadratic motion that lasts so long."""
    _, velocity, acceleration, spin, _ = _flight(motion)
    ends = (velocity, velocity + span * acceleration)
    fast = max(float(np.linalg.norm(end)) for end in ends)
    return np.array([[fast, np.linalg.norm(acceleration), 0.0], [np.linalg.norm(spin), 0.0, 0.0]])


def _steps(motion: dict[str, Any], knots: Array) -> tuple[Array, Array]:
    """Return bounds of way and angle of a quadratic motion between knots.

    A speed is convex in time under constant acceleration, so it is greatest at an end.
    """
    _, velocity, acceleration, spin, _ = _flight(motion)
    speed = np.linalg.norm(velocity + knots[:, None] * acceleration, axis=1)
    span = np.diff(knots)
    return np.maximum(speed[1:], speed[:-1]) * span, np.linalg.norm(spin) * span


def _quadratic(motion: dict[str, Any], end: float) -> Law:
    knots = np.linspace(0.0, end, STEPS + 1)
    way, turn = _steps(motion, knots)
    most = _most(motion, end)
    return Law(lambda t, _: _flown(motion, t), knots, _added(way), _added(turn), most)


def _piecewise(motion: dict[str, Any], end: float) -> Law:
    pieces = motion["pieces"]
    starts = np.array([piece["start"] for piece in pieces], dtype=float)
    ends = np.append(starts[1:], max(end, float(starts[-1]) + 1e-9))
    parts = [np.linspace(a, b, STEPS + 1) for a, b in zip(starts, ends, strict=True)]
    bounds = [_steps(p, part - part[0]) for p, part in zip(pieces, parts, strict=True)]
    way, turn = (np.concatenate(several) for several in zip(*bounds, strict=True))
    knots = np.concatenate([[0.0], *(part[1:] for part in parts)])

    def states(t: Array, inside: Array) -> State:
        which = np.maximum(np.searchsorted(starts, inside, side="right") - 1, 0)
        out = tuple(np.zeros((len(t), *size)) for size in ((3,), (3, 3), (3,), (3,)))
        for k in np.unique(which):
            here = which == k
            for column, found in zip(out, _flown(pieces[k], t[here] - starts[k]), strict=True):
                column[here] = found
        return out[0], out[1], out[2], out[3]

    for k, start in enumerate(starts[1:]):
        before, after = (_flown(p, start[None] - p["start"]) for p in pieces[k : k + 2])
        size = max(1.0, float(np.abs(before[0]).max()))
        if max(np.abs(before[0] - after[0]).max() / size, _apart(before[1], after[1])) > MEETING:
            raise Unreadable(f"motion.pieces[{k + 1}]: does not begin where the one before ends")
    most = [_most(p, b - a) for p, a, b in zip(pieces, starts, ends, strict=True)]
    return Law(states, knots, _added(way), _added(turn), np.max(most, axis=0), starts[1:])


def _apart(first: Array, second: Array) -> float:
    """Return the distance of two orientations, about half the angle between them [rad]."""
    return float(np.abs(first - second).max()) / 2.0


def _sampled(motion: dict[str, Any], end: float) -> Law:
    times, at = (np.array(motion[name], dtype=float) for name in ("times", "positions"))
    given = motion.get("orientations") or [UNTURNED] * len(times)
    q = np.array(given, dtype=float)
    if len(times) == 1:
        times, at, q = np.array([0.0, 1.0]), np.repeat(at, 2, axis=0), np.repeat(q, 2, axis=0)
    q = q / np.linalg.norm(q, axis=1, keepdims=True)
    cosine = np.minimum(np.abs((q[1:] * q[:-1]).sum(axis=1)), 1.0)
    if (cosine < 1e-9).any():
        raise Unreadable("motion.orientations: neighbours are half a turn apart")
    way, span = np.linalg.norm(np.diff(at, axis=0), axis=1), np.diff(times)
    fast, spin = np.diff(at, axis=0) / span[:, None], _turned(q[:-1], q[1:]) / span[:, None]

    def states(t: Array, inside: Array) -> State:
        k = np.clip(np.searchsorted(times, inside, side="right") - 1, 0, len(times) - 2)
        s = np.clip((t - times[k]) / span[k], 0.0, 1.0)[:, None]
        moves = (inside < times[-1])[:, None]
        turn = rotations(_between(q[k], q[k + 1], s))
        return at[k] + s * (at[k + 1] - at[k]), turn, moves * fast[k], moves * spin[k]

    most = np.zeros((2, 3))
    most[:, 0] = [np.linalg.norm(rate, axis=1).max() for rate in (fast, spin)]
    return Law(states, times, _added(way), _added(2.0 * np.arccos(cosine) + 1e-7), most, times[1:])


def _turned(p: Array, q: Array) -> Array:
    """Return vectors (k, 3) of the turns on the short ways from quaternions p to q (k, 4)."""
    scalar = (p * q).sum(axis=1, keepdims=True)
    vector = p[:, :1] * q[:, 1:] - q[:, :1] * p[:, 1:] - np.cross(q[:, 1:], p[:, 1:])
    vector = np.where(scalar < 0.0, -vector, vector)
    size = np.linalg.norm(vector, axis=1, keepdims=True)
    angle = 2.0 * np.arctan2(size, np.abs(scalar))
    return vector * np.where(size > 0.0, angle / np.where(size > 0.0, size, 1.0), 2.0)


def _between(p: Array, q: Array, s: Array) -> Array:
    """Return quaternions at shares s (k, 1) of the short ways from p to q (k, 4)."""
    cosine = (p * q).sum(axis=1, keepdims=True)
    q, angle = np.where(cosine < 0.0, -q, q), np.arccos(np.minimum(np.abs(cosine), 1.0))
    with np.errstate(all="ignore"):
        arc = (np.sin((1.0 - s) * angle) * p + np.sin(s * angle) * q) / np.sin(angle)
    return np.where(angle < 1e-6, (1.0 - s) * p + s * q, arc)


def _pendulum(motion: dict[str, Any], end: float) -> Law:
    pull, damping = motion["gravity"] / motion["length"], motion.get("damping", 0.0)
    step, grid = _swing(motion["angle"], motion["rate"], pull, damping, math.ceil(1.0 + end))
    axis, down = unit(motion["axis"]), unit(motion["down"])
    hang, pivot = motion.get("hang", motion["length"]), np.array(motion["pivot"], dtype=float)

    def states(t: Array, inside: Array) -> State:
        k = np.clip((t / step).astype(int), 0, len(grid) - 1)
        angle, rate = _swung(grid[k, 0], grid[k, 1], t - k * step, pull, damping, np.sin)
        along = turns(axis, angle) @ down
        side = np.broadcast_to(axis, along.shape)
        turn = np.stack([np.cross(side, along), side, along], axis=-1)
        rate = rate[:, None]
        return pivot + hang * along, turn, hang * rate * np.cross(side, along), rate * axis

    rate = np.abs(grid[:, 1])
    most = np.maximum(rate[1:], rate[:-1]) + step * (pull + damping * (rate.max() + 1.0))
    turned = _added(step * most)
    fast = float(most.max())
    hard = pull + damping * fast
    jerk = pull * fast + damping * hard
    circle = np.array([fast, hard + fast**2, jerk + 3.0 * fast * hard + fast**3])
    bounds = np.stack([abs(hang) * circle, [fast, hard, jerk]])
    return Law(states, step * np.arange(len(grid)), abs(hang) * turned, turned, bounds)


@lru_cache(maxsize=64)
def _swing(
    angle: float, rate: float, pull: float, damping: float, until: int
) -> tuple[float, Array]:
    """Return the step, and angles and rates (k, 2) of a pendulum at equal steps until a time."""
    step = SWING / max(math.sqrt(pull), abs(rate), damping, 1e-3)
    grid = [(angle, rate)]
    for _ in range(math.ceil(until / step)):
        grid.append(_swung(*grid[-1], step, pull, damping, math.sin))
    return step, np.array(grid)


def _swung(x: Any, v: Any, h: Any, pull: float, damping: float, sin: Any) -> tuple[Any, Any]:
    """Return angle and rate after a step h of the classical Runge-Kutta rule."""
    a = -pull * sin(x) - damping * v
    v2 = v + 0.5 * h * a
    b = -pull * sin(x + 0.5 * h * v) - damping * v2
    v3 = v + 0.5 * h * b
    c = -pull * sin(x + 0.5 * h * v2) - damping * v3
    v4 = v + h * c
    d = -pull * sin(x + h * v3) - damping * v4
    return x + h / 6.0 * (v + 2.0 * (v2 + v3) + v4), v + h / 6.0 * (a + 2.0 * (b + c) + d)


LAWS: dict[str, Callable[[dict[str, Any], float], Law]] = {
    "quadratic": _quadratic,
    "piecewise": _piecewise,
    "sampled": _sampled,
    "pendulum": _pendulum,
}
"""Laws of motion by their kind."""


@dataclass(frozen=True)
class Body:
    """A target or an obstacle."""

    name: str
    role: str
    shape: dict[str, Any]
    law: Law
    ball: float
    """Radius of the ball about the centre that holds the shape."""
    given: dict[str, Any]
    """The body in its situation."""

    @property
    def approaches(self) -> list[dict[str, Any]]:
        """Ways in which the hand must come."""
        asked = self.given.get("approach", [])
        return [asked] if isinstance(asked, dict) else asked

    @property
    def margin(self) -> tuple[float, float]:
        """Distance that links keep at t = 0, and its growth per second."""
        asked = self.given.get("margin", {})
        return asked.get("now", 0.0), asked.get("rate", 0.0)

    def poses(self, times: Array) -> tuple[Array, Array]:
        """Return centres (k, 3) and rotations (k, 3, 3), body to world, at times (k,)."""
        return self.law.states(times, times)[:2]

    def ways(self, low: Array, middle: Array, high: Array) -> Array:
        """Return bounds (k,) of the way of any point from the middles of intervals."""
        spins = self.shape["kind"] not in ("sphere", "disc")
        way = self.law.way + (self.ball * self.law.turn if spins else 0.0)
        first, at, last = (np.interp(t, self.law.knots, way) for t in (low, middle, high))
        return np.maximum(at - first, last - at)

    def gaps(self, time: float, points: Array) -> Array:
        """Return signed distances (k,) of points (k, 3) of the world at a time."""
        centre, turn = self.poses(np.array([time], dtype=float))
        return point_gaps(self.shape, (points - centre) @ turn[0])


def bodies_of(given: Sequence[dict[str, Any]], end: float) -> list[Body]:
    """Return the bodies of a situation, with bounds of their ways up to a time [s]."""
    shapes = [ready(body["shape"]) for body in given]
    return [
        Body(body["name"], body["role"], shape, law_of(body["motion"], end), ball_of(shape), body)
        for body, shape in zip(given, shapes, strict=True)
    ]


def into(centre: Array, turn: Array, points: Array) -> Array:
    """Return points (k, 3) of the world in frames of centres (k, 3) and rotations (k, 3, 3)."""
    return np.einsum("kij,ki->kj", turn, points - centre)
