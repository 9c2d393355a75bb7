"""Do maps find memories better than raw parameters do?

python -m experiments 10_map_embedding PLANE ENCODERS     a sheet, its page and tables in out/

PLANE is the folder of `gcm-learn generate data/specs/recall.toml`, ENCODERS holds the encoders of
maps `map-1`, `map-2` and `map-3`, by their seeds. Encoders of raw parameters start from the same
one of paths, and take as many lessons. All file the shipped memory, whose maps were among the
maps of the lessons. Option --memory takes another memory.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import replace
from itertools import count
from pathlib import Path

import numpy as np

from gcm_learn import dataset
from gcm_learn.dataset import make_item, read_spec
from gcm_learn.evaluation import Case, Entrant, ask, page, pairs, shares
from gcm_learn.recall import (
    Effort,
    EncoderConfig,
    LearnedIndex,
    Memory,
    RandomIndex,
    RawIndex,
    RecallPlanner,
    Scale,
    Trainer,
    TransferLabels,
    load_encoder,
    raw_features,
    shipped_memory,
)

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
SEED, COUNT = 0x42AD6AA0, 300  # of the questions: the commit before the encoders; of each stratum
SEEDS, TURNS, CHECKS = (1, 2, 3), 4, (1, 20)
PAIRS = [
    (f"{first}, {checks}", f"{second}, {checks}")
    for checks in CHECKS
    for first, second in (
        ("maps", "traces"), ("maps", "raw, learned"), ("maps", "raw neighbours"),
        ("raw, learned", "raw neighbours"), ("maps", "random"),
    )
]  # fmt: skip


def fresh(wanted: int) -> Iterator[Case]:
    """Yield situations of W and of Q as the fast planners sort them, families of the training."""
    spec = replace(read_spec(ROOT / "data/specs/recall.toml"), seed=SEED, count=10**6, map="none")
    spec, found = replace(spec, strata={"W": 1.0, "Q": 1.0}), {"W": 0, "Q": 0}
    for k in count():
        record = make_item(spec, k)
        if record.error is None and not record.split.startswith("test-"):
            if found[record.stratum] < wanted:
                found[record.stratum] += 1
                yield Case(record.situation, "fresh", record.family, record.stratum)
        if min(found.values()) == wanted:
            return


def memories(
    records: dataset.Dataset, encoders: Path, catches: Memory
) -> Iterator[tuple[str, int, Memory]]:
    """Yield a memory filed in each way under each seed."""
    situations, teacher = catches.situations(), load_encoder(ROOT / "models/encoder")
    traces = catches.refiled(LearnedIndex(teacher))
    raw, labels = RawIndex.fit(situations), TransferLabels(records, SEEDS[0])
    scale = Scale.of(np.array([raw_features(s) for s in labels.situations]))
    labels.map_features = scale(np.array([raw_features(s) for s in labels.situations]))
    rows = scale(np.array([raw_features(s) for s in situations]))
    for seed in SEEDS:
        config, work = EncoderConfig(memory="map", seed=seed), HERE / "out" / f"raw-{seed}"
        learned = Trainer(config, labels, work, Effort(turns=TURNS), teacher).run()
        keys = learned._memory["map"](rows)
        yield "raw, learned", seed, catches.refiled(LearnedIndex(learned), keys)
        maps = LearnedIndex(load_encoder(encoders / f"map-{seed}"))
        yield "maps", seed, catches.refiled(maps)
        yield "traces", seed, traces
        yield "raw neighbours", seed, catches.refiled(raw)
        yield "random", seed, catches.refiled(RandomIndex(seed))


def main() -> None:
    """Train and ask; write what came of it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("plane")
    parser.add_argument("encoders", type=Path)
    parser.add_argument("--count", type=int, default=COUNT, help="situations of each stratum")
    parser.add_argument("--memory", help="folder of a memory in place of the shipped one")
    given = parser.parse_args()
    memory = Memory.load(given.memory) if given.memory else shipped_memory("recall")
    out = HERE / "out" / (Path(given.memory).name if given.memory else "shipped")
    entrants = [
        Entrant(f"{name}, {checks}", RecallPlanner(filed, checks), seed)
        for name, seed, filed in memories(dataset.open(given.plane), given.encoders, memory)
        for checks in CHECKS
    ]
    sheet = ask(entrants, list(fresh(given.count)), keep=out)
    sheet.save(out / "sheet.parquet")
    told = [shares(sheet), shares(sheet, ("entrant", "stratum")), pairs(sheet, PAIRS)]
    (out / "table.md").write_text("\n\n".join(map(str, told)) + "\n", "utf-8")
    print(f"Open {page(sheet, out).as_uri()} in a browser.")


if __name__ == "__main__":
    main()
