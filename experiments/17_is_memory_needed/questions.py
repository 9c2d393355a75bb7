"""What is asked: suites that the oracle sorted, and situations outside of what was trained on."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, NamedTuple

from experiments.common.suite import Case, draw
from gcm_learn import seeding
from gcm_learn.dataset import DatasetSpec, FamilyShare, quantities_of
from gcm_learn.evaluation.turns import FAMILIES
from gcm_learn.families import get_family
from gcm_learn.planners import Problem, StraightPlanner, bounds, stratum
from gcm_learn.scene import TOP_SPEED
from gcm_learn.situation import Situation, situation_from_json, situation_to_json
from gcm_learn.storage import write_whole

CHUNK = 50  # draws of a file
MOST = 300  # situations of W and of Q that are asked of all
TIMED = 200  # of these, that are asked where processor time is told
SPLITS = ("test-pendulum", "test-long-arm", "test-fast", "test-crowded")
EACH = 50  # situations of W and Q of a split
CROWD = (6, 8)  # obstacles; those of the dataset's own families are five at most
SEED = 1701  # of the splits


class Question(NamedTuple):
    """A situation, and what the oracle says of it."""

    stratum: str
    family: str
    index: int
    situation: Situation


def suite(seed: int, folder: Path) -> list[Question]:
    """The first situations of W and of Q that families draw in turn under a seed."""
    config = {"seed": seed, "families": list(FAMILIES)}
    found: dict[str, list[Question]] = {"W": [], "Q": []}
    first = 0
    while wanted := tuple(name for name, kept in found.items() if len(kept) < MOST):
        for case in _chunk(config, first, wanted, folder):
            one = Question(case.stratum, case.family, case.index, case.read())
            found[case.stratum].append(one)
        first += CHUNK
    print(f"{first} draws", {name: len(kept) for name, kept in found.items()}, flush=True)
    return [*found["W"], *found["Q"]]


def _chunk(config: dict[str, Any], first: int, wanted: tuple[str, ...], folder: Path) -> list[Case]:
    """What CHUNK draws give of the strata that are wanted, kept in a file."""
    file = folder / f"draws_{first:07d}.jsonl"
    if not file.exists():
        folder.mkdir(parents=True, exist_ok=True)
        found = [draw(config, k, wanted) for k in range(first, first + CHUNK)]
        kept = [asdict(one) for one in found if not isinstance(one, str)]
        write_whole(file, "".join(json.dumps(one) + "\n" for one in kept))
    return [Case(**json.loads(line)) for line in file.read_text("utf-8").splitlines()]


def development(folder: Path, most: int) -> list[Question]:
    """The first situations of the frozen suites W and Q: these have been looked at."""
    rows = []
    for name in ("W", "Q"):
        for line in (folder / f"{name}.jsonl").read_text("utf-8").splitlines()[:most]:
            values = json.loads(line)
            situation: Any = situation_from_json(values["situation"])
            rows.append(Question(name, values["family"], values["index"], situation))
    return rows


def asked(rows: list[Question], most: int = MOST) -> list[Question]:
    """As many of each stratum as are asked of everybody."""
    return [q for name in ("W", "Q") for q in [r for r in rows if r.stratum == name][:most]]


def outside(split: str, spec: DatasetSpec, folder: Path, seed: int = SEED) -> list[Question]:
    """W and Q of what training leaves out, drawn as the specification says; kept in a file."""
    file = folder / f"{split}.jsonl"
    if not file.exists():
        found: list[Question] = []
        seen: Counter[str] = Counter()
        for number, (family, situation) in enumerate(_drawn(split, spec, seed)):
            name = _sorted(situation)
            seen[name] += 1
            if name in "WQ":
                found.append(Question(name, family, number, situation))
            if len(found) == EACH:
                break
        print(split, dict(seen), flush=True)
        folder.mkdir(parents=True, exist_ok=True)
        lines = [[*q[:3], situation_to_json(q.situation)] for q in found]
        write_whole(file, "".join(json.dumps(line) + "\n" for line in lines))
    rows = map(json.loads, file.read_text("utf-8").splitlines())
    return [Question(*row[:3], situation_from_json(row[3])) for row in rows]  # type: ignore


def _sorted(situation: Situation) -> str:
    """Its stratum by the oracle."""
    if StraightPlanner().plan(situation).caught:
        return "L"
    return stratum(situation, bounds(situation))


def _drawn(split: str, spec: DatasetSpec, seed: int) -> Iterator[tuple[str, Situation]]:
    """Situations that are held out as this split, and as no other."""
    number = 0
    while True:
        rng = seeding.rng(seed, SPLITS.index(split), number)
        number += 1
        share = FamilyShare("pendulum", 1.0) if split == SPLITS[0] else spec.choose(rng)
        if split == "test-crowded":
            family: Any = replace(get_family(share.family), obstacles=CROWD)
            situation = family.draw(rng, "outside")
        else:
            situation = share.draw(rng, "outside")
        problem = Problem(situation, "outside")
        if problem.early_answer() is not None:
            continue
        top = float(problem.scene.bodies.rows[:, TOP_SPEED].max())
        told = quantities_of(situation, top)
        held = {h.split for h in spec.holdouts if h.holds(share.family, told)}
        if held == {split}:
            yield share.family, situation
