"""Indexes: how a situation asks a memory, and under what a memory is filed."""

from __future__ import annotations

import importlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Protocol, Self

import numpy as np

from gcm_learn import seeding
from gcm_learn.errors import MissingExtraError, RecallError, UnknownNameError
from gcm_learn.recall.raw_features import ARM, COUNT, OBSTACLE, SLOTS, TARGET, raw_features
from gcm_learn.recall.waypoints import Trace
from gcm_learn.scene.scene import Scene
from gcm_learn.situation import Situation
from gcm_learn.storage import content_hash, content_number

FILE = "index.npz"
_MODULES = {  # looked up late, for what is learned needs more libraries
    "raw": "gcm_learn.recall.index:RawIndex",
    "random": "gcm_learn.recall.index:RandomIndex",
    "pca": "gcm_learn.recall.pca:PcaIndex",
    "learned": "gcm_learn.recall.learned_index:LearnedIndex",
}


class Index(Protocol):
    """Places situations and memories in one space; the larger the inner product, the better.

    A query knows the situation at t = 0 and its laws of motion, and nothing that takes a map.
    """

    name: ClassVar[str]
    """Under which it is registered."""

    @property
    def key(self) -> str:
        """Hash of all that embeddings depend on; memories are stamped with it."""

    @property
    def dim(self) -> int:
        """Numbers of an embedding."""

    def embed_query(self, situation: Situation, scene: Scene | None = None) -> np.ndarray:
        """Embedding (dim,) float32 of a situation in any frame.

        Parameters
        ----------
        situation : Situation
        scene : Scene, optional
            The situation packed, if the caller has it at hand.
        """

    def embed_memory(self, situation: Situation, trace: Trace) -> np.ndarray:
        """Embedding (dim,) float32 of a memory, of which everything may be known."""

    def embed_memories(
        self, situations: Sequence[Situation], traces: Sequence[Trace]
    ) -> np.ndarray:
        """Embeddings (n, dim) float32 of many memories."""

    def save(self, folder: Path) -> None:
        """Write what it takes to load it again into a folder."""

    @classmethod
    def load(cls, folder: Path) -> Self:
        """Read it from a folder."""

    @classmethod
    def fit(cls, situations: Sequence[Situation], seed: int = 0) -> Self:
        """One for memories of situations like these, if it takes no training of its own."""


def index_class(name: str) -> type[Index]:
    """The class of a registered index; raises UnknownNameError with the known names."""
    if name not in _MODULES:
        raise UnknownNameError(f"index: {name!r} is not one of {', '.join(_MODULES)}")
    module, attribute = _MODULES[name].split(":")
    try:
        found: type[Index] = getattr(importlib.import_module(module), attribute)
    except ImportError as error:
        raise MissingExtraError(f"index {name!r}", str(error.name), "learn") from None
    return found


def hash_of(name: str, *arrays: np.ndarray) -> str:
    """Short hash of an index' name and numbers."""
    parts: list[str | bytes] = [name]
    for array in arrays:
        parts += [repr((array.dtype.str, array.shape)), np.ascontiguousarray(array).tobytes()]
    return content_hash(*parts)[:16]


def write_arrays(folder: Path, arrays: dict[str, np.ndarray]) -> None:
    """Write the numbers of an index into its file."""
    with open(folder / FILE, "wb") as stream:
        np.savez(stream, **arrays)  # type: ignore[arg-type]


def read_arrays(folder: Path, names: Sequence[str]) -> list[np.ndarray]:
    """Read the numbers of an index from its file."""
    try:
        with np.load(folder / FILE) as file:
            return [file[name] for name in names]
    except (OSError, KeyError, ValueError) as error:
        raise RecallError(f"{folder / FILE}: not an index ({error})") from None


def nearest_query(place: np.ndarray) -> np.ndarray:
    """A place (d,) as a query whose inner products order `nearest_rows` by distance."""
    return np.append(place, 1.0).astype(np.float32)


def nearest_rows(places: np.ndarray) -> np.ndarray:
    """Places (n, d) as rows (n, d + 1): x.y - y.y/2 falls with the distance of x and y."""
    half = 0.5 * (places.astype(float) ** 2).sum(axis=1, keepdims=True)
    return np.hstack([places, -half]).astype(np.float32)


