"""Families of situations that depend on a few parameters, each linearly."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from gcm_learn.errors import FamilyError
from gcm_learn.situation import (
    AnySituation,
    Body,
    PlanarQuadratic,
    SolidQuadratic,
    situation_to_json,
)
from gcm_learn.storage import content_hash

SAME = 1e-9
"""Largest difference between a situation and its copy in a family."""
_LAW = ("position", "velocity", "acceleration")


@dataclass(frozen=True)
class Parameter:
    """A number that situations of a family differ in."""

    name: str
    low: float
    high: float
    unit: str
    moves: tuple[tuple[str, str, tuple[float, ...]], ...]
    """Bodies by name, `position` or `velocity`, and its change for a unit of the parameter."""


@dataclass(frozen=True)
class ParametricFamily:
    """Situations that differ in a few numbers, on which motions of bodies depend linearly.

    Shapes, orientations and the arm are as in `middle`; the horizon is as long or longer.
    """

    name: str
    summary: str
    middle: AnySituation
    """The situation in which every parameter is in the middle of its range."""
    parameters: tuple[Parameter, ...]
    """Free parameters."""

    @cached_property
    def low(self) -> np.ndarray:
        """(K,) float: lowest values of the parameters."""
        return np.array([parameter.low for parameter in self.parameters])

    @cached_property
    def high(self) -> np.ndarray:
        """(K,) float: highest values of the parameters."""
        return np.array([parameter.high for parameter in self.parameters])

    @cached_property
    def centre(self) -> np.ndarray:
        """(K,) float: middle of the box."""
        return 0.5 * (self.low + self.high)

    @cached_property
    def numbers(self) -> np.ndarray:
        """(bodies, 3, dim) float: position, velocity and acceleration in the middle."""
        return law_numbers(self.middle)

    @cached_property
    def slopes(self) -> np.ndarray:
        """(K, bodies, 3, dim) float: derivatives of these numbers by the parameters."""
        names = [body.name for body in self.middle.bodies]
        out = np.zeros((len(self.parameters), *self.numbers.shape))
        for k, parameter in enumerate(self.parameters):
            for body, law, change in parameter.moves:
                out[k, names.index(body), _LAW.index(law)] += change
        return out

    @cached_property
    def digest(self) -> str:
        """Hash of all that the family's situations follow from."""
        about = [self.name, situation_to_json(self.middle)]
        boxes = [self.low.tolist(), self.high.tolist(), self.slopes.tolist()]
        return content_hash(json.dumps([about, boxes]))

    def free(self, count: int) -> ParametricFamily:
        """Return the family in which only the first parameters are free.

        Raises
        ------
        FamilyError
            If it has not as many parameters.
        """
        most = len(self.parameters)
        if not 1 <= count <= most:
            raise FamilyError("free", f"{self.name!r} has 1 to {most} parameters (got {count})")
        return replace(self, parameters=self.parameters[:count])

    def situation(self, theta: np.ndarray, name: str = "") -> Any:
        """Return the situation of parameters theta (K,)."""
        numbers = self.numbers + np.tensordot(theta - self.centre, self.slopes, 1)
        bodies = (
            replace(body, motion=replace(body.motion, **_law_of(rows)))
            for body, rows in zip(self.middle.bodies, numbers.tolist(), strict=True)
        )
        return replace(self.middle, name=name or self.name, bodies=tuple(bodies))

    def drifts(self, time: np.ndarray) -> np.ndarray:
        """Derivatives (n, K, bodies, dim) of all bodies' places by the parameters at times (n,)."""
        t = time[:, None, None, None]
        return self.slopes[None, :, :, 0] + t * self.slopes[None, :, :, 1]

    def parameters_of(self, situation: AnySituation) -> np.ndarray | None:
        """Return the parameters (K,) of a situation; None if it is of another family."""
        middle, bodies = self.middle, situation.bodies
        if situation.arm != middle.arm or situation.horizon < middle.horizon - SAME:
            return None
        if situation.catch != middle.catch or situation.plane != middle.plane:
            return None
        if [_unchanged(body) for body in bodies] != self._kept:
            return None
        given = (law_numbers(situation) - self.numbers).reshape(-1)
        change = self._inverse @ given
        if np.abs(given - change @ self._flat).max() > SAME:
            return None
        theta: np.ndarray = self.centre + change
        return theta

    @cached_property
    def _kept(self) -> list[Any]:
        return [_unchanged(body) for body in self.middle.bodies]

    @cached_property
    def _flat(self) -> np.ndarray:
        return self.slopes.reshape(len(self.parameters), -1)

    @cached_property
    def _inverse(self) -> np.ndarray:
        return np.linalg.pinv(self._flat.T)


def law_numbers(situation: AnySituation) -> np.ndarray:
    """Position, velocity and acceleration (bodies, 3, dim) of a situation's bodies."""
    rows: list[Any] = [
        (body.motion.position, body.motion.velocity, body.motion.acceleration)  # type: ignore[union-attr]
        for body in situation.bodies
    ]
    return np.array(rows)


def _law_of(rows: list[list[float]]) -> dict[str, Any]:
    """Return fields of a motion from the rows (3, dim) of its numbers."""
    return {name: tuple(row) for name, row in zip(_LAW, rows, strict=True)}


def _unchanged(body: Body) -> tuple[Any, ...]:
    """Return all of a body that parameters do not change, but for its name."""
    motion = body.motion
    turns: tuple[Any, ...] = ()
    if isinstance(motion, PlanarQuadratic):
        turns = (motion.angle, motion.spin)
    elif isinstance(motion, SolidQuadratic):
        turns = (motion.orientation, motion.spin)
    return body.role, body.shape, body.approach, type(motion), turns
