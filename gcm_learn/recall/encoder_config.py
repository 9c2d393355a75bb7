"""What decides an encoder: its size, what it is told of memories, how it is trained."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

from gcm_learn.errors import EncoderError

FORMAT = "gcm-learn/encoder@1"
SOURCES = ("trace", "map", "both")


@dataclass(frozen=True)
class EncoderConfig:
    """An encoder, and how it learns."""

    dim: int = 32
    """Numbers of an embedding."""
    width: int = 256
    """Units of a hidden layer; each tower has two."""
    memory: Literal["trace", "map", "both"] = "trace"
    """What a memory is embedded by: its way, its situation's map, or the sum of both."""
    listwise: float = 0.3
    """Weight of the listwise loss, which asks that a memory that holds comes first."""
    contrast: float = 0.1
    """Weight of the contrast of a situation's own memory with those that do not hold in it."""
    rate: float = 1.5e-3
    """Largest learning rate."""
    decay: float = 0.02
    """Weight decay."""
    steps: int = 30
    """Of the optimiser after every lesson."""
    hard: float = 0.6
    """Share of lessons, after the first ones, on the memories that the encoder itself thinks
    best."""
    seed: int = 0

    def __post_init__(self) -> None:
        for name, low in (("dim", 2), ("width", 4), ("steps", 1), ("seed", 0)):
            value = getattr(self, name)
            if not isinstance(value, int) or value < low:
                raise EncoderError(f"{name}: must be an integer of at least {low} (got {value!r})")
        if self.memory not in SOURCES:
            raise EncoderError(f"memory: must be one of {', '.join(SOURCES)} (got {self.memory!r})")
        for name in ("listwise", "contrast", "decay", "hard"):
            if not getattr(self, name) >= 0.0:
                raise EncoderError(f"{name}: must not be negative (got {getattr(self, name)!r})")
        if not self.rate > 0.0:
            raise EncoderError(f"rate: must be positive (got {self.rate!r})")

    @property
    def uses_maps(self) -> bool:
        """Whether memories are embedded by maps."""
        return self.memory != "trace"

    @property
    def uses_traces(self) -> bool:
        """Whether memories are embedded by their ways."""
        return self.memory != "map"


def config_to_json(config: EncoderConfig) -> dict[str, Any]:
    """The configuration as JSON values."""
    return {"format": FORMAT, **dataclasses.asdict(config)}


def config_from_json(values: Mapping[str, Any]) -> EncoderConfig:
    """The configuration from JSON values."""
    if values.get("format") != FORMAT:
        raise EncoderError(f"format: is {values.get('format')!r}, expected {FORMAT!r}")
    names = [f.name for f in dataclasses.fields(EncoderConfig)]
    missing = [name for name in names if name not in values]
    if missing:
        raise EncoderError(f"{missing[0]}: is missing")
    return EncoderConfig(**{name: values[name] for name in names})
