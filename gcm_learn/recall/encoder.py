"""The trained encoder as plain arrays: recall needs no learning library.

Four towers of the same kind, each a perceptron with two hidden layers. One embeds a situation's arm
and target, another each of its obstacles; the situation's embedding is their sum. It is a deep
set (Zaheer et al., NIPS 2017) that is summed last. For a path is valid if it is so against every
obstacle: odds multiply, and their logarithms add. The other two embed a memory's path and its map.
Inner products say whether the memory, adapted to the situation, catches in it.
"""

from __future__ import annotations

import dataclasses
import importlib
import json
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from types import ModuleType
from typing import Any, Literal

import numpy as np

from gcm_learn.arms import PLANAR, Kind, kind_named
from gcm_learn.compiled import njit
from gcm_learn.errors import EncoderError, MissingExtraError
from gcm_learn.maps import CognitiveMap
from gcm_learn.recall.features import Features
from gcm_learn.recall.kinds import MEMORIES
from gcm_learn.scene import Scene
from gcm_learn.situation import AnySituation
from gcm_learn.storage import content_hash, write_whole

FORMAT = "gcm-learn/encoder@1"
SOURCES = ("trace", "map", "both")


@dataclass(frozen=True)
class EncoderConfig:
    """Configuration of an encoder and of its training."""

    dim: int = 32
    """Numbers of an embedding."""
    width: int = 256
    """Units of a hidden layer; each tower has two."""
    memory: Literal["trace", "map", "both"] = "trace"
    """Source of a memory's embedding: its path, its situation's map, or the sum of both."""
    listwise: float = 0.3
    """Weight of the listwise loss, which asks that a valid memory comes first."""
    contrast: float = 0.1
    """Weight of the contrast of a situation's own memory with those that are not valid in it."""
    rate: float = 1.5e-3
    """Largest learning rate."""
    decay: float = 0.02
    """Weight decay."""
    steps: int = 30
    """Of the optimiser after every batch of labels."""
    hard: float = 0.6
    """Share of batches, after the first ones, on the memories that the encoder itself thinks
    best."""
    seed: int = 0
    arm: str = PLANAR.name
    """Kind of arm."""

    def __post_init__(self) -> None:
        for name, low in (("dim", 2), ("width", 4), ("steps", 1), ("seed", 0)):
            value = getattr(self, name)
            if not isinstance(value, int) or value < low:
                raise EncoderError(f"{name}: must be an integer of at least {low} (got {value!r})")
        if self.memory not in SOURCES:
            raise EncoderError(f"memory: must be one of {', '.join(SOURCES)} (got {self.memory!r})")
        known = [kind.name for kind in MEMORIES]
        if self.arm not in known:
            raise EncoderError(f"arm: must be one of {', '.join(known)} (got {self.arm!r})")
        for name in ("listwise", "contrast", "decay", "hard"):
            if not getattr(self, name) >= 0.0:
                raise EncoderError(f"{name}: must not be negative (got {getattr(self, name)!r})")
        if not self.rate > 0.0:
            raise EncoderError(f"rate: must be positive (got {self.rate!r})")

    @property
    def kind(self) -> Kind:
        """Kind of arm."""
        return kind_named(self.arm)

    @property
    def uses_maps(self) -> bool:
        """True if memories are embedded by maps."""
        return self.memory != "trace"

    @property
    def uses_traces(self) -> bool:
        """True if memories are embedded by their paths."""
        return self.memory != "map"


def config_to_json(config: EncoderConfig) -> dict[str, Any]:
    """The configuration as JSON values."""
    return {"format": FORMAT, **dataclasses.asdict(config)}


def config_from_json(values: Mapping[str, Any]) -> EncoderConfig:
    """The configuration from JSON values."""
    if values.get("format") != FORMAT:
        raise EncoderError(f"format: is {values.get('format')!r}, expected {FORMAT!r}")
    values = {"arm": PLANAR.name} | dict(values)  # older files know one kind of arm only
    names = [f.name for f in dataclasses.fields(EncoderConfig)]
    missing = [name for name in names if name not in values]
    if missing:
        raise EncoderError(f"{missing[0]}: is missing")
    return EncoderConfig(**{name: values[name] for name in names})


LAYERS = 3
CHUNK = 4096  # memories that are embedded at once
NAMES = ("mean", "spread") + tuple(
    f"layers.{k}.{part}" for k in range(LAYERS) for part in ("weight", "bias")
)


