"""Families by name, with ranges that a specification changes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from gcm_learn.errors import SpecError
from gcm_learn.families import random_planar
from gcm_learn.situation import Situation


@dataclass(frozen=True)
class RandomPlanar:
    """Planar situations without a theme."""

    bodies: tuple[int, int] = (1, 5)

    def draw(self, rng: np.random.Generator, name: str) -> Situation:
        """Draw a situation."""
        return random_planar(rng, self.bodies, name)


def family_names() -> list[str]:
    """Names of the families."""
    return ["random-planar"]


def get_family(name: str, config: Mapping[str, Any]) -> RandomPlanar:
    """A family with some ranges changed."""
    for key in config:
        if key != "bodies":
            raise SpecError(key, "is not a range of random-planar (known: bodies)")
    return RandomPlanar(**{key: tuple(value) for key, value in config.items()})
