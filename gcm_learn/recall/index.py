"""Indexes: embeddings under which memories are filed, and with which situations ask for them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar, Protocol, Self

import numpy as np

from gcm_learn import seeding
from gcm_learn.errors import EncoderError, RecallError, UnknownNameError
from gcm_learn.recall.encoder import Encoder, load_encoder, save_encoder
from gcm_learn.recall.kinds import MEMORIES, raw_features
from gcm_learn.recall.map_features import planar_map, planar_map_features
from gcm_learn.recall.raw_features import HAND_COUNT, Scale
from gcm_learn.recall.waypoints import Waypoints
from gcm_learn.scene import Scene
from gcm_learn.storage import content_hash, content_number

FILE = "index.npz"
SPARE, ITERATIONS = 8, 8  # of the subspace iteration
COSINES = 512
WIDTH = 6.0  # of the cosines' kernel [spreads of a parameter]
RIDGE = 3.0  # weight of the penalty
_NAMES = ("centre", "components", "waves", "phases", "weights")  # of a PcaIndex' arrays


class Index(Protocol):
    """Embedding of situations and memories in one space: large inner products are good matches.

    A query knows the situation at t = 0 and its laws of motion, and nothing that takes a map.
    """

    name: ClassVar[str]
    """Name under which the index is registered."""

    @property
    def key(self) -> str:
        """Hash of all that embeddings depend on; memories are stamped with it."""

    @property
    def dim(self) -> int:
        """Numbers of an embedding."""

    def embed_query(self, situation: Any, scene: Scene | None = None) -> np.ndarray:
        """Embedding (dim,) float32 of a situation in any frame.

        Parameters
        ----------
        situation : Situation
        scene : Scene, optional
            The situation packed, if the caller has it at hand.
        """

    def embed_memories(
        self, situations: Sequence[Any], trajectories: Sequence[Waypoints]
    ) -> np.ndarray:
        """Embeddings (n, dim) float32 of many memories."""

    def save(self, folder: Path) -> None:
        """Write the index into a folder, for `load`."""

    @classmethod
    def load(cls, folder: Path) -> Self:
        """Read an index from a folder."""

    @classmethod
    def fit(cls, situations: Sequence[Any], seed: int = 0) -> Self:
        """Return an index fitted to situations; raise RecallError if the index takes training."""


class Numbers:
    """Key and file of indexes that are a few arrays of numbers."""

    name: ClassVar[str]

    @property
    def arrays(self) -> dict[str, np.ndarray]:
        """All numbers that embeddings depend on, by name."""
        raise NotImplementedError

    @classmethod
    def of(cls, arrays: Mapping[str, np.ndarray]) -> Self:
        """The index with such numbers."""
        raise NotImplementedError

    @property
    def key(self) -> str:
        """Short hash of the index's name and arrays."""
        parts: list[str | bytes] = [self.name]
        for array in self.arrays.values():
            parts += [repr((array.dtype.str, array.shape)), np.ascontiguousarray(array).tobytes()]
        return content_hash(*parts)[:16]

    def save(self, folder: Path) -> None:
        """Write the arrays into the index file of a folder."""
        np.savez(folder / FILE, **self.arrays)  # type: ignore[arg-type]

    @classmethod
    def load(cls, folder: Path) -> Self:
        """Read an index from the index file of a folder."""
        try:
            with np.load(folder / FILE) as file:
                return cls.of(file)
        except (OSError, KeyError, ValueError) as error:
            raise RecallError(f"{folder / FILE}: not an index ({error})") from None


def nearest_query(place: np.ndarray) -> np.ndarray:
    """Return a place (d,) as a query whose inner products order `nearest_rows` by distance."""
    return np.append(place, 1.0).astype(np.float32)


def nearest_rows(places: np.ndarray) -> np.ndarray:
    """Places (n, d) as rows (n, d + 1): x.y - y.y/2 falls with the distance of x and y."""
    half = 0.5 * (places.astype(float) ** 2).sum(axis=1, keepdims=True)
    return np.hstack([places, -half]).astype(np.float32)