@dataclass(frozen=True)
class Tower:
    """A perceptron: inputs on a common scale, two hidden layers of rectified units."""

    weights: tuple[np.ndarray, ...]
    """Of every layer (inputs, outputs) float32; the first takes inputs as they come."""
    biases: tuple[np.ndarray, ...]

    @classmethod
    def of(cls, arrays: Mapping[str, np.ndarray], name: str) -> Tower:
        """Return the tower `name`, with the scale of its inputs made part of the first layer."""
        try:
            mean, spread, *layers = (arrays[f"{name}.{part}"].astype(float) for part in NAMES)
        except KeyError as error:
            raise EncoderError(f"weights: {error.args[0]!r} is missing") from None
        weights, biases = [w.T for w in layers[::2]], layers[1::2]
        weights[0] = weights[0] / spread[:, None]
        biases[0] = biases[0] - mean @ weights[0]
        return cls(
            tuple(np.ascontiguousarray(w, np.float32) for w in weights),
            tuple(b.astype(np.float32) for b in biases),
        )

    def __call__(self, inputs: np.ndarray) -> np.ndarray:
        """Outputs (..., m) float32 of inputs (..., n) float32."""
        values = inputs
        for weight, bias in zip(self.weights[:-1], self.biases[:-1], strict=True):
            values = values @ weight
            values += bias
            np.maximum(values, 0.0, out=values)
        out: np.ndarray = values @ self.weights[-1] + self.biases[-1]
        return out


@dataclass(frozen=True)
class Encoder:
    """Encoder of situations and memories in one space."""

    config: EncoderConfig
    arrays: Mapping[str, np.ndarray]
    """Weights by name, as trained."""

    @property
    def dim(self) -> int:
        """Numbers of an embedding."""
        return self.config.dim

    @property
    def kind(self) -> Kind:
        """Kind of arm that the encoder knows."""
        return self.config.kind

    @cached_property
    def key(self) -> str:
        """Short hash of all that embeddings depend on."""
        parts: list[str | bytes] = [f"{self.config.memory} {self.dim}"]
        for name in sorted(self.arrays):
            array = np.ascontiguousarray(self.arrays[name])
            parts += [f"{name} {array.dtype.str} {array.shape}", array.tobytes()]
        return content_hash(*parts)[:16]

    @cached_property
    def _situation(self) -> Tower:
        return Tower.of(self.arrays, "situation")

    @cached_property
    def _body(self) -> Tower:
        return Tower.of(self.arrays, "body")

    @cached_property
    def _memory(self) -> dict[str, Tower]:
        names = {"trace": self.config.uses_traces, "map": self.config.uses_maps}
        return {name: Tower.of(self.arrays, name) for name, used in names.items() if used}

    def embed_situation(self, situation: AnySituation, scene: Scene | None = None) -> np.ndarray:
        """Embed a situation in any frame, from what is known at t = 0; return (dim,) float32."""
        return self.embed_features(MEMORIES.of(self.kind).features(situation, scene))

    def embed_features(self, seen: Features) -> np.ndarray:
        """Return the embedding (dim,) float32 of a situation from its features."""
        arm, body = self._situation, self._body
        self._check("situation", len(seen.context), arm)
        found: np.ndarray = embed_features(
            seen.context, seen.cells, arm.weights, arm.biases, body.weights, body.biases
        )
        return found

    def _check(self, what: str, count: int, tower: Tower) -> None:
        """Refuse features of an arm with another number of joints."""
        known = len(tower.weights[0])
        if count != known:
            raise EncoderError(
                f"{what}: of an arm with another number of joints than those that encoder "
                f"{self.key} knows ({count} features, expected {known})"
            )

    def embed_memories(
        self, situations: Sequence[Any], knots: np.ndarray, goals: np.ndarray
    ) -> np.ndarray:
        """Embeddings (n, dim) float32 of memories.

        Parameters
        ----------
        situations : sequence of Situation
            Looked at only by encoders that use maps.
        knots, goals : (n, ...) ndarray
            Columns of `Waypoints`.
        """
        out = np.zeros((len(knots), self.dim), dtype=np.float32)
        for first in range(0, len(knots), CHUNK):
            part = slice(first, first + CHUNK)
            if self.config.uses_traces:
                paths = MEMORIES.of(self.kind).path_features(knots[part], goals[part])
                out[part] += self.embed_paths(paths)
            if self.config.uses_maps:
                out[part] += self.embed_maps(map(MEMORIES.of(self.kind).map_of, situations[part]))
        return out

    def embed_paths(self, paths: np.ndarray) -> np.ndarray:
        """Embeddings (n, dim) float32 of paths by their features (n, m)."""
        self._check("memory", paths.shape[1], self._memory["trace"])
        return self._memory["trace"](paths)

    def embed_maps(self, maps: Iterable[CognitiveMap]) -> np.ndarray:
        """Embeddings (n, dim) float32 of maps of canonical situations."""
        if not self.config.uses_maps:
            raise EncoderError(f"encoder {self.key}: embeds memories by their paths, not by maps")
        rows = []
        for made in maps:
            if made.chart.kind != self.kind:
                found = made.chart.kind.plural
                raise EncoderError(f"encoder {self.key}: of {self.kind.plural}, the map of {found}")
            rows.append(MEMORIES.of(self.kind).map_features(made))
            self._check("map", len(rows[-1]), self._memory["map"])
        return self._memory["map"](np.array(rows)) if rows else np.zeros((0, self.dim), np.float32)