@dataclass(frozen=True)
class Scale:
    """Brings raw parameters to a common scale; slots that are free lie in the middle of things."""

    mean: np.ndarray
    """(COUNT,) float32"""
    spread: np.ndarray
    """(COUNT,) float32"""

    @classmethod
    def of(cls, features: np.ndarray) -> Scale:
        """Fit to raw parameters (n, COUNT); all slots of obstacles share one scale."""
        head = ARM + TARGET
        slots = features[:, head:].reshape(-1, OBSTACLE)
        slots = slots[slots[:, 0] > 0.0]
        if len(slots) == 0:
            slots = np.zeros((1, OBSTACLE))
        mean = np.concatenate([features[:, :head].mean(axis=0), np.tile(slots.mean(axis=0), SLOTS)])
        spread = np.concatenate([features[:, :head].std(axis=0), np.tile(slots.std(axis=0), SLOTS)])
        mean[head::OBSTACLE], spread[head::OBSTACLE] = 0.0, 1.0  # whether there is one
        spread = np.where(spread > 1e-6, spread, 1.0)
        return cls(mean.astype(np.float32), spread.astype(np.float32))

    def __call__(self, features: np.ndarray) -> np.ndarray:
        """Parameters (..., COUNT) on that scale."""
        out = (features - self.mean) / self.spread
        slots = out[..., ARM + TARGET :].reshape(*out.shape[:-1], SLOTS, OBSTACLE)
        slots *= slots[..., :1]  # present is 1, free is 0
        return out


@dataclass(frozen=True)
class RawIndex:
    """Neighbours in the space of raw canonical parameters, each on its own scale."""

    scale: Scale
    name: ClassVar[str] = "raw"

    @classmethod
    def fit(cls, situations: Sequence[Situation], seed: int = 0) -> RawIndex:
        """Learn the scales of the parameters."""
        return cls(Scale.of(np.array([raw_features(s) for s in situations])))

    @property
    def key(self) -> str:
        """Hash of the scales."""
        return hash_of(self.name, self.scale.mean, self.scale.spread)

    @property
    def dim(self) -> int:
        """The parameters and one number for their distance."""
        return COUNT + 1

    def embed_query(self, situation: Situation, scene: Scene | None = None) -> np.ndarray:
        """Embedding of a situation."""
        return nearest_query(self.scale(raw_features(situation, scene)))

    def embed_memory(self, situation: Situation, trace: Trace) -> np.ndarray:
        """Embedding of a memory: that of its situation."""
        return self.embed_memories([situation], [trace])[0]

    def embed_memories(
        self, situations: Sequence[Situation], traces: Sequence[Trace]
    ) -> np.ndarray:
        """Embeddings of memories."""
        features = np.array([raw_features(s) for s in situations]).reshape(-1, COUNT)
        return nearest_rows(self.scale(features))

    def save(self, folder: Path) -> None:
        """Write the scales."""
        write_arrays(folder, {"mean": self.scale.mean, "spread": self.scale.spread})

    @classmethod
    def load(cls, folder: Path) -> RawIndex:
        """Read the scales."""
        return cls(Scale(*read_arrays(folder, ("mean", "spread"))))


@dataclass(frozen=True)
class RandomIndex:
    """Any memories: places at random, for the control that asks what verification does alone.

    A situation always gets the same ones, however it is turned.
    """

    seed: int = 0
    name: ClassVar[str] = "random"
    dim: ClassVar[int] = 16

    @classmethod
    def fit(cls, situations: Sequence[Situation], seed: int = 0) -> RandomIndex:
        """Nothing to learn."""
        return cls(seed)

    @property
    def key(self) -> str:
        """Hash of the seed."""
        return hash_of(self.name, np.array([self.seed]))

    def embed_query(self, situation: Situation, scene: Scene | None = None) -> np.ndarray:
        """A direction that depends on the situation's numbers only."""
        return self._direction(raw_features(situation, scene), 0)

    def embed_memory(self, situation: Situation, trace: Trace) -> np.ndarray:
        """A direction that depends on the memory's numbers only."""
        return self._direction(trace.knots, 1)

    def embed_memories(
        self, situations: Sequence[Situation], traces: Sequence[Trace]
    ) -> np.ndarray:
        """Directions of memories."""
        rows = [self.embed_memory(s, t) for s, t in zip(situations, traces, strict=True)]
        return np.array(rows, dtype=np.float32).reshape(-1, self.dim)

    def _direction(self, numbers: np.ndarray, kind: int) -> np.ndarray:
        rounded = np.round(numbers.astype(float), 4) + 0.0
        rng = seeding.rng(self.seed, kind, content_number(rounded.tobytes()))
        place = rng.standard_normal(self.dim)
        return (place / np.linalg.norm(place)).astype(np.float32)

    def save(self, folder: Path) -> None:
        """Write the seed."""
        write_arrays(folder, {"seed": np.array([self.seed])})

    @classmethod
    def load(cls, folder: Path) -> RandomIndex:
        """Read the seed."""
        return cls(int(read_arrays(folder, ("seed",))[0][0]))
