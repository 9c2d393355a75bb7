"""Catches of memories by index and by size; writes table.md.

python experiments/05_recall/run.py DATASET             the controls
python experiments/05_recall/run.py DATASET ENCODER     the learned index, and all in one table

DATASET is a folder of `gcm-learn generate`, ENCODER one of `gcm-learn train-encoder`. Memories
are the catches of the training records; situations come from the split `test`. Results are kept in
out/ and not computed again.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1])]

from report import write_figure, write_table  # noqa: E402

from gcm_learn import dataset, get_planner, seeding  # noqa: E402
from gcm_learn.recall import (  # noqa: E402
    Encoder,
    HybridPlanner,
    Index,
    LearnedIndex,
    Memory,
    PcaIndex,
    RandomIndex,
    RawIndex,
    RecallPlanner,
    Scale,
    SplinesPlanner,
    Waypoints,
    load_encoder,
    nearest_rows,
    raw_features,
    unverified,
    waypoints_of,
)
from gcm_learn.situation import Situation  # noqa: E402

STRATA = ("L", "W", "Q")
Ask = Callable[[Situation], dict[str, object]]


class Bank(NamedTuple):
    """Catches of the training records."""

    traces: np.ndarray
    goals: np.ndarray
    features: np.ndarray
    """(n, COUNT) float32: raw parameters of the situations."""
    records: np.ndarray
    """Their positions among the training records."""

    @classmethod
    def of(cls, train: dataset.Dataset, most: int, file: Path) -> Bank:
        """The earliest catches of the first records, read once."""
        if not file.exists():
            rows = []
            for k, record in enumerate(train):
                plans = [plan for plan in record.plans.values() if plan.caught]
                if plans:
                    best = min(plans, key=lambda plan: plan.catch_time or 0.0)
                    trace = waypoints_of(record.situation, best)
                    rows.append((*trace, raw_features(record.situation), k))
                if len(rows) == most:
                    break
            np.savez(file, *(np.array(column) for column in zip(*rows, strict=True)))
        with np.load(file) as arrays:
            return cls(*(arrays[f"arr_{k}"] for k in range(4)))

    def part(self, size: int) -> Bank:
        """Some of them, at random; smaller parts are parts of larger ones."""
        some = np.sort(seeding.rng(4).permutation(len(self.traces))[:size])
        return Bank(*(column[some] for column in self))

    def filed(self, index: Index, places: np.ndarray, search: str) -> Memory:
        """A memory of these catches at known places."""
        return Memory.of(index, places, self.traces, self.goals, search=search)


def questions(records: dataset.Dataset, count: int) -> list[tuple[str, str, Situation]]:
    """Stratum, family and situation of the first test records of every stratum."""
    out = []
    for stratum in STRATA:
        some = records.where(split="test", stratum=stratum)
        out += [(stratum, r.family, r.situation) for r in some[:count]]
    return out


def filed(
    bank: Bank, encoder: Encoder | None, train: dataset.Dataset, maps: int
) -> Iterator[tuple[str, Memory]]:
    """The memory under every index."""
    if encoder is not None:
        places = encoder.embed_memories([], bank.traces, bank.goals)
        yield "learned", bank.filed(LearnedIndex(encoder), places, "cells")
        return
    scale = Scale.of(bank.features)
    yield "raw", bank.filed(RawIndex(scale), nearest_rows(scale(bank.features)), "exact")
    control = RandomIndex()
    traces = [Waypoints(k, g) for k, g in zip(bank.traces, bank.goals, strict=True)]
    places = np.array([control.embed_memories([None], [trace])[0] for trace in traces])  # type: ignore
    yield "random", bank.filed(control, places, "exact")
    if len(traces) <= maps:
        situations = [train[int(k)].situation for k in bank.records]
        index = PcaIndex.fit(situations)
        yield "pca", bank.filed(index, index.embed_memories(situations, traces), "exact")


def recalled(planner: RecallPlanner) -> Ask:
    """Answer of a planner that recalls, and its checks."""

    def ask(situation: Situation) -> dict[str, object]:
        found = planner.recollect(situation)
        return {"caught": found.plan.caught, "checks": found.checked}

    return ask


def planned(name: str, hybrid: RecallPlanner | None = None) -> Ask:
    """Answer of a planner, after recall if that is given."""
    planner = get_planner(name) if hybrid is None else HybridPlanner(hybrid, get_planner(name))

    def ask(situation: Situation) -> dict[str, object]:
        return {"caught": planner.plan(situation).caught, "checks": 1}

    return ask


def first_choice(memory: Memory) -> Ask:
    """Return whether the first memory holds after adaptation, unverified."""

    def ask(situation: Situation) -> dict[str, object]:
        return {"caught": unverified(memory, situation).worked, "checks": 1}

    return ask


def answered(
    file: Path, name: str, size: int, ask: Ask, situations: list[tuple[str, str, Situation]]
) -> None:
    """Answer all situations and keep the answers, unless they are there."""
    if file.exists():
        return
    for _, _, situation in situations[:20]:
        ask(situation)  # compiled, cells made
    lines = []
    for stratum, family, situation in situations:
        began = time.process_time()
        answer = ask(situation)
        ms = 1e3 * (time.process_time() - began)
        lines.append({"planner": name, "size": size, "stratum": stratum, "family": family,
                      "ms": ms, **answer})  # fmt: skip
    text = "".join(json.dumps(line) + "\n" for line in lines)
    file.with_suffix(".tmp").write_text(text)
    file.with_suffix(".tmp").rename(file)
    print(name, size, f"{np.mean([line['caught'] for line in lines]):.3f}", flush=True)


def main() -> None:
    """Run what is missing; write table.md and figure.png."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("dataset")
    parser.add_argument("encoder", nargs="?", help="without one, only the controls")
    parser.add_argument("--situations", type=int, default=300, help="of each stratum")
    parser.add_argument("--sizes", type=int, nargs="+", default=[100, 1000, 10_000, 100_000])
    parser.add_argument("--maps", type=int, default=1000, help="memories up to which pca is asked")
    given = parser.parse_args()
    records = dataset.open(given.dataset)
    train, out = records.where(split="train"), HERE / "out" / str(given.situations)
    out.mkdir(parents=True, exist_ok=True)
    bank = Bank.of(train, max(given.sizes), HERE / "out" / "memories.npz")
    asked = questions(records, given.situations)
    encoder = None if given.encoder is None else load_encoder(given.encoder)
    stamp = "controls" if encoder is None else encoder.key
    for size in given.sizes:
        if (out / f"done-{stamp}-{size}").exists():
            continue
        for name, memory in filed(bank.part(size), encoder, train, given.maps):
            planner = RecallPlanner(memory)
            tag = f"{stamp}-{name}-{size}.jsonl"
            answered(out / tag, name, size, recalled(planner), asked)
            bent = f"{name}, first, as bent"
            answered(out / f"first-{tag}", bent, size, first_choice(memory), asked)
            if encoder is not None and size == max(given.sizes):
                hybrid = planned("layered", planner)
                answered(out / f"hybrid-{tag}", "hybrid", size, hybrid, asked)
        (out / f"done-{stamp}-{size}").touch()
    if encoder is None:
        answered(out / "controls-splines.jsonl", "splines-random", 0, _splines(), asked)
        for name in ("layered", "marching", "gcm"):
            answered(out / f"controls-{name}.jsonl", name, 0, planned(name), asked)
    files = [f for f in sorted(out.glob("*.jsonl")) if "controls" in f.name or stamp in f.name]
    lines = [json.loads(x) for f in files for x in f.open()]
    write_table(HERE / "table.md", lines)
    write_figure(HERE / "figure.png", lines)


def _splines() -> Ask:
    planner = SplinesPlanner()
    return lambda situation: {"caught": planner.plan(situation).caught, "checks": 20}


if __name__ == "__main__":
    main()
