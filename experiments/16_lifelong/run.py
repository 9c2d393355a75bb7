"""What does a memory of bounded size keep of a life in which families come one after the other?

python -m experiments 16_lifelong DATASET
python -m experiments 16_lifelong DATASET --done                    report what is done so far
python -m experiments 16_lifelong DATASET --count 500 --seed 1     a short life

DATASET is the folder of `gcm-learn generate data/specs/recall.toml`, from which fixed memories are
drawn.  Lives are kept in out/ and reused.  Writes results.json; `report.py` makes
table.md and figure.png of it.
"""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import report
from stream import Met, Teacher, life, phases, planned

from experiments.common.judging import complaints
from gcm_learn import dataset
from gcm_learn.dataset import read_spec
from gcm_learn.recall import (
    Index,
    LearnedIndex,
    Memory,
    RawIndex,
    RecallPlanner,
    Recollection,
    grow,
    remember,
    shipped_memory,
)
from gcm_learn.recall.growth import Step
from gcm_learn.storage import write_whole

HERE = Path(__file__).resolve().parent
SPEC = HERE.parents[1] / "data" / "specs" / "recall.toml"
SHARES = {"1/10": 10, "1/3": 3, "1": 1}  # of the size that is reached without a limit
RULES = {
    "learned": (("covered", "least used"), ("drawn",), ("oldest", "random"), ("stops",)),
    "raw": (("covered", "least used"), ("drawn",)),
}
"""What is forgotten, the most telling first; "stops" learns no more once it is full, and "drawn" is
a fixed memory of records of all families."""
FIRST, MIXED = 500, 1000  # fresh situations of the first family, and of all
SEED, COUNT = 4265997287, 20_000
Run = dict[str, Any]
JUDGED = 200  # one catch of so many goes to the referee
EVERY = 4  # families, after which a memory is asked for the first again


@dataclass(frozen=True)
class Setting:
    """Parts that all lives share."""

    seed: int
    count: int
    records: str
    out: Path
    done: bool = False
    """Nothing more is lived."""

    @cached_property
    def life(self) -> list[Met]:
        """What is met."""
        return planned(self.out / "life", self.seed, life(read_spec(SPEC), self.count))

    @cached_property
    def first(self) -> list[Met]:
        """Fresh situations of the first family."""
        family = phases(read_spec(SPEC), self.count)[0][0]
        which = [(family, k) for k in range(FIRST)]
        return planned(self.out / "first", self.seed + 1, which)

    @cached_property
    def mixed(self) -> list[Met]:
        """Fresh situations of all families."""
        return planned(self.out / "mixed", self.seed + 2, life(read_spec(SPEC), MIXED))

    @cached_property
    def teacher(self) -> Teacher:
        """Whom growing memories ask."""
        return Teacher({met.situation.name: met.plan for met in self.life})

    @cached_property
    def train(self) -> dataset.Dataset:
        """Records that fixed memories and raw scales are made of."""
        return dataset.open(self.records).where(split="train")

    @cached_property
    def indexes(self) -> dict[str, Index]:
        """How memories are asked."""
        raw = RawIndex.fit([record.situation for record in self.train[:2000]])
        return {"learned": LearnedIndex.load(HERE.parents[1] / "models" / "encoder"), "raw": raw}

    def drawn(self, index: str, size: int) -> Memory:
        """A memory of records of all families, drawn at random."""
        most = min(len(self.train), 2 * size + 100)
        memory = remember(self.train, self.indexes[index], seed=self.seed, most=most)
        memory.forget_to(size, "random", seed=self.seed)
        return memory


@dataclass(frozen=True)
class Judged(RecallPlanner):
    """Recalls, and has the referee judge one catch of so many."""

    each: int = 1
    complaints: list[str] = field(default_factory=list)
    judged: list[int] = field(default_factory=lambda: [0, 0])
    """Catches, and how many of them were judged."""

    def recollect(self, situation: Any) -> Recollection:
        """As recall does."""
        found = super().recollect(situation)
        if found.plan.caught:
            if self.judged[0] % self.each == 0:
                self.complaints.extend(complaints(situation, found.plan))
                self.judged[1] += 1
            self.judged[0] += 1
        return found


def asked(judge: Judged, memory: Memory, some: list[Met]) -> str:
    """Which situations are caught from memory, as a row of 1 and 0; nothing is learned."""
    planner = replace(judge, memory=memory)
    return "".join(str(int(planner.plan(met.situation).caught)) for met in some)


