"""Questions outside of the training, and a suite as it is at rest."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

from lessons import at_rest

from experiments.common.questions import Question
from gcm_learn import seeding
from gcm_learn.dataset import DatasetSpec, FamilyShare, quantities_of
from gcm_learn.families import get_family
from gcm_learn.planners import Problem, StraightPlanner, bounds, get_planner, stratum
from gcm_learn.scene import TOP_SPEED
from gcm_learn.situation import Situation, situation_from_json, situation_to_json
from gcm_learn.storage import write_whole

SPLITS = ("test-pendulum", "test-long-arm", "test-fast", "test-crowded")
EACH = 50  # situations of W and Q of a split
CROWD = (6, 8)  # obstacles; those of the dataset's own families are five at most
SEED = 1701  # of the splits


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


def waitless(whole: list[Question]) -> dict[str, list[Question]]:
    """Return W in which something moves, and what needs a detour once nothing does."""
    straight, layered = get_planner("straight"), get_planner("layered")
    groups: dict[str, list[Question]] = {"W": [], "at rest": []}
    for question in whole:
        still = at_rest(question.situation)
        if still is None or still == question.situation:
            continue
        if question.stratum == "W":
            groups["W"].append(question)
        if not straight.plan(still).caught and layered.plan(still).caught:
            groups["at rest"].append(question._replace(situation=still))
    return groups
