"""Do maps find memories of a Panda, whose map is a coarse front over the hand's places?

python -m experiments 10_map_embedding/panda     a sheet, its page and tables in out/panda/

The memory that ships is filed by the encoders of paths and of maps that ship, and in two ways
without learning.
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
from gcm_learn.recall import RandomIndex, RawIndex, RecallPlanner, shipped_memory

HERE = Path(__file__).resolve().parent
ROOT, OUT = HERE.parents[1], HERE / "out" / "panda"
SEED, COUNT, CHECKS = 0x42AD6AA0, 100, (1, 20)  # of W and Q together


def fresh() -> Iterator[Case]:
    """Yield situations of W and Q of the training's families, as straight moves and search say."""
    spec = replace(read_spec(ROOT / "data/specs/recall-panda.toml"), seed=SEED, count=10**6)
    for k in count():
        record = make_item(spec, k)
        if record.error is None and record.stratum in "WQ" and record.split != "test-family":
            yield Case(record.situation, "fresh", record.family, record.stratum)


def main() -> None:
    """Ask, and write what came of it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=COUNT, help="situations of W and Q")
    wanted = parser.parse_args().count
    memory = shipped_memory("recall", CHAIN)
    situations = memory.situations()
    filed = {
        "maps": shipped_memory("recall-map", CHAIN),
        "traces": memory,
        "raw neighbours": memory.refiled(RawIndex.fit(situations)),
        "random": memory.refiled(RandomIndex()),
    }
    entrants = [
        Entrant(f"{name}, {checks}", RecallPlanner(one, checks))
        for name, one in filed.items()
        for checks in CHECKS
    ]
    sheet = ask(entrants, list(islice(fresh(), wanted)), keep=OUT)
    sheet.save(OUT / "sheet.parquet")
    told = [(f"maps, {n}", f"{other}, {n}") for n in CHECKS for other in filed if other != "maps"]
    text = "\n\n".join(map(str, [shares(sheet), pairs(sheet, told)]))
    (OUT / "table.md").write_text(text + "\n", "utf-8")
    print(f"Open {page(sheet, OUT).as_uri()} in a browser.")


if __name__ == "__main__":
    main()
