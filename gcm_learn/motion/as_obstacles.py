"""Movements of arms as obstacles of other arms: capsules that surely hold every link."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from gcm_learn.arms import CHAIN, ByKind, Chain, links_along
from gcm_learn.motion.movement import Movement
from gcm_learn.situation import Body, Capsule, Sampled, SolidQuadratic, Sphere

ERROR = 1e-3  # of links between samples, by which capsules are thicker [lengths]
TINY = 1e-9  # shorter axes are those of balls
MOST_SAMPLES = 100_000  # of one link


def as_obstacles(movement: Movement, name: str, error: float = ERROR) -> tuple[Body, ...]:
    """Return bodies that hold the links of an arm during a movement, and at rest afterwards.

    A body is a link's capsule whose pose is sampled. Between samples its centre goes straight and
    its axis turns evenly. A point of the link strays from the straight line by at most
    ``a dt^2 / 8``, where ``a`` bounds its acceleration. The capsule is thicker by `error`. Samples
    are so dense that links stray less.

    Parameters
    ----------
    movement : Movement
        Of a chain or spatial arm, e.g. `plan.trajectory`, with the rest of an arm that goes on
        moving after the catch; see `with_stop`.
    name : str
        Bodies are called ``NAME link 0`` and so on.
    error : float
        [lengths]

    Returns
    -------
    tuple of Body
        Obstacles, in the order of the arm's links.

    Raises
    ------
    ArmKindError
        If the arm is planar.
    ValueError
        If the error is not above 0, or so small that a link needs too many samples.
    """
    if not error > 0.0:
        raise ValueError(f"error: must be above 0 (got {error})")
    levers, factors = _LEVERS.of(movement.arm)(movement.arm)
    ends, radii = links_along(movement.arm, movement.joints[:1])
    half = 0.5 * np.linalg.norm(ends[0, :, 1] - ends[0, :, 0], axis=1)
    bodies = []
    for k, (lever, radius) in enumerate(zip(levers, radii, strict=True)):
        times = _times(movement, lever, factors, float(half[k]), error)
        there = links_along(movement.arm, movement.joints_at(times))[0][:, k]
        shape = _shape(float(radius) + error, float(half[k]))
        bodies.append(Body("obstacle", f"{name} link {k}", shape, _motion(times, there)))
    return tuple(bodies)


def _shape(radius: float, half: float) -> Capsule | Sphere:
    return Capsule(radius, half) if half > TINY else Sphere(radius)


def _motion(times: np.ndarray, ends: np.ndarray) -> Sampled | SolidQuadratic:
    """Return the motion of a capsule with ends (n, 2, 3), which its z axis joins."""
    centres = ends.mean(axis=1)
    turns = _orientations(ends[:, 1] - ends[:, 0])
    if len(times) == 1 or (np.ptp(ends, axis=0) == 0.0).all():
        still = (0.0, 0.0, 0.0)
        return SolidQuadratic(tuple(centres[0].tolist()), still, still, tuple(turns[0].tolist()))
    rows: Any = (tuple(map(tuple, part.tolist())) for part in (centres, turns))
    return Sampled(tuple(times.tolist()), *rows)


def _orientations(axes: np.ndarray) -> np.ndarray:
    """Return quaternions (n, 4) that turn z to axes (n, 3), each the short way from the last."""
    quaternion, now = np.array([1.0, 0.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0])
    found = np.empty((len(axes), 4))
    for k, axis in enumerate(axes):
        length = float(np.linalg.norm(axis))
        if length > TINY:
            there = axis / length
            quaternion = _product(_between(now, there), quaternion)
            quaternion, now = quaternion / np.linalg.norm(quaternion), there
        found[k] = quaternion
    return found


def _between(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the quaternion of the shortest turn from one unit vector to another."""
    w = 1.0 + float(a @ b)
    if w < 1e-12:  # half a turn, about any axis across
        across = np.cross(a, np.eye(3)[np.argmin(np.abs(a))])
        return np.append(0.0, across / np.linalg.norm(across))
    turn = np.append(w, np.cross(a, b))
    return turn / np.linalg.norm(turn)


def _product(p: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Return the quaternion of a turn q followed by a turn p."""
    w = p[0] * q[0] - p[1:] @ q[1:]
    return np.append(w, p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:]))


def _times(
    movement: Movement, lever: np.ndarray, factors: np.ndarray, half: float, error: float
) -> np.ndarray:
    """Return times (n,) between which a link strays by less than `error`.

    Parameters
    ----------
    lever : (2, m) ndarray
    factors : (m, dof) ndarray
        See `_of_chain`.
    half : float
        Half of the length of the link's axis.
    """
    times = [movement.time[:1]]
    for k in range(movement.time.size - 1):
        start, end = movement.time[k], movement.time[k + 1]
        speeds, forces = (factors @ most for most in _bounds(movement, k))
        before = np.cumsum(speeds) - speeds
        bend = float(np.sum(speeds * (2.0 * before + speeds) * lever[0]) + forces @ lever[0])
        turn = float(speeds @ lever[1])
        # The axis strays from a chord by turn^2 dt^2 / 8 of its half length.
        steps = math.ceil((end - start) * math.sqrt((bend + half * turn * turn) / (8.0 * error)))
        steps = max(steps, math.ceil(turn * (end - start) / 1.5), 1)  # far from half a turn
        if steps > MOST_SAMPLES:
            raise ValueError(f"error: {error:g} takes over {MOST_SAMPLES} samples of a link")
        times.append(np.linspace(start, end, steps + 1)[1:])
    return np.concatenate(times)


def _bounds(movement: Movement, k: int) -> tuple[np.ndarray, np.ndarray]:
    """Bound rates and accelerations (dof,) of the joints between samples k and k + 1."""
    span = movement.time[k + 1] - movement.time[k]
    rise = (movement.joints[k + 1] - movement.joints[k]) / span
    if movement.rates is None:
        return np.abs(rise), np.zeros_like(rise)
    first, last = movement.rates[k], movement.rates[k + 1]
    middle = 3.0 * rise - 0.5 * (first + last)  # control points of the quadratic of rates
    speeds = np.abs([first, middle - 0.5 * (first + last), last]).max(axis=0)
    begins, ends = 6.0 * rise - 4.0 * first - 2.0 * last, 2.0 * first + 4.0 * last - 6.0 * rise
    return speeds, np.abs([begins / span, ends / span]).max(axis=0)


def _of_chain(arm: Chain) -> tuple[np.ndarray, np.ndarray]:
    """Return bounds of the joints' effects on each link (links, 2, m), and |`factors`| (m, dof).

    The first row bounds the distance of the link's points to a turning joint. It is 1 for a sliding
    joint and 0 for joints beyond the link. The second row is 1 for joints that turn the link.
    """
    joints, found = arm.model.joints, []
    for link in arm.model.links:
        row = np.zeros((2, len(joints)))
        away = max(math.hypot(*link.start), math.hypot(*link.end))
        for j in reversed(arm.model.path(link.joint)):
            slides = joints[j].type == "prismatic"
            row[:, j] = (1.0, 0.0) if slides else (away, 1.0)
            if slides:
                away += arm.farthest(j)
            away += math.hypot(*joints[j].origin)
        found.append(row)
    return np.array(found), np.abs(arm.model.factors)


_LEVERS: ByKind[Callable[[Any], tuple[np.ndarray, np.ndarray]]] = ByKind({CHAIN: _of_chain})
