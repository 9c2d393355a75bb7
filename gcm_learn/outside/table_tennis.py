"""Measured states of table-tennis balls: each becomes a ball that flies to an arm."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from gcm_learn.arms import Base, Chain, rotation_of
from gcm_learn.checks import non_negative, positive
from gcm_learn.errors import FileFormatError
from gcm_learn.outside.ball_flight import HEIGHT, NET, RADIUS, TABLE, Flight, flights, pieces_of
from gcm_learn.outside.converted import REST, Converted, is_blocked, model_named
from gcm_learn.outside.nodes import Node, json_nodes
from gcm_learn.situation import Body, Box, Piecewise, Situation, SolidQuadratic, Sphere

FILES = r".+\.json(\.gz)?"
FIELDS = tuple(f"{name}_{axis}" for name in ("pos", "vel", "w_vel") for axis in "xyz")
"""Place [m], velocity [m/s] and spin [rad/s] in files."""
BASE = (0.0, -1.82, -0.2)
"""Default base: 0.45 m behind the end of the table, 0.2 m below its surface [m]."""
FACING = (math.sqrt(0.5), 0.0, 0.0, math.sqrt(0.5))
"""Rotation of the base, which turns its x axis to the table."""
READY = {"panda": (0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785)}
"""Start postures of arms; others begin in the middle of their ranges."""
RACKET = 0.075
"""Default distance of hand and ball at which it is caught, the radius of a racket [m]."""
SLAB = 0.0125
"""Half the thickness of the table's top [m]."""
LARGEST = 1e4
"""Largest number of a state; balls spin with some hundred rad/s."""
CHUNK = 256
"""Balls that are integrated together."""
NET_STOPS, PASSES = "the ball meets the net (left out)", "the ball stays out of reach (left out)"


@dataclass(frozen=True)
class TableTennis:
    """Settings of a conversion.

    Parameters
    ----------
    arm : str
        Name of an arm that ships or an arm file.
    base : (3,) tuple of float
        Place of the arm's base in the frame of the table: origin at the centre of its surface, x
        along the net, y along the table [m].  Its x axis points along y.
    horizon : float
        Longest one; a situation ends when the ball leaves the reach for good [s].
    grasp : float
        Distance of hand and ball at which it is caught [m].
    """

    arm: str = "panda"
    base: tuple[float, float, float] = BASE
    horizon: float = 2.0
    grasp: float = RACKET

    summary: ClassVar[str] = "measured states of table-tennis balls"

    def convert(self, sources: Sequence[Path]) -> Converted:
        """Return a situation for each ball that comes within reach."""
        positive(self.horizon, "horizon")
        arm, result = self._arm(), Converted()
        balls = balls_of(json_nodes(sources, FILES, result.leaving_out), result)
        names, states = list(balls), np.array(list(balls.values())).reshape(-1, len(FIELDS))
        for first in range(0, len(balls), CHUNK):
            chosen = slice(first, first + CHUNK)
            flown = flights(facing(states[chosen]), self.horizon)
            for name, flight in zip(names[chosen], flown, strict=True):
                self._add(name, flight, arm, result)
        if not result.at_least_one().situations:
            raise FileFormatError(f"{sources[0]}: no ball comes within the arm's reach")
        blocked = is_blocked(result.situations[0])  # the arm and the table are the same in all
        for _ in result.situations:
            result.count("the start is blocked", blocked)
        return result

    def _arm(self) -> Chain:
        model = model_named(self.arm)
        middle = tuple(0.5 * (low + high) for low, high in model.ranges)
        return Chain(
            model,
            READY.get(model.name, middle),
            non_negative(self.grasp, "grasp"),
            Base(self.base, FACING),
        )

    def _add(self, name: str, flown: list[Flight], arm: Chain, result: Converted) -> None:
        """Add the situation of a ball, or count the reason for leaving the ball out."""
        flown = above_floor(flown)
        if result.count(NET_STOPS, meets_net(flown)):
            return
        horizon = last_in_reach(flown, arm)
        if result.count(PASSES, horizon <= 0.0):
            return
        pieces = [piece for piece in pieces_of(flown) if piece.start < horizon]
        ball = Body("target", "ball", Sphere(RADIUS), Piecewise(tuple(pieces)))
        result.situations.append(Situation(name, horizon, arm, (ball, table())))


def balls_of(nodes: Iterator[Node], result: Converted) -> dict[str, list[float]]:
    """Return the states of balls by name: of their `id`, or of their number."""
    found: dict[str, list[float]] = {}
    for node in nodes:
        rows: Sequence[Node] = ()
        with result.leaving_out():
            rows = node.rows()
        for row in rows:
            with result.leaving_out():
                given = row.find("id") if "id" in row.members() else None
                number = len(found) + len(result.left_out)
                name = f"ball-{row.value['id'] if given is not None else number}"
                if name in found:
                    raise row.inside("id").error("is given twice")
                found[name] = _state(row)
    return found


def _state(row: Node) -> list[float]:
    values = [row.at(name).number() for name in FIELDS]
    for name, value in zip(FIELDS, values, strict=True):
        if abs(value) > LARGEST:
            raise row.inside(name).error(f"is too large ({value:g}, max {LARGEST:g})")
    return values


def facing(states: np.ndarray) -> np.ndarray:
    """Return states (n, 9), with balls that fly along +y turned by half a turn about z.

    All balls then fly towards the same end of the table.
    """
    turn = np.where(states[:, 4:5] > 0.0, -1.0, 1.0)
    sign = np.ones((1, 3, 3)) * np.array([1.0, 1.0, 0.0]) * turn[:, :, None]
    sign[:, :, 2] = 1.0
    return states * sign.reshape(len(states), -1)


def above_floor(flown: list[Flight]) -> list[Flight]:
    """Cut flights at the floor; the last flight ends at the step before."""
    made = []
    for flight in flown:
        low = np.flatnonzero(flight.places[:, 2] < RADIUS - HEIGHT)
        if not low.size:
            made.append(flight)
            continue
        if low[0] > 1:
            made.append(Flight(flight.times[: low[0]], flight.places[: low[0]]))
        break
    return made


def meets_net(flown: list[Flight]) -> bool:
    """Return whether a ball crosses the middle of the table through the net."""
    for flight in flown:
        y = flight.places[:, 1]
        for k in np.flatnonzero((y[:-1] > 0.0) & (y[1:] <= 0.0)):
            share = y[k] / (y[k] - y[k + 1])
            x, _, z = flight.places[k] + share * (flight.places[k + 1] - flight.places[k])
            if abs(x) <= NET[0] + RADIUS and 0.0 <= z <= NET[1] + RADIUS:
                return True
    return False


def last_in_reach(flown: list[Flight], arm: Chain) -> float:
    """Return the last time at which a ball is within reach, 0 if never [s].

    Reach counts from the first joint, and bounds that of the hand.
    """
    first = arm.model.joints[0].origin
    radius = arm.reach - math.hypot(*first) + arm.grasp + RADIUS
    centre = np.array(arm.base.origin) + rotation_of(arm.base.rotation) @ np.array(first)
    last = 0.0
    for flight in flown:
        near = np.flatnonzero(((flight.places - centre) ** 2).sum(axis=1) <= radius**2)
        if near.size:
            last = float(flight.times[near[-1]])
    return last


def table() -> Body:
    """Return the table's top."""
    place = SolidQuadratic((0.0, 0.0, -SLAB), REST, REST)
    return Body("obstacle", "table", Box((TABLE[0], TABLE[1], SLAB)), place)
