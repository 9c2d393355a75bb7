"""Planners of legs that recall, with the movements and encoders of 21_experience."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from gcm_learn import dataset
from gcm_learn.recall import (
    HybridPlanner,
    LearnedIndex,
    Memory,
    RecallPlanner,
    load_encoder,
    remember,
)

EXPERIENCE = Path(__file__).resolve().parents[1] / "21_experience" / "out"
SEED = 0  # of synthetic movements, and of those that are left out


def recalling(spec: str, source: str) -> Callable[[Any], HybridPlanner]:
    """Return what puts movements of a source before a planner, in the order learned on them."""
    memory = movements(spec, source)
    return lambda fallback: HybridPlanner(RecallPlanner(memory), fallback=fallback)


def movements(spec: str, source: str) -> Memory:
    """Return stored catches or synthetic movements, as many of both."""
    records = dataset.open(EXPERIENCE / "records" / spec).where(split="train")
    index = LearnedIndex(load_encoder(EXPERIENCE / "encoders" / spec / f"{source}-1"))
    found = remember(records, index, synthetic=source == "synthetic", seed=SEED)
    stored = sum(record.earliest() is not None for record in records)
    drawn = np.random.default_rng(SEED).permutation(len(found))
    found.forget(np.sort(drawn[min(stored, len(found)) :]))
    return found
