"""Suites of W and Q that families draw in turn, sorted by the oracle."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any, NamedTuple

from experiments.common.suite import Case, draw
from gcm_learn.evaluation.turns import FAMILIES
from gcm_learn.situation import Situation
from gcm_learn.storage import write_whole

CHUNK = 50  # draws of a file
MOST = 300  # situations of W and of Q that are asked of all


class Question(NamedTuple):
    """A situation with its stratum by the oracle."""

    stratum: str
    family: str
    index: int
    situation: Situation

    def about(self) -> dict[str, Any]:
        """Return the columns of outcomes that name it."""
        return {"situation": self.index, "stratum": self.stratum, "family": self.family}


def suite(seed: int, folder: Path, most: int = MOST) -> list[Question]:
    """Return at least the first `most` situations of W and of Q that families draw in turn."""
    config = {"seed": seed, "families": list(FAMILIES)}
    found: dict[str, list[Question]] = {"W": [], "Q": []}
    first = 0
    while wanted := tuple(name for name, kept in found.items() if len(kept) < most):
        for case in _chunk(config, first, wanted, folder):
            one = Question(case.stratum, case.family, case.index, case.read())
            found[case.stratum].append(one)
        first += CHUNK
    print(f"{first} draws", {name: len(kept) for name, kept in found.items()}, flush=True)
    return [*found["W"], *found["Q"]]


def _chunk(config: dict[str, Any], first: int, wanted: tuple[str, ...], folder: Path) -> list[Case]:
    """Return the wanted cases among CHUNK draws, kept in a file."""
    file = folder / f"draws_{first:07d}.jsonl"
    if not file.exists():
        folder.mkdir(parents=True, exist_ok=True)
        found = [draw(config, k, wanted) for k in range(first, first + CHUNK)]
        kept = [asdict(one) for one in found if not isinstance(one, str)]
        write_whole(file, "".join(json.dumps(one) + "\n" for one in kept))
    return [Case(**json.loads(line)) for line in file.read_text("utf-8").splitlines()]


def asked(rows: list[Question], most: int = MOST) -> list[Question]:
    """Return the first situations of each stratum."""
    return [q for name in ("W", "Q") for q in [r for r in rows if r.stratum == name][:most]]
