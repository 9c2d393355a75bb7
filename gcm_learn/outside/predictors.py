"""Predictors by name: laws of motion that predict a track from its observed part."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from gcm_learn.errors import FieldError, UnknownNameError
from gcm_learn.outside.ball_flight import GRAVITY, flights, pieces_of
from gcm_learn.outside.tracks import Window
from gcm_learn.situation import Piece, Piecewise, SolidQuadratic

Law = SolidQuadratic | Piecewise
STILL, DOWN = (0.0, 0.0, 0.0), (0.0, 0.0, -GRAVITY)
PREDICTORS = {
    "rest": (0, STILL),
    "velocity": (1, STILL),
    "acceleration": (2, STILL),
    "gravity": (1, DOWN),
    "ball": (1, DOWN),
}
"""Degree in time of what is fitted to looks, and the acceleration beside it, by name.

Balls are those of table tennis, which fly on with drag and bounces; their spin is not seen.
"""


def _state(window: Window, degree: int, pull: np.ndarray) -> np.ndarray:
    """Return place, velocity and acceleration (3, 3) at time 0, by least squares."""
    if window.velocity is not None:
        return np.stack([window.seen[-1], window.velocity * (degree > 0), pull])
    falls = 0.5 * np.outer(window.looks**2, pull)
    rows = np.polynomial.polynomial.polyfit(window.looks, window.seen - falls, degree)
    rows = np.vstack([rows, np.zeros((2 - degree, 3))])
    return np.stack([rows[0], rows[1], pull + 2.0 * rows[2]])


def laws_of(windows: Sequence[Window], predictor: str) -> list[Law]:
    """Return the predicted motion law of each window; all windows have the same horizon.

    Raises
    ------
    UnknownNameError, FieldError
        If there is no such predictor, or it needs more looks.
    """
    if predictor not in PREDICTORS:
        raise UnknownNameError.among("predictor", predictor, PREDICTORS)
    degree, pull = PREDICTORS[predictor]
    seen = len(windows[0].looks) if windows[0].velocity is None else 2
    if seen <= degree:
        raise FieldError("looks", f"predictor {predictor!r} needs {degree + 1} (got {seen})")
    states = np.array([_state(window, degree, np.array(pull)) for window in windows])
    if predictor != "ball":
        rows: Any = states.tolist()
        return [SolidQuadratic(*map(tuple, row)) for row in rows]
    states[:, 2] = 0.0
    flown = flights(states.reshape(-1, 9), float(windows[0].times[-1]))
    return [Piecewise(tuple(pieces_of(one))) for one in flown]


def places_of(law: Law, times: np.ndarray) -> np.ndarray:
    """Return the places (m, 3) of a law at times (m,) [s]."""
    rows = (law if isinstance(law, Piecewise) else Piecewise((Piece(0.0, law),))).arrays
    k = np.searchsorted(rows.start, times, side="right") - 1
    s = (times - rows.start[k])[:, None]
    return np.asarray(rows.position[k] + rows.velocity[k] * s + 0.5 * rows.acceleration[k] * s * s)
