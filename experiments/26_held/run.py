"""Ask the search and hybrids with memories of held catches for held catches (H17).

python -m experiments 26_held draw --seed HEX --count 300      situations that a search catches
python -m experiments 26_held ask --seed HEX DATASET ENCODERS  hybrids and the search

`draw` goes on where it was stopped; it takes hours. `ask` writes a table beside this file. The
folder ENCODERS has a folder for each training: stored-1, synthetic-1, stored-2 and so on.
"""

from __future__ import annotations

import argparse
import itertools
import json
from pathlib import Path
from typing import Any

import pandas as pd
import report

from gcm_learn import dataset, planners, recall, seeding
from gcm_learn.evaluation import Case, Condition, Entrant, ask
from gcm_learn.situation import situation_from_json, situation_to_json

HERE = Path(__file__).resolve().parent
SPEC = HERE.parents[1] / "data" / "specs" / "panda-held-crowded.toml"
PATIENCE = 10.0  # of the search that says what can be caught [s]
ROUNDS, ENDS = 1500, 20  # ends that a search draws twice as many of; memories that are tried


def caught_by_search(situation: Any) -> bool:
    """Return whether a search catches within PATIENCE [processor time]."""
    deadline = planners.Deadline(PATIENCE)
    problem = planners.JointProblem(situation, "draw", deadline=deadline)
    if problem.early_answer(keeps_acceleration=True, keeps_ends=True) is not None:
        return False
    for seed in itertools.count(1):
        if problem.over:
            return False
        if planners.EndSearch(problem, seed).plan(situation.horizon, ROUNDS).caught:
            return True
    return False


def draw(file: Path, seed: int, count: int) -> None:
    """Draw until so many situations are caught; each draw is a line, null if it is not."""
    spec = dataset.read_spec(SPEC)
    lines = file.read_text("utf-8").splitlines() if file.exists() else []
    found = sum(line != "null" for line in lines)
    with file.open("a", encoding="utf-8") as stream:
        for k in itertools.count(len(lines)):
            if found >= count:
                return
            share = spec.drawn[k % len(spec.drawn)]
            situation = share.draw(seeding.rng(seed, k), f"{share.family}-{k}")
            kept = caught_by_search(situation)
            found += kept
            stream.write(json.dumps(situation_to_json(situation) if kept else None) + "\n")
            stream.flush()


def entrants(records: Any, folder: Path) -> list[Entrant]:
    """Return the search and hybrids, each for all trainings."""
    trainings = sorted({int(path.name.rpartition("-")[2]) for path in folder.glob("stored-*")})
    made, train = [], records.where(split="train")
    for n in trainings:
        search = planners.TreeSearch(rounds=ROUNDS, seed=1 + 1000 * n)
        made.append(Entrant("search", search, n))
        for name in ("stored", "synthetic"):
            index = recall.LearnedIndex.load(folder / f"{name}-{n}")
            memory = recall.remember(train, index, synthetic=name == "synthetic", seed=n)
            made.append(Entrant(name, hybrid(memory, search), n))
            if name == "stored":
                raw = memory.refiled(recall.RawIndex.fit(memory.situations()[:5000], n))
                made.append(Entrant("raw neighbours", hybrid(raw, search), n))
    return made


def hybrid(memory: Any, search: Any) -> Any:
    """Return the hybrid of a memory and a search."""
    return recall.HybridPlanner(recall.RecallPlanner(memory, ENDS), search)


def main() -> None:
    """Draw, or ask and write what came of it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=["draw", "ask"])
    parser.add_argument("folders", nargs="*", type=Path)
    parser.add_argument("--seed", type=lambda text: int(text, 16), required=True)
    parser.add_argument("--count", type=int, default=300, help="situations that are caught")
    given = parser.parse_args()
    out = HERE / "out" / f"{given.seed:08x}"
    out.mkdir(parents=True, exist_ok=True)
    if given.what == "draw":
        draw(out / "drawn.jsonl", given.seed, given.count)
        return
    records, folder = given.folders
    lines = map(json.loads, (out / "drawn.jsonl").read_text("utf-8").splitlines())
    drawn = [situation_from_json(line) for line in lines if line is not None][: given.count]
    if len(drawn) < given.count:
        parser.error(f"{len(drawn)} of {given.count} situations are drawn")
    cases = [Case(s, "fresh", s.name.rpartition("-")[0]) for s in drawn]
    conditions = [Condition(thinking=budget) for budget in report.BUDGETS]
    sheet = ask(entrants(dataset.open(records), folder), cases, conditions, keep=out)
    rows = pd.DataFrame({name: sheet[name] for name in report.KEPT})
    rows.to_csv(HERE / "outcomes.csv.gz", index=False, compression={"method": "gzip", "mtime": 0})
    for name, text in report.results(HERE).items():
        (HERE / name).write_text(text, "utf-8")
        print(text)


if __name__ == "__main__":
    main()
