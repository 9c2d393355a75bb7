"""Planners of legs that recall and search, with the movements and encoders of 21_experience."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from gcm_learn import dataset
from gcm_learn.planners import Plan
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


@dataclass(frozen=True)
class After:
    """Recalls where a search finds nothing."""

    recall: RecallPlanner
    search: Any

    def plan(self, situation: Any) -> Plan:
        """Answer a situation."""
        plan: Plan = self.search.plan(situation)
        return plan if plan.caught else self.recall.plan(situation)


@dataclass(frozen=True)
class Beside:
    """Recalls and searches, and takes the earlier catch."""

    recall: RecallPlanner
    search: Any

    def plan(self, situation: Any) -> Plan:
        """Answer a situation."""
        plans = (self.search.plan(situation), self.recall.plan(situation))
        caught = [plan for plan in plans if plan.caught]
        return min(caught, key=lambda plan: plan.catch_time, default=plans[0])


JOINTS = {
    "before": lambda recall, search: HybridPlanner(recall, fallback=search),
    "after": After,
    "beside": Beside,
}
"""Ways in which a memory joins a search."""


def joined(spec: str, source: str) -> dict[str, Callable[[Any], Any]]:
    """Return what joins movements of a source to a search, in the order learned on them."""
    recall = RecallPlanner(movements(spec, source))
    return {name: partial(join, recall) for name, join in JOINTS.items()}


def movements(spec: str, source: str) -> Memory:
    """Return stored catches or synthetic movements, as many of both."""
    records = dataset.open(EXPERIENCE / "records" / spec).where(split="train")
    index = LearnedIndex(load_encoder(EXPERIENCE / "encoders" / spec / f"{source}-1"))
    found = remember(records, index, synthetic=source == "synthetic", seed=SEED)
    stored = sum(record.earliest() is not None for record in records)
    drawn = np.random.default_rng(SEED).permutation(len(found))
    found.forget(np.sort(drawn[min(stored, len(found)) :]))
    return found
