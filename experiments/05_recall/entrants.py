"""A memory under several indexes, asked with twenty checks and with one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from gcm_learn.recall import Memory, RecallPlanner

CHECKS = 20


def entrants(memory: Memory, indexes: Mapping[str, Any]) -> dict[str, RecallPlanner]:
    """Return all that answer, by name: the memory as it is, and filed by other indexes."""
    memories = {"recall": memory} | {n: memory.refiled(index) for n, index in indexes.items()}
    found = {}
    for name, one in memories.items():
        found[name] = RecallPlanner(one, CHECKS)
        found[f"{name}, 1 check"] = RecallPlanner(one, 1, novelty=0.0)
    return found
