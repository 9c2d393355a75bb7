"""MotionBenchMaker in motion: bodies on belts and turntables, and bodies that fly through.

The recipe, of which every number comes from one generator:

1. A meeting time is drawn, at which everything is where the original problem has it.
2. The target and the small bodies at its height ride a belt or a turntable, each for half of the
   problems.  A belt runs to and fro along a horizontal line.  A turntable turns about a
   vertical axis near the target, and carries the bodies near to it.
3. Two to four balls and boxes fly in straight lines past points between the hands of the start and
   of the goal.

A carrier or a flier that would touch the arm at rest in its start posture, at any time up to the
horizon, is drawn again.  Bodies may pass through each other.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Protocol

import numpy as np

from gcm_learn.arms import Chain, hands_along
from gcm_learn.outside.converted import HELD, REST, UNTURNED, stays_free
from gcm_learn.situation import (
    Body,
    Box,
    Piece,
    Piecewise,
    Sampled,
    Situation,
    SolidMotion,
    SolidQuadratic,
    SolidShape,
    Sphere,
)

MEETING = (0.35, 0.65)  # share of the horizon at which all is in its original place
LEVEL = 0.25  # difference of height to the target of a body that is carried [m]
SPEED = (0.05, 0.2)  # of a belt [m/s]
STROKE = (0.05, 0.2)  # of a belt, to either side [m]
RATE = (0.2, 0.8)  # of a turntable, either way [rad/s]
AXIS = 0.15  # horizontal distance of a turntable's axis from the target, at most [m]
TABLE = 0.4  # radius of a turntable [m]
TURN = 0.1  # of a turntable between two samples [rad]
FLIERS = (2, 4)
SIZE = (0.03, 0.06)  # radius of a ball, half an edge of a box [m]
FLIGHT = (0.3, 1.0)  # speed [m/s]
SPREAD = 0.15  # of the points that fliers pass, standard deviation [m]
SPIN = 2.0  # of a box, standard deviation about each axis [rad/s]
TRIES = 40  # of drawing a carrier or a flier

Vector = tuple[float, float, float]


class Carrier(Protocol):
    """Belt or turntable."""

    def carries(self, place: Vector) -> bool:
        """Return whether a body at `place` lies on the belt or turntable."""

    def motion(self, at: SolidQuadratic) -> SolidMotion:
        """Return the motion of a carried body that is at pose `at` at the meeting time."""


class Belt:
    """Belt that runs to and fro along a horizontal line."""

    def __init__(self, generator: np.random.Generator, meeting: float, horizon: float) -> None:
        angle = generator.uniform(0.0, 2.0 * math.pi)
        self._speed, self._stroke = generator.uniform(*SPEED), generator.uniform(*STROKE)
        self._along = np.array([math.cos(angle), math.sin(angle), 0.0])
        self._meeting, self._horizon = meeting, horizon

    def carries(self, place: Vector) -> bool:
        """Return True: the belt is as long as the scene."""
        return True

    def motion(self, at: SolidQuadratic) -> Piecewise:
        """Return pieces of constant velocity, one for each run of the belt to or fro."""
        way = self._stroke / self._speed  # from the middle to an end [s]
        first = math.floor((way - self._meeting) / (2.0 * way)) + 1
        starts, k = [0.0], first
        while (turn := self._meeting + (2 * k - 1) * way) < self._horizon:
            if turn > 0.0:
                starts.append(turn)
            k += 1
        pieces = [Piece(start, self._piece(at, start)) for start in starts]
        return Piecewise(tuple(pieces))

    def _piece(self, at: SolidQuadratic, start: float) -> SolidQuadratic:
        """Return the motion from a start on; phase 0 is the middle, on the way out."""
        way = self._stroke / self._speed
        phase = ((start - self._meeting) / way + 1.0 + 1e-9) % 4.0
        out = phase < 2.0
        offset = self._stroke * (phase - 1.0 if out else 3.0 - phase)
        place = np.array(at.position) + offset * self._along
        velocity = (self._speed if out else -self._speed) * self._along
        return SolidQuadratic(tuple(place.tolist()), tuple(velocity.tolist()), REST, at.orientation)


class Turntable:
    """Turntable about a vertical axis near the target."""

    def __init__(
        self, generator: np.random.Generator, meeting: float, horizon: float, target: Vector
    ) -> None:
        rate = generator.uniform(*RATE) * generator.choice([-1.0, 1.0])
        distance, angle = AXIS * math.sqrt(generator.random()), generator.uniform(0.0, 2 * math.pi)
        self._centre = np.array(
            [target[0] + distance * math.cos(angle), target[1] + distance * math.sin(angle)]
        )
        count = math.ceil(abs(rate) * horizon / TURN) + 1
        self._times = np.linspace(0.0, horizon, count)
        self._angles = rate * (self._times - meeting)

    def carries(self, place: Vector) -> bool:
        """Return whether a place is over the table."""
        return math.dist(self._centre, place[:2]) <= TABLE

    def motion(self, at: SolidQuadratic) -> Sampled:
        """Return poses along the turn."""
        x, y = np.array(at.position[:2]) - self._centre
        c, s = np.cos(self._angles), np.sin(self._angles)
        places = np.stack([c * x - s * y, s * x + c * y], axis=1) + self._centre
        heights = np.full((len(c), 1), at.position[2])
        turns = [_turned_level(at.orientation, angle) for angle in self._angles.tolist()]
        return Sampled(
            tuple(self._times.tolist()), _rows(np.hstack([places, heights])), tuple(turns)
        )


def _rows(array: np.ndarray) -> tuple[Vector, ...]:
    return tuple((x, y, z) for x, y, z in array.tolist())


def _turned_level(q: Sequence[float], angle: float) -> tuple[float, float, float, float]:
    """Return an orientation (w, x, y, z) turned about the vertical."""
    (w, x, y, z), c, s = q, math.cos(0.5 * angle), math.sin(0.5 * angle)
    turned = (c * w - s * z, c * x - s * y, c * y + s * x, c * z + s * w)
    length = math.hypot(*turned)
    return (turned[0] / length, turned[1] / length, turned[2] / length, turned[3] / length)


def in_motion(
    problem: Situation[Chain],
    goal: Sequence[float],
    generator: np.random.Generator,
    blocked: bool = False,
) -> Situation[Chain]:
    """Return a problem at rest, set in motion; the module explains the recipe.

    Parameters
    ----------
    problem : Situation
        One target and obstacles that rest.
    goal : (n,) sequence of float
        Posture of the original goal.
    generator : numpy.random.Generator
    blocked : bool
        Whether the start is blocked anyhow, so that it cannot be kept free.
    """
    meeting = generator.uniform(*MEETING) * problem.horizon
    result = problem
    for _ in range(TRIES):
        result = _carried(problem, meeting, generator)
        if blocked or stays_free(result):
            break
    else:
        result = problem
    for k in range(int(generator.integers(FLIERS[0], FLIERS[1] + 1))):
        for _ in range(TRIES):
            flier = _flier(f"flier {k + 1}", problem, goal, generator)
            more = replace(result, bodies=(*result.bodies, flier))
            if blocked or stays_free(more):
                result = more
                break
    return result


def _carried(
    problem: Situation[Chain], meeting: float, generator: np.random.Generator
) -> Situation[Chain]:
    """Return the problem with a belt or a turntable."""
    (target,) = problem.targets
    place = _rest(target).position
    carrier: Carrier = Belt(generator, meeting, problem.horizon)
    if generator.random() < 0.5:
        carrier = Turntable(generator, meeting, problem.horizon, place)
    bodies = [
        replace(body, motion=carrier.motion(_rest(body)))
        if body.role == "target" or _rides(body, place, carrier)
        else body
        for body in problem.bodies
    ]
    return replace(problem, bodies=tuple(bodies))


def _rest(body: Body) -> SolidQuadratic:
    if not isinstance(body.motion, SolidQuadratic):
        raise TypeError(f"{body.name}: must rest")
    return body.motion


def _rides(body: Body, target: Vector, carrier: Carrier) -> bool:
    place = _rest(body).position
    small = body.shape.bounding_radius <= HELD
    return small and abs(place[2] - target[2]) <= LEVEL and carrier.carries(place)


def _flier(
    name: str, problem: Situation[Chain], goal: Sequence[float], generator: np.random.Generator
) -> Body:
    """Return a ball or a box that flies past a point between two hands."""
    hands, _ = hands_along(problem.arm, [problem.arm.joints, goal])
    share, when = generator.random(), generator.uniform(0.1, 0.9) * problem.horizon
    point = hands[0] + share * (hands[1] - hands[0]) + generator.normal(0.0, SPREAD, 3)
    heading = generator.normal(size=3)
    velocity = heading * (generator.uniform(*FLIGHT) / np.linalg.norm(heading))
    size, round_ = generator.uniform(*SIZE), generator.random() < 0.5
    spin = REST if round_ else tuple(generator.normal(0.0, SPIN, 3).tolist())
    shape: SolidShape = Sphere(size) if round_ else Box((size, size, size))
    place, speed = (tuple(v.tolist()) for v in (point - when * velocity, velocity))
    return Body("obstacle", name, shape, SolidQuadratic(place, speed, REST, UNTURNED, spin))
