"""What memories catch, by how they are found again and how many there are; writes table.md.

python experiments/05_recall/run.py DATASET ENCODER
python experiments/05_recall/run.py DATASET ENCODER --situations 50 --sizes 100 1000    a quick look

DATASET is a folder of `gcm-learn generate`, ENCODER one of `gcm-learn train-encoder`. The memory of
the training records (`--memory`, made in out/ if it is not there) is cut down to each size; the
situations are those of the split `test`. What is done is kept in out/ and not done again.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1])]

from report import write_figure, write_table  # noqa: E402

from gcm_learn import dataset, get_planner, seeding  # noqa: E402
from gcm_learn.encoder import load_encoder  # noqa: E402
from gcm_learn.memory import HybridPlanner, Memory, RandomIndex, RawIndex, RecallPlanner  # noqa: E402
from gcm_learn.memory import SplinesPlanner, unverified  # noqa: E402
from gcm_learn.memory.pca import PcaIndex  # noqa: E402
from gcm_learn.memory.recall import LearnedIndex  # noqa: E402
from gcm_learn.memory.remember import remember  # noqa: E402
from gcm_learn.situation import Situation  # noqa: E402

STRATA = ("L", "W", "Q")
FITTED = 3000  # situations that controls with something to fit are fitted to
MAPS = 10_000  # memories up to which the maps of principal components are made
Ask = Callable[[Situation], dict[str, object]]


def questions(records: dataset.Dataset, count: int) -> list[tuple[str, str, Situation]]:
    """Stratum, family and situation of the first test records of every stratum."""
    out = []
    for stratum in STRATA:
        some = records.where(split="test", stratum=stratum)
        out += [(stratum, r.family, r.situation) for r in some[:count]]
    return out


def cut(folder: Path, size: int) -> Memory:
    """The first `size` memories of a shuffled memory; smaller ones are parts of larger ones."""
    memory = Memory.load(folder, search="exact")
    order = seeding.rng(4).permutation(len(memory))
    if size < len(memory):
        memory.forget(order[size:])
    return memory


def filed(memory: Memory, encoder: str) -> Iterator[tuple[str, Memory]]:
    """The memory under every index."""
    rng = seeding.rng(5)
    some = rng.permutation(len(memory))[:FITTED].tolist()
    sample = [memory.situation(k) for k in some]
    learned = memory.refiled(LearnedIndex(load_encoder(encoder)))
    learned.search = "cells"
    yield "learned", learned
    yield "raw", memory.refiled(RawIndex.fit(sample))
    if len(memory) <= MAPS:
        yield "pca", memory.refiled(PcaIndex.fit(sample))
    yield "random", memory.refiled(RandomIndex())


def recalled(planner: RecallPlanner) -> Ask:
    """What a planner that recalls answers, and after how many checks."""

    def ask(situation: Situation) -> dict[str, object]:
        found = planner.recollect(situation)
        return {"caught": found.plan.caught, "checks": found.checked}

    return ask


def planned(name: str, hybrid: RecallPlanner | None = None) -> Ask:
    """What a planner answers; one that is preceded by recall if that is given."""
    planner = get_planner(name) if hybrid is None else HybridPlanner(hybrid, get_planner(name))

    def ask(situation: Situation) -> dict[str, object]:
        return {"caught": planner.plan(situation).caught, "checks": 1}

    return ask


def first_choice(memory: Memory) -> Ask:
    """Whether the first memory holds as it is bent, unverified."""

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
    parser.add_argument("encoder")
    parser.add_argument("--memory", type=Path)
    parser.add_argument("--situations", type=int, default=300, help="of each stratum")
    parser.add_argument("--sizes", type=int, nargs="+", default=[100, 1000, 10_000, 100_000])
    given = parser.parse_args()
    records = dataset.open(given.dataset)
    out = HERE / "out" / f"{load_encoder(given.encoder).key}-{given.situations}"
    out.mkdir(parents=True, exist_ok=True)
    folder = given.memory or HERE / "out" / "memory"
    if not (folder / "manifest.json").exists():
        most = int(1.4 * max(given.sizes))
        remember(records.where(split="train"), "raw", most=most).save(folder)
    asked = questions(records, given.situations)
    for size in given.sizes:
        if (out / f"done-{size}").exists():
            continue
        memory = cut(folder, size)
        for name, part in filed(memory, given.encoder):
            answered(out / f"{name}-{size}.jsonl", name, size, recalled(RecallPlanner(part)), asked)
            answered(out / f"{name}-1-{size}.jsonl", f"{name}, first, as bent", size,
                     first_choice(part), asked)  # fmt: skip
            if name == "learned" and size == max(given.sizes):
                hybrid = planned("layered", RecallPlanner(part))
                answered(out / "hybrid.jsonl", "hybrid", size, hybrid, asked)
        (out / f"done-{size}").touch()
    answered(out / "splines.jsonl", "splines-random", 0, _splines(), asked)
    for name in ("layered", "marching", "gcm"):
        answered(out / f"{name}.jsonl", name, 0, planned(name), asked)
    lines = [json.loads(x) for f in sorted(out.glob("*.jsonl")) for x in f.open()]
    write_table(HERE / "table.md", lines)
    write_figure(HERE / "figure.png", lines)


def _splines() -> Ask:
    planner = SplinesPlanner()
    return lambda situation: {"caught": planner.plan(situation).caught, "checks": 20}


if __name__ == "__main__":
    main()