@dataclass(frozen=True)
class RawIndex(Numbers):
    """Index by distance in the space of raw canonical parameters, each on its own scale."""

    scale: Scale
    name: ClassVar[str] = "raw"

    @classmethod
    def fit(cls, situations: Sequence[Any], seed: int = 0) -> RawIndex:
        """Learn the scales of the parameters."""
        return cls(Scale.of(np.array([raw_features(s) for s in situations])))

    @property
    def arrays(self) -> dict[str, np.ndarray]:
        """The scales."""
        return {"mean": self.scale.mean, "spread": self.scale.spread}

    @classmethod
    def of(cls, arrays: Mapping[str, np.ndarray]) -> RawIndex:
        """The index with such scales."""
        return cls(Scale(arrays["mean"], arrays["spread"]))

    @property
    def dim(self) -> int:
        """Numbers of an embedding: the parameters, and one more for distances."""
        return len(self.scale.mean) + 1

    def embed_query(self, situation: Any, scene: Scene | None = None) -> np.ndarray:
        """Embedding of a situation."""
        return nearest_query(self.scale(raw_features(situation, scene)))

    def embed_memories(
        self, situations: Sequence[Any], trajectories: Sequence[Waypoints]
    ) -> np.ndarray:
        """Embeddings of memories."""
        features = np.array([raw_features(s) for s in situations]).reshape(-1, self.dim - 1)
        return nearest_rows(self.scale(features))


@dataclass(frozen=True)
class RandomIndex(Numbers):
    """Index with random places: the control that shows the effect of verification alone.

    A situation always gets the same memories, however it is turned.
    """

    seed: int = 0
    name: ClassVar[str] = "random"
    dim: ClassVar[int] = 16

    @classmethod
    def fit(cls, situations: Sequence[Any], seed: int = 0) -> RandomIndex:
        """Return an index with a seed; the situations have no effect."""
        return cls(seed)

    @property
    def arrays(self) -> dict[str, np.ndarray]:
        """The seed."""
        return {"seed": np.array([self.seed])}

    @classmethod
    def of(cls, arrays: Mapping[str, np.ndarray]) -> RandomIndex:
        """The index with such a seed."""
        return cls(int(arrays["seed"][0]))

    def embed_query(self, situation: Any, scene: Scene | None = None) -> np.ndarray:
        """A direction that depends on the situation's numbers only."""
        return self._direction(raw_features(situation, scene), 0)

    def embed_memories(
        self, situations: Sequence[Any], trajectories: Sequence[Waypoints]
    ) -> np.ndarray:
        """Directions of memories."""
        rows = [self._direction(waypoints.knots, 1) for waypoints in trajectories]
        return np.array(rows, dtype=np.float32).reshape(-1, self.dim)

    def _direction(self, numbers: np.ndarray, kind: int) -> np.ndarray:
        rounded = np.round(numbers.astype(float), 4) + 0.0
        rng = seeding.rng(self.seed, kind, content_number(rounded.tobytes()))
        place = rng.standard_normal(self.dim)
        return (place / np.linalg.norm(place)).astype(np.float32)


@dataclass(frozen=True)
class LearnedIndex:
    """Places situations and memories by a trained encoder.

    Examples
    --------
    >>> index = LearnedIndex(load_encoder("models/encoder"))  # doctest: +SKIP
    >>> memory = remember(records, index)                     # doctest: +SKIP
    """

    encoder: Encoder
    name: ClassVar[str] = "learned"

    @property
    def key(self) -> str:
        """Hash of the encoder's weights."""
        return self.encoder.key

    @property
    def dim(self) -> int:
        """Numbers of an embedding."""
        return self.encoder.dim

    def embed_query(self, situation: Any, scene: Scene | None = None) -> np.ndarray:
        """Embedding of a situation."""
        return self.encoder.embed_situation(situation, scene)

    def embed_memories(
        self, situations: Sequence[Any], trajectories: Sequence[Waypoints]
    ) -> np.ndarray:
        """Embeddings of memories."""
        if len(trajectories) == 0:
            return np.zeros((0, self.dim), np.float32)
        knots = np.array([t.knots for t in trajectories], np.float32)
        goals = np.array([t.goal for t in trajectories], np.float32)
        return self.encoder.embed_memories(situations, knots, goals)

    def save(self, folder: Path) -> None:
        """Write the encoder."""
        save_encoder(self.encoder, folder)

    @classmethod
    def load(cls, folder: Path) -> Self:
        """Read the encoder."""
        try:
            return cls(load_encoder(folder))
        except EncoderError as error:
            raise RecallError(str(error)) from None

    @classmethod
    def fit(cls, situations: Sequence[Any], seed: int = 0) -> Self:
        """Raise RecallError: a learned index takes training."""
        raise RecallError("index 'learned': has to be trained first, see gcm-learn train encoder")


