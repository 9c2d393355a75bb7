"""Draw situations of every stratum and keep them, with the oracle's bounds."""

from __future__ import annotations

import json
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from gcm_learn import seeding
from gcm_learn.families import get_family
from gcm_learn.planners import marching
from gcm_learn.planners.baselines.straight import StraightPlanner
from gcm_learn.planners.completion import Problem
from gcm_learn.planners.oracle.bounds import bounds, stratum
from gcm_learn.situation import situation_from_json, situation_to_json

CHUNK = 50  # draws that are looked through at once
STRATA = ("U", "L", "W", "Q")


@dataclass(frozen=True)
class Case:
    """A situation with what the oracle knows of it."""

    index: int
    family: str
    stratum: str
    decided: bool
    """True if the oracle found a catch, or ruled one out."""
    lower: float
    """No movement catches before [s]."""
    upper: float
    """When the oracle's plan catches [s]."""
    situation: dict[str, Any]

    def read(self) -> Any:
        """The situation as a record."""
        return situation_from_json(self.situation)


def draw(config: dict[str, Any], index: int, wanted: tuple[str, ...]) -> Case | str:
    """Draw number `index` of an experiment, or why it is not kept.

    Families take turns.
    """
    family = config["families"][index % len(config["families"])]
    rng = seeding.rng(config["seed"], index)
    situation = get_family(family).draw(rng, f"{family}-{index:07d}")
    answer = Problem(situation, "oracle").early_answer()
    if answer is not None and answer.status == "start_blocked":
        return "start_blocked"
    # What is not wanted is not bounded: these two planners decide L and W by themselves.
    if StraightPlanner().plan(situation).caught:
        if "L" not in wanted:
            return "L"
    elif "W" not in wanted and marching().plan(situation).caught:
        return "W"
    known = bounds(situation)
    found = stratum(situation, known)
    if found not in wanted:
        return found
    return Case(
        index, family, found, known.decided, known.lower, known.upper, situation_to_json(situation)
    )


def _chunk(config: dict[str, Any], first: int, wanted: tuple[str, ...], file: Path) -> None:
    """Look through CHUNK draws and write what was found (whole or not at all)."""
    found = [draw(config, index, wanted) for index in range(first, first + CHUNK)]
    lines = [json.dumps(f if isinstance(f, str) else asdict(f)) for f in found]
    temporary = file.with_suffix(".tmp")
    temporary.write_text("\n".join(lines) + "\n")
    temporary.replace(file)


def make(config: dict[str, Any], folder: Path, workers: int) -> tuple[list[Case], dict[str, int]]:
    """All cases of the experiment, and how many draws of each kind there were.

    Chunks that lie in the folder are not drawn again.  Which strata a chunk still looks for depends
    on the chunks before it only, so the cases are the same however often it is interrupted.
    """
    folder.mkdir(parents=True, exist_ok=True)
    kept: dict[str, list[Case]] = {s: [] for s in STRATA}
    seen: dict[str, int] = {}
    context = get_context("spawn")
    with ProcessPoolExecutor(workers, mp_context=context) as pool:
        first = 0
        while first < config["most_draws"]:
            wanted = tuple(s for s in STRATA if len(kept[s]) < config["per_stratum"])
            if not wanted:
                break
            starts = [first + CHUNK * w for w in range(ROUND)]
            files = [folder / f"draws_{start:07d}.jsonl" for start in starts]
            jobs = [
                pool.submit(_chunk, config, start, wanted, file)
                for start, file in zip(starts, files, strict=True)
                if not file.exists()
            ]
            for job in jobs:
                job.result()
            for file in files:
                _collect(file, kept, seen, config["per_stratum"])
            first += CHUNK * ROUND
            counts = {s: len(k) for s, k in kept.items()}
            print(f"{first} draws: {counts}", flush=True)
    return [case for s in STRATA for case in kept[s]], seen


ROUND = 2  # chunks between looks at what is still wanted; part of what defines the cases


def _collect(file: Path, kept: dict[str, list[Case]], seen: dict[str, int], most: int) -> None:
    """Add what a chunk found."""
    for line in file.read_text().splitlines():
        found = json.loads(line)
        kind = found if isinstance(found, str) else found["stratum"]
        seen[kind] = seen.get(kind, 0) + 1
        if not isinstance(found, str) and len(kept[kind]) < most:
            kept[kind].append(Case(**found))