@njit(fastmath={"reassoc", "contract"})
def _add_rows(values, weight, first, out):
    """Add values (n,) times the rows of a weight from `first` on to out (m,)."""
    for k in range(values.size):
        value = values[k]
        if value > 0.0 or value < 0.0:
            row = first + k
            for j in range(out.size):
                out[j] += value * weight[row, j]


@njit
def _rectify(values):
    for j in range(values.size):
        if values[j] < 0.0:
            values[j] = np.float32(0.0)


@njit
def embed_features(context, cells, arm_weights, arm_biases, body_weights, body_biases):
    """Return the embedding (dim,) float32 of a situation from its context and cells.

    Rows of weights are added up for inputs that are not zero. Most cells are, and half of all
    rectified units.

    Parameters
    ----------
    context, cells : (c,), (b, n) ndarray of float32
        Of `Features`.
    arm_weights, arm_biases, body_weights, body_biases : tuple of ndarray
        Of the towers `situation` and `body`; the body's inputs are context and cells.
    """
    first = arm_biases[0].copy()
    _add_rows(context, arm_weights[0], 0, first)
    _rectify(first)
    second = arm_biases[1].copy()
    _add_rows(first, arm_weights[1], 0, second)
    _rectify(second)
    out = arm_biases[2].copy()
    _add_rows(second, arm_weights[2], 0, out)
    if cells.shape[0] == 0:
        return out
    shared = body_biases[0].copy()
    _add_rows(context, body_weights[0], 0, shared)
    total = np.zeros(body_biases[1].size, dtype=np.float32)
    for b in range(cells.shape[0]):
        first = shared.copy()
        _add_rows(cells[b], body_weights[0], context.size, first)
        _rectify(first)
        second = body_biases[1].copy()
        _add_rows(first, body_weights[1], 0, second)
        _rectify(second)
        total += second
    _add_rows(total, body_weights[2], 0, out)
    return out + np.float32(cells.shape[0]) * body_biases[2]


WEIGHTS, CONFIG = "encoder.safetensors", "config.json"


def save_encoder(encoder: Encoder, folder: str | os.PathLike[str]) -> None:
    """Write an encoder's weights and configuration into a folder."""
    place = Path(folder)
    place.mkdir(parents=True, exist_ok=True)
    save = _safetensors().save
    arrays = {name: np.ascontiguousarray(a) for name, a in encoder.arrays.items()}
    write_whole(place / WEIGHTS, save(arrays, {"key": encoder.key}), durable=True)
    text = json.dumps(config_to_json(encoder.config), indent=1) + "\n"
    write_whole(place / CONFIG, text, durable=True)


def load_encoder(folder: str | os.PathLike[str]) -> Encoder:
    """Read an encoder.

    Raises
    ------
    EncoderError
        In one line: the encoder is missing or damaged.
    """
    place = Path(folder)
    load = _safetensors().load
    try:
        config = config_from_json(json.loads((place / CONFIG).read_text("utf-8")))
        arrays = load((place / WEIGHTS).read_bytes())
    except FileNotFoundError as error:
        missing = Path(error.filename).name
        raise EncoderError(f"{place}: no encoder there ({missing} is missing)") from None
    except (OSError, ValueError, TypeError, AttributeError) as error:
        raise EncoderError(f"{place}: not an encoder ({error})") from None
    except Exception as error:  # safetensors raises errors of its own
        raise EncoderError(f"{place / WEIGHTS}: damaged ({error})") from None
    return Encoder(config, arrays)


def _safetensors() -> ModuleType:
    """The numpy side of safetensors."""
    try:
        return importlib.import_module("safetensors.numpy")
    except ImportError:
        raise MissingExtraError("an encoder", "safetensors", "learn") from None