def grown(
    judge: Judged, memory: Memory, some: list[Met], teacher: Teacher, most: int | None, rule: str
) -> tuple[str, list[int]]:
    """The same while learning, and the memory's sizes."""
    steps: list[Step] = []
    if rule == "stops":
        for met in some:
            if len(memory) == most:
                break
            steps += grow(memory, [met.situation], teacher, recall=judge)
    else:
        steps = grow(
            memory, [met.situation for met in some], teacher, recall=judge, most=most, forget=rule
        )
    rest = some[len(steps) :]
    row = "".join(str(int(step.recalled)) for step in steps) + asked(judge, memory, rest)
    return row, [step.size for step in steps] + [len(memory)] * len(rest)


def lived(setting: Setting, name: str, memory: Memory, most: int | None, rule: str | None) -> Run:
    """One life, unless it has been lived; a memory without a rule is fixed."""
    file = setting.out / f"{name.replace('/', '-').replace(' ', '-')}.json"
    if not file.exists() and setting.done:
        return {}
    if not file.exists():
        began, at = time.process_time(), 0
        judged = Judged(memory, each=JUDGED)
        run: Run = {"index": memory.index.name, "most": most, "rule": rule,
                    "recalled": "", "sizes": [], "first": []}  # fmt: skip
        parts = phases(read_spec(SPEC), setting.count)
        for k, (_, count) in enumerate(parts):
            some, at = setting.life[at : at + count], at + count
            if rule is None:
                row, sizes = asked(judged, memory, some), [len(memory)] * count
            else:
                row, sizes = grown(judged, memory, some, setting.teacher, most, rule)
            run["recalled"] += row
            run["sizes"] += sizes
            if k % EVERY == 0 or k == len(parts) - 1:
                run["first"].append([k, asked(judged, memory, setting.first)])
        run["mixed"] = asked(judged, memory, setting.mixed)
        run["judged"], run["complaints"] = judged.judged[1], judged.complaints
        run["seconds"] = round(time.process_time() - began, 1)
        memory.save(file.with_suffix(""))
        write_whole(file, json.dumps(run))
    run = json.loads(file.read_text())
    rates = [
        report.hits(row, some).mean()
        for row, some in (
            (run["recalled"], setting.life),
            (run["first"][0][1], setting.first),
            (run["first"][-1][1], setting.first),
            (run["mixed"], setting.mixed),
        )
    ]
    print(f"{name:28}", run["sizes"][-1], *(f"{value:.3f}" for value in rates),
          len(run["complaints"]), run["judged"], f"{run['seconds']} s", flush=True)  # fmt: skip
    return run


def lives(setting: Setting, name: str) -> dict[str, Run]:
    """All of an index, by title; what matters most comes first."""
    index, whole = setting.indexes[name], f"{name}, no limit"
    out = {whole: lived(setting, whole, Memory(index), None, "covered")}
    if not out[whole]:
        return {}
    sizes = {share: round(out[whole]["sizes"][-1] / part) for share, part in SHARES.items()}
    for rules in RULES[name]:
        for share, most in sizes.items() if name == "learned" else [("1/10", sizes["1/10"])]:
            for rule in rules:
                title = f"{name}, {share}, {rule}"
                if rule == "drawn":
                    memory = setting.drawn(name, most)
                    out[title] = lived(setting, title, memory, most, None)
                elif share != "1":  # as large as without a limit nothing is forgotten
                    out[title] = lived(setting, title, Memory(index), most, rule)
        if name == "learned" and "drawn" in rules:
            out["shipped"] = lived(setting, "shipped", shipped_memory("recall"), None, None)
    return {title: run for title, run in out.items() if run}


def main() -> None:
    """Live all lives; write results.json."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("dataset")
    parser.add_argument("--index", choices=[*RULES], help="only this one; writes no results")
    parser.add_argument("--done", action="store_true", help="report what is done so far")
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--count", type=int, default=COUNT)
    given = parser.parse_args()
    out = HERE / "out" / f"{given.seed}-{given.count}"
    setting = Setting(given.seed, given.count, given.dataset, out, given.done)
    if given.index:
        lives(setting, given.index)
        return
    runs = {title: run for name in RULES for title, run in lives(setting, name).items()}
    seen = {"life": setting.life, "first": setting.first, "all": setting.mixed}
    about = {"seed": given.seed, "count": given.count}
    report.write(runs, phases(read_spec(SPEC), given.count), seen, about)


if __name__ == "__main__":
    main()
