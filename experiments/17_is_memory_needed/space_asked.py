"""Questions to spatial arms, fronts and fallbacks."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

from fronts import BUDGET_MS

from experiments.common.questions import Question
from gcm_learn.dataset import make_item, read_spec
from gcm_learn.planners import Planner, STRRTStarPlanner, TreeSearch, get_planner
from gcm_learn.situation import situation_from_json, situation_to_json
from gcm_learn.storage import write_whole

SPEC = Path(__file__).resolve().parents[2] / "data" / "specs" / "space.toml"
AS_TRAINED = ("train", "validation", "test")  # splits: whatever this seed draws, no memory has seen
CHUNK = 50  # draws of a file
FRONTS = {"learned": "recall", "raw": "recall-raw", "random": "recall-random"}


def suite(seed: int, folder: Path, most: int) -> list[Question]:
    """The first `most` of W and of Q that the specification draws under a seed.

    `search` with half its postures sorts them, as it sorted the records.
    """
    spec = replace(read_spec(SPEC), seed=seed, audit=0.0, count=10**6)
    found: dict[str, list[Question]] = {"W": [], "Q": []}
    first = 0
    while any(len(kept) < most for kept in found.values()):
        for question in _chunk(spec, first, folder):
            found[question.stratum].append(question)
        first += CHUNK
    print(f"{first} draws", {name: len(kept) for name, kept in found.items()}, flush=True)
    return [*found["W"][:most], *found["Q"][:most]]


def _chunk(spec: Any, first: int, folder: Path) -> list[Question]:
    """W and Q of CHUNK draws, kept in a file."""
    file = folder / f"draws_{first:07d}.jsonl"
    if not file.exists():
        made = (make_item(spec, k) for k in range(first, first + CHUNK))
        kept = [
            [r.stratum, r.family, r.index, situation_to_json(r.situation)]
            for r in made
            if r.situation is not None and r.stratum in ("W", "Q") and r.split in AS_TRAINED
        ]
        folder.mkdir(parents=True, exist_ok=True)
        write_whole(file, "".join(json.dumps(row) + "\n" for row in kept))
    rows = map(json.loads, file.read_text("utf-8").splitlines())
    return [Question(*row[:3], situation_from_json(row[3])) for row in rows]  # type: ignore


def fallbacks() -> dict[str, Planner]:
    """Planners behind a front that has no catch; the second stops at its first catch."""
    return {
        "search": get_planner("search"),
        "search, first catch": TreeSearch(),
        "straight-wait": get_planner("straight-wait"),
        "marching": get_planner("marching"),
        "ST-RRT*": STRRTStarPlanner(budget_ms=BUDGET_MS),
    }


def planners() -> dict[str, Planner]:
    """Fronts and fallbacks by name."""
    return {name: get_planner(known) for name, known in FRONTS.items()} | fallbacks()
