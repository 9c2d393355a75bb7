"""Do maps find memories of a Panda, whose map is a coarse front over the hand's places?

python -m experiments 10_map_embedding/panda ENCODERS     a sheet, its page and tables in out/panda/

ENCODERS holds the encoders of maps `panda-map-2` and `panda-map-3`, by their seeds; the one that
ships has seed 1. They file the memory that ships, as do its encoder of paths and two ways without
learning.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import replace
from itertools import count, islice
from pathlib import Path

from gcm_learn.arms import CHAIN
from gcm_learn.dataset import make_item, read_spec
from gcm_learn.evaluation import Case, Entrant, ask, page, pairs, shares
from gcm_learn.recall import (
    LearnedIndex,
    Memory,
    RandomIndex,
    RawIndex,
    RecallPlanner,
    load_encoder,
    shipped_memory,
)

HERE = Path(__file__).resolve().parent
ROOT, OUT = HERE.parents[1], HERE / "out" / "panda"
SEED, COUNT, CHECKS = 0x42AD6AA0, 100, (1, 20)  # of W and Q together
SEEDS = (1, 2, 3)


def fresh() -> Iterator[Case]:
    """Yield situations of W and Q of the training's families, as straight moves and search say."""
    spec = replace(read_spec(ROOT / "data/specs/recall-panda.toml"), seed=SEED, count=10**6)
    for k in count():
        record = make_item(spec, k)
        if record.error is None and record.stratum in "WQ" and record.split != "test-family":
            yield Case(record.situation, "fresh", record.family, record.stratum)


def memories(encoders: Path) -> Iterator[tuple[str, int, Memory]]:
    """Yield the memory filed in each way under each seed."""
    memory, maps = shipped_memory("recall", CHAIN), shipped_memory("recall-map", CHAIN)
    raw = memory.refiled(RawIndex.fit(memory.situations()))
    for seed in SEEDS:
        if seed > 1:
            maps = memory.refiled(LearnedIndex(load_encoder(encoders / f"panda-map-{seed}")))
        yield "maps", seed, maps
        yield "traces", seed, memory
        yield "raw neighbours", seed, raw
        yield "random", seed, memory.refiled(RandomIndex(seed))


def main() -> None:
    """Ask, and write what came of it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("encoders", type=Path)
    parser.add_argument("--count", type=int, default=COUNT, help="situations of W and Q")
    given = parser.parse_args()
    entrants = [
        Entrant(f"{name}, {checks}", RecallPlanner(filed, checks), seed)
        for name, seed, filed in memories(given.encoders)
        for checks in CHECKS
    ]
    sheet = ask(entrants, list(islice(fresh(), given.count)), keep=OUT)
    sheet.save(OUT / "sheet.parquet")
    names = [name for name in sheet.each("entrant") if not name.startswith("maps")]
    told = [(f"maps, {name.rpartition(' ')[2]}", name) for name in names]
    text = "\n\n".join(map(str, [shares(sheet), pairs(sheet, told)]))
    (OUT / "table.md").write_text(text + "\n", "utf-8")
    print(f"Open {page(sheet, OUT).as_uri()} in a browser.")


if __name__ == "__main__":
    main()
