"""Hands of arms in the world's coordinates, by kind of arm."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from gcm_learn.arms import PLANAR, SPATIAL, ByKind, rotation_of
from gcm_learn.situation import AnySituation

Placing = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class _Turned:
    """Turn a canonical hand as its situation was drawn; plain floats, since steps are short."""

    rows: list[list[float]]

    def __call__(self, hand: np.ndarray) -> np.ndarray:
        (a, b), (c, d) = self.rows
        x, y = hand.item(0), hand.item(1)
        return np.array((a * x + b * y, c * x + d * y))


@dataclass(frozen=True)
class _Based:
    """Place a hand that is given in the frame of its arm's base."""

    turn: np.ndarray
    origin: np.ndarray

    def __call__(self, hand: np.ndarray) -> np.ndarray:
        placed: np.ndarray = self.turn @ hand + self.origin
        return placed


def _turned(situation: AnySituation, frame: Any) -> Placing:
    return _Turned(frame.original(np.eye(2)).T.tolist())


def _based(situation: Any, frame: Any) -> Placing:
    base = situation.arm.base
    return _Based(rotation_of(base.rotation), np.asarray(base.origin))


_PLACINGS: ByKind[Callable[[Any, Any], Placing]] = ByKind({PLANAR: _turned, SPATIAL: _based})


def placing_of(situation: AnySituation, frame: Any) -> Placing:
    """Return the function from a hand in the arena's coordinates to the world's.

    Parameters
    ----------
    situation : Situation
        As the arena has it.
    frame : Frame
        Frame in which it was drawn.
    """
    return _PLACINGS.of(situation)(situation, frame)
