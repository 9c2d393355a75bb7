"""The trained encoder as plain arrays: what recalls needs no learning library.

Four towers of the same kind, each a perceptron with two hidden layers. A situation's embedding is
the sum of what one makes of its arm and target and of what another makes of each of its obstacles:
a deep set (Zaheer et al., NIPS 2017) that is summed last, because a path holds if it holds against
every obstacle, so that odds multiply and their logarithms add. The other two embed a memory's way
and its map. Inner products tell whether the memory, bent to the situation, catches in it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gcm_learn.errors import EncoderError
from gcm_learn.recall.clearance_features import Look, look
from gcm_learn.recall.encoder_config import EncoderConfig
from gcm_learn.recall.forward import embed_look
from gcm_learn.recall.path_features import ways
from gcm_learn.recall.pictures import picture_of
from gcm_learn.scene.scene import Scene
from gcm_learn.situation import Situation
from gcm_learn.storage import content_hash

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
        """The tower of a name, its inputs' scale made part of the first layer."""
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
    """Embeds situations and memories in one space."""

    config: EncoderConfig
    arrays: Mapping[str, np.ndarray]
    """Weights by name, as trained."""

    @property
    def dim(self) -> int:
        """Numbers of an embedding."""
        return self.config.dim

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

    def embed_situation(self, situation: Situation, scene: Scene | None = None) -> np.ndarray:
        """Embedding (dim,) float32 of a situation in any frame, from what is known at t = 0."""
        return self.embed_look(look(situation, scene))

    def embed_look(self, seen: Look) -> np.ndarray:
        """Embedding (dim,) float32 of a situation by what it looks like."""
        arm, body = self._situation, self._body
        found: np.ndarray = embed_look(
            seen.context, seen.cells, arm.weights, arm.biases, body.weights, body.biases
        )
        return found

    def embed_memories(
        self, situations: Sequence[Situation], traces: np.ndarray, goals: np.ndarray
    ) -> np.ndarray:
        """Embeddings (n, dim) float32 of memories.

        Parameters
        ----------
        situations : sequence of Situation
            Looked at only by encoders that use maps.
        traces, goals : (n, k, 4), (n, 2) ndarray
        """
        out = np.zeros((len(traces), self.dim), dtype=np.float32)
        for first in range(0, len(traces), CHUNK):
            part = slice(first, first + CHUNK)
            if self.config.uses_traces:
                out[part] += self._memory["trace"](ways(traces[part], goals[part]))
            if self.config.uses_maps:
                pictures = np.array([picture_of(s) for s in situations[part]])
                out[part] += self._memory["map"](pictures)
        return out