@dataclass(frozen=True)
class PcaIndex(Numbers):
    """Neighbours by principal components of maps: a control without a network.

    A memory is filed under the components of its situation's map. A query must not know its own
    map, so its place is predicted from its raw parameters by ridge regression. The regression is
    linear in them and in cosines of random combinations of them (Rahimi and Recht, NIPS 2007).
    """

    scale: Scale
    centre: np.ndarray
    """(n,): mean of the maps' features."""
    components: np.ndarray
    """(most, n)"""
    waves: np.ndarray
    """(COUNT, COSINES)"""
    phases: np.ndarray
    """(COSINES,) [rad]"""
    weights: np.ndarray
    """(COUNT + COSINES + 1, most)"""
    name: ClassVar[str] = "pca"
    most: ClassVar[int] = 24
    """Components that are kept."""

    @classmethod
    def fit(cls, situations: Sequence[Any], seed: int = 0) -> PcaIndex:
        """Components of the situations' maps, and the regression from raw parameters to them."""
        if any(MEMORIES.of(situation).in_joints for situation in situations):
            raise RecallError("index 'pca': knows maps of the plane only")
        pictures = np.array([_map(s) for s in situations])
        features = np.array([raw_features(s) for s in situations])
        centre = pictures.mean(axis=0)
        scale, rng = Scale.of(features), seeding.rng(seed)
        components = _components(pictures - centre, cls.most, rng)
        waves = (rng.standard_normal((HAND_COUNT, COSINES)) / WIDTH).astype(np.float32)
        phases = rng.uniform(0.0, 2.0 * np.pi, COSINES).astype(np.float32)
        unfitted = cls(scale, centre, components, waves, phases, np.zeros((0, 0), np.float32))
        return unfitted.predicting((pictures - centre) @ components.T, features)

    def predicting(self, places: np.ndarray, features: np.ndarray) -> PcaIndex:
        """Return a copy with a regression from raw parameters (n, COUNT) to places (n, d)."""
        inputs = self._inputs(features).astype(float)
        penalty = RIDGE * np.eye(inputs.shape[1])
        weights = np.linalg.solve(inputs.T @ inputs + penalty, inputs.T @ places)
        return replace(self, weights=weights.astype(np.float32))

    def _inputs(self, features: np.ndarray) -> np.ndarray:
        """Return the inputs (n, HAND_COUNT + COSINES + 1) of the regression."""
        scaled = self.scale(features)
        cosines = np.cos(scaled @ self.waves + self.phases) * np.sqrt(2.0 / len(self.phases))
        return np.hstack([scaled, cosines, np.ones((len(scaled), 1), dtype=np.float32)])

    @property
    def arrays(self) -> dict[str, np.ndarray]:
        """All arrays of the index by name."""
        scale = {"mean": self.scale.mean, "spread": self.scale.spread}
        return scale | {name: getattr(self, name) for name in _NAMES}

    @classmethod
    def of(cls, arrays: Mapping[str, np.ndarray]) -> PcaIndex:
        """The index with such numbers."""
        return cls(Scale(arrays["mean"], arrays["spread"]), *(arrays[name] for name in _NAMES))

    @property
    def dim(self) -> int:
        """Numbers of an embedding: the components, and one more for distances."""
        return len(self.components) + 1

    def embed_query(self, situation: Any, scene: Scene | None = None) -> np.ndarray:
        """Return the likely place of a situation's map."""
        inputs = self._inputs(raw_features(situation, scene)[None])
        return nearest_query((inputs @ self.weights)[0])

    def embed_memories(
        self, situations: Sequence[Any], trajectories: Sequence[Waypoints]
    ) -> np.ndarray:
        """Return the places of the maps of memories."""
        rows = [self.components @ (_map(s) - self.centre) for s in situations]
        return nearest_rows(np.array(rows).reshape(-1, len(self.components)))


def _map(situation: Any) -> np.ndarray:
    """Return features (n,) of a planar situation's map."""
    return planar_map_features(planar_map(situation))


def _components(pictures: np.ndarray, most: int, rng: np.random.Generator) -> np.ndarray:
    """First principal components (at most `most`, m) of centred pictures (n, m).

    By subspace iteration, with a few more directions than are wanted.
    """
    count = min(most, *pictures.shape)
    extra = min(count + SPARE, *pictures.shape)
    basis = rng.standard_normal((pictures.shape[1], extra)).astype(np.float32)
    for _ in range(ITERATIONS):
        basis = np.linalg.qr(pictures.T @ (pictures @ basis))[0]
    _, _, turn = np.linalg.svd(pictures @ basis, full_matrices=False)
    return (turn[:count] @ basis.T).astype(np.float32)


_CLASSES: dict[str, type[Index]] = {
    made.name: made for made in (RawIndex, RandomIndex, PcaIndex, LearnedIndex)
}


def index_class(name: str) -> type[Index]:
    """The class of a registered index; raises UnknownNameError with the known names."""
    if name not in _CLASSES:
        raise UnknownNameError.among("index", name, _CLASSES)
    return _CLASSES[name]
