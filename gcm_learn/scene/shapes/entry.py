"""The record by which a shape enters the rows of bodies."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

Sizes = tuple[float, float, float]


class Entry(NamedTuple):
    """Numbers of a shape in a body's row."""

    number: int
    """Number in the column KIND."""
    sizes: Callable[[Any], Sizes]
    """Sizes in the columns SIZE to SIZE + 2, from a shape of `gcm_learn.situation`."""
    is_ball: bool = False
    """True if the shape is all of the ball that holds it, so that no turn can be seen."""
    is_round: bool = False
    """True if a turn about the z axis cannot be seen."""
    vertices: Callable[[Any], tuple[tuple[float, float], ...]] = lambda _shape: ()
    """Corners in the plane, from a shape of `gcm_learn.situation`."""
