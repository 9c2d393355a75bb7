"""Neighbours by principal components of maps: a control without a network.

A memory is filed under the components of its situation's map. A query must not know its own map, so
where it would lie is predicted from its raw parameters by ridge regression, linear in them and in
cosines of random combinations of them (Rahimi and Recht, NIPS 2007).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

import numpy as np

from gcm_learn import seeding
from gcm_learn.maps import build_map
from gcm_learn.recall.index import (
    Scale,
    hash_of,
    nearest_query,
    nearest_rows,
    read_arrays,
    write_arrays,
)
from gcm_learn.recall.raw_features import COUNT, raw_features
from gcm_learn.recall.waypoints import Trace
from gcm_learn.scene.scene import Scene
from gcm_learn.situation import Situation
from gcm_learn.situation.canonical import canonical
from gcm_learn.wave import MarchingParams

N = 40  # cells along a side of the maps
COMPONENTS = 24
SPARE, ITERATIONS = 8, 8  # of the subspace iteration
COSINES = 512
WIDTH = 6.0  # of the cosines' kernel [spreads of a parameter]
RIDGE = 3.0  # weight of the penalty
_NAMES = ("mean", "spread", "centre", "components", "waves", "phases", "weights")


def map_picture(situation: Situation) -> np.ndarray:
    """Map of a situation in its canonical frame, as numbers (2 N N,) float32.

    Arrival as a share of the horizon, 1 where there is none, and the effective obstacles.
    """
    turned, _ = canonical(situation)
    made = build_map(turned, MarchingParams(n=N))
    arrival = np.minimum(made.arrival.filled(np.inf) / situation.horizon, 1.0)
    return np.concatenate([arrival.ravel(), made.effective_obstacles.ravel()]).astype(np.float32)


@dataclass(frozen=True)
class PcaIndex:
    """Principal components of maps; a query's are predicted from its raw parameters."""

    scale: Scale
    centre: np.ndarray
    """(2 N N,): mean of the maps."""
    components: np.ndarray
    """(COMPONENTS, 2 N N)"""
    waves: np.ndarray
    """(COUNT, COSINES)"""
    phases: np.ndarray
    """(COSINES,) [rad]"""
    weights: np.ndarray
    """(COUNT + COSINES + 1, COMPONENTS)"""
    name: ClassVar[str] = "pca"

    @classmethod
    def fit(cls, situations: Sequence[Situation], seed: int = 0) -> PcaIndex:
        """Components of the situations' maps, and the regression from raw parameters to them."""
        pictures = np.array([map_picture(s) for s in situations])
        features = np.array([raw_features(s) for s in situations])
        centre = pictures.mean(axis=0)
        scale, rng = Scale.of(features), seeding.rng(seed)
        components = _components(pictures - centre, rng)
        waves = (rng.standard_normal((COUNT, COSINES)) / WIDTH).astype(np.float32)
        phases = rng.uniform(0.0, 2.0 * np.pi, COSINES).astype(np.float32)
        inputs = _inputs(scale(features), waves, phases).astype(float)
        places = (pictures - centre) @ components.T
        penalty = RIDGE * np.eye(inputs.shape[1])
        weights = np.linalg.solve(inputs.T @ inputs + penalty, inputs.T @ places)
        return cls(scale, centre, components, waves, phases, weights.astype(np.float32))

    @property
    def key(self) -> str:
        """Hash of all its numbers."""
        return hash_of(self.name, *self._arrays())

    @property
    def dim(self) -> int:
        """The components and one number for their distance."""
        return len(self.components) + 1

    def embed_query(self, situation: Situation, scene: Scene | None = None) -> np.ndarray:
        """Where the map of a situation probably lies."""
        features = self.scale(raw_features(situation, scene)[None])
        return nearest_query((_inputs(features, self.waves, self.phases) @ self.weights)[0])

    def embed_memory(self, situation: Situation, trace: Trace) -> np.ndarray:
        """Where the map of a memory lies."""
        return self.embed_memories([situation], [trace])[0]

    def embed_memories(
        self, situations: Sequence[Situation], traces: Sequence[Trace]
    ) -> np.ndarray:
        """Where the maps of memories lie."""
        rows = [self.components @ (map_picture(s) - self.centre) for s in situations]
        return nearest_rows(np.array(rows).reshape(-1, len(self.components)))

    def save(self, folder: Path) -> None:
        """Write its numbers."""
        write_arrays(folder, dict(zip(_NAMES, self._arrays(), strict=True)))

    @classmethod
    def load(cls, folder: Path) -> PcaIndex:
        """Read its numbers."""
        mean, spread, *rest = read_arrays(folder, _NAMES)
        return cls(Scale(mean, spread), *rest)

    def _arrays(self) -> tuple[np.ndarray, ...]:
        regression = (self.waves, self.phases, self.weights)
        return (self.scale.mean, self.scale.spread, self.centre, self.components, *regression)


def _components(pictures: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """First principal components (at most COMPONENTS, m) of centred pictures (n, m).

    By subspace iteration, with a few more directions than are wanted.
    """
    count = min(COMPONENTS, *pictures.shape)
    extra = min(count + SPARE, *pictures.shape)
    basis = rng.standard_normal((pictures.shape[1], extra)).astype(np.float32)
    for _ in range(ITERATIONS):
        basis = np.linalg.qr(pictures.T @ (pictures @ basis))[0]
    _, _, turn = np.linalg.svd(pictures @ basis, full_matrices=False)
    return (turn[:count] @ basis.T).astype(np.float32)


def _inputs(scaled: np.ndarray, waves: np.ndarray, phases: np.ndarray) -> np.ndarray:
    """What the regression is linear in (n, COUNT + COSINES + 1)."""
    cosines = np.cos(scaled @ waves + phases) * np.sqrt(2.0 / len(phases))
    return np.hstack([scaled, cosines, np.ones((len(scaled), 1), dtype=np.float32)])
