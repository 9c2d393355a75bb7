"""Compare recall with its controls on the oracle's strata W and Q, and write fresh.md.

python -m experiments 05_recall SUITES [--before MEMORY] [--name NAME]

SUITES is a folder with suites W.jsonl and Q.jsonl (`evaluation.draw_suite` keeps them in
data/suites), MEMORY the folder of another memory to be asked beside the shipped one, NAME another
name of what is written. Every catch of the rows marked so is judged by the tests' referee, which
shares no code with the package.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from gcm_learn import get_planner
from gcm_learn.evaluation import mcnemar, stratified
from gcm_learn.planners import Plan
from gcm_learn.recall import (
    Adaptation,
    HybridPlanner,
    Memory,
    RandomIndex,
    RawIndex,
    RecallPlanner,
    shipped_memory,
)
from gcm_learn.situation import Situation, situation_from_json
from tests.referee import judge

HERE = Path(__file__).resolve().parent
BLIND = Adaptation(bends=0)
JUDGED = ("recall", "recall-1", "former recall", "former recall-1")
Row = tuple[str, str, Situation]


def questions(folder: Path, most: int) -> list[Row]:
    """Stratum, family and situation of both suites."""
    rows = []
    for stratum in ("W", "Q"):
        for line in (folder / f"{stratum}.jsonl").read_text("utf-8").splitlines()[:most]:
            values = json.loads(line)
            rows.append((stratum, values["family"], situation_from_json(values["situation"])))
    return rows


def asked(memory: Memory, tries: int, how: Adaptation | None = None) -> RecallPlanner:
    """Recall with so many checks; one check is of the first choice, whatever it is like."""
    novelty = {"novelty": 0.0} if tries == 1 else {}
    return RecallPlanner(memory, tries, how=how or Adaptation(), **novelty)


def entrants(before: Path | None) -> Iterator[tuple[str, Callable[[Situation], Plan]]]:
    """All that answer, by name."""
    memory = shipped_memory("recall")
    yield "recall", asked(memory, 20).plan
    yield "recall-1", asked(memory, 1).plan
    yield "recall, not bent", asked(memory, 20, BLIND).plan
    yield "recall-1, not bent", asked(memory, 1, BLIND).plan
    others = {"raw": RawIndex.fit(memory.situations()), "random": RandomIndex()}
    for name, index in others.items():
        other = memory.refiled(index)
        yield f"recall-{name}", asked(other, 20).plan
        if name == "random":
            yield f"recall-{name}, 1 check", asked(other, 1).plan
    if before is not None:
        old = Memory.load(before)
        yield "memory before", asked(old, 20).plan
        yield "memory before, 1 check", asked(old, 1).plan
    yield "splines-random", get_planner("splines-random").plan
    yield "hybrid", HybridPlanner(asked(memory, 20)).plan
    yield "layered", get_planner("layered").plan


def answered(file: Path, name: str, ask: Callable[[Situation], Plan], rows: list[Row]) -> dict:
    """What one of them catches, how long it takes, and what the referee says; kept in a file."""
    if file.exists():
        return json.loads(file.read_text("utf-8"))
    ask(rows[0][2])  # compiled
    caught, ms, complaints = [], [], []
    for _, _, situation in rows:
        began = time.process_time()
        plan = ask(situation)
        ms.append(1e3 * (time.process_time() - began))
        caught.append(plan.caught)
        if plan.caught and name in JUDGED:
            complaints += judge(situation, plan).complaints
    answers = {"name": name, "caught": caught, "ms": ms, "complaints": complaints}
    file.write_text(json.dumps(answers), encoding="utf-8")
    print(name, f"{np.mean(caught):.3f}", len(complaints), flush=True)
    return answers


def line_of(answers: dict, rows: list[Row]) -> str:
    """A row of the table."""
    strata, families = (np.array(column) for column in list(zip(*rows, strict=True))[:2])
    caught, cells = np.array(answers["caught"]), [f"`{answers['name']}`"]
    for stratum in ("W", "Q"):
        some = strata == stratum
        value, low, high = stratified(caught[some], families[some])
        cells.append(f"{100 * value:.1f} ({100 * low:.0f}–{100 * high:.0f})")
    judged = answers["name"] in JUDGED
    cells.append(f"{len(answers['complaints'])} of {caught.sum()}" if judged else "")
    cells += [f"{np.quantile(answers['ms'], q):.1f}" for q in (0.5, 0.9)]
    return "| " + " | ".join(cells) + " |"


def _pair(out: Path, former: Path) -> str:
    """What the former code and this one catch that the other does not."""
    name = former.stem.removeprefix("former ")
    files = (out / f"{name}.json", former)
    now, then = (np.array(json.loads(file.read_text("utf-8"))["caught"]) for file in files)
    more, less, p = mcnemar(now, then)
    return (
        f"`{name}` catches {now.sum()} of {len(now)}, its former code {then.sum()}; "
        f"{more} that are caught are new, {less} are lost (McNemar's p {p:.2g})."
    )


def main() -> None:
    """Ask what was not asked yet; write fresh.md."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("suites", type=Path)
    parser.add_argument("--before", type=Path, help="another memory")
    parser.add_argument("--count", type=int, default=1000, help="situations of a stratum at most")
    parser.add_argument("--name", default="fresh", help="of what is written")
    parser.add_argument("--only", nargs="+", help="of those that answer; the table has no others")
    given = parser.parse_args()
    rows = questions(given.suites, given.count)
    out = HERE / "out" / given.name / shipped_memory("recall").index.key
    out.mkdir(parents=True, exist_ok=True)
    head = ["| asked | W | Q | complaints | ms | 90 % |", "|---" * 6 + "|"]
    lines = [
        line_of(answered(out / f"{name}.json", name, ask, rows), rows)
        for name, ask in entrants(given.before)
        if given.only is None or name in given.only
    ]
    former = sorted(out.glob("former*.json"))  # answers of other code to the same
    lines += [line_of(json.loads(file.read_text("utf-8")), rows) for file in former]
    pairs = [_pair(out, file) for file in former]
    counts = [sum(stratum == name for stratum, _, _ in rows) for name in ("W", "Q")]
    note = (
        f"Catches [%] of {counts[0]} situations of W and {counts[1]} of Q, 95 % intervals within "
        "families; what the referee complains of, of so many catches; processor time, median and "
        "90 %."
    )
    (HERE / f"{given.name}.md").write_text(
        "\n".join([*head, *lines, "", note, *pairs]) + "\n", "utf-8"
    )


if __name__ == "__main__":
    main()
