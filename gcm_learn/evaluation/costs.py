"""Ingredients of methods and the cost of making them, as far as their files say."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from gcm_learn import artifacts
from gcm_learn.evaluation.methods import PlannerMethod, get_method
from gcm_learn.policies import FILE, actor_folder, actor_names, shipped_actor
from gcm_learn.recall import MANIFEST, Memory

CONFIG, LOG, METRICS = "config.json", "log.jsonl", "metrics.json"


@dataclass(frozen=True)
class Cost:
    """Of methods that have the same memory or network."""

    methods: tuple[str, ...]
    memories: int | None = None
    """Catches that are remembered."""
    weights: int | None = None
    """Numbers in the network that acts."""
    size: int | None = None
    """Of their files [bytes]."""
    situations: int | None = None
    """Situations that were trained on; of memories, those that their encoder learned from."""
    steps: int | None = None
    """In the arena."""
    start: str = ""
    """Start of the training."""
    minutes: float | None = None
    """Of training, by the clock."""


def costs_of(names: Sequence[str]) -> list[Cost]:
    """Costs of methods by name; who holds nothing, because it plans anew, is left out."""
    found: dict[str, Cost] = {}
    for name in names:
        bare = name.partition("@")[0]
        memory = None if bare in actor_names() else _memory_of(name)
        if memory is None and bare not in actor_names():
            continue
        key = bare if memory is None else f"{memory.index.key} {len(memory)}"
        if key in found:
            found[key] = replace(found[key], methods=(*found[key].methods, name))
        else:
            found[key] = _of_actor(name, bare) if memory is None else _of_memory(name, memory)
    return list(found.values())


def _memory_of(name: str) -> Memory | None:
    made = get_method(name)
    planner: Any = made.planner if isinstance(made, PlannerMethod) else None
    return getattr(getattr(planner, "recall", planner), "memory", None)


def _of_memory(name: str, memory: Memory) -> Cost:
    """A memory, with its encoder if that is there."""
    size = None
    for folder in artifacts.models(MANIFEST).values():
        manifest = _json(folder / MANIFEST)
        if manifest.get("index", {}).get("key") == memory.index.key:
            size = sum(manifest.get("bytes", {}).values())
    cost = Cost((name,), memories=len(memory), size=size)
    for folder in artifacts.models(METRICS).values():
        metrics = _json(folder / METRICS)
        if metrics.get("key") == memory.index.key:
            minutes = metrics["seconds"] / 60 if "seconds" in metrics else None
            return replace(cost, situations=metrics.get("memories"), minutes=minutes)
    return cost


def _of_actor(name: str, bare: str) -> Cost:
    """A network and its training."""
    folder = actor_folder(bare)
    config = configuration_of(bare)
    counts = [share.get("count", 0) for share in config.get("situations", [])]
    rows = log_of(bare)
    return Cost(
        (name,),
        weights=sum(w.size + b.size for w, b in shipped_actor(bare).layers),
        size=(folder / FILE).stat().st_size,
        situations=sum(counts) or None,
        steps=max((row["steps"] for row in rows if "steps" in row), default=0) or None,
        start=Path(config.get("start", "")).name,
        minutes=_minutes(rows),
    )


def configuration_of(bare: str) -> dict[str, Any]:
    """Return the configuration that a model was trained with; empty if its file is missing."""
    folder = artifacts.model(bare, CONFIG)
    return {} if folder is None else _json(folder / CONFIG)


def log_of(bare: str) -> list[dict[str, Any]]:
    """Return the rows of the log of a trained actor's course; empty if it is missing."""
    folder = artifacts.model(bare, LOG)
    lines = [] if folder is None else (folder / LOG).read_text("utf-8").splitlines()
    return [json.loads(line) for line in lines]


def _minutes(rows: Sequence[dict[str, Any]]) -> float | None:
    """Time of a course; each time that it was taken up again, the clock began anew."""
    total, last = 0.0, 0.0
    for row in rows:
        now = float(row.get("seconds", last))
        total, last = (total + last if now < last else total), now
    return (total + last) / 60 if rows else None


def _json(path: Path) -> dict[str, Any]:
    """Values of a file."""
    return dict(json.loads(path.read_text("utf-8")))
