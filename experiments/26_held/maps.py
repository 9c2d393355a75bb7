"""Ask memories of held catches that are found by their maps, their movements, or raw parameters.

gcm-learn generate MAPS.toml --out DATASET    panda-held.toml with maps
gcm-learn train encoder DATASET --memory map --out ENCODERS/map-1 --turns 30 --dim 48 --seed 1
gcm-learn train encoder DATASET --memory trace --out ENCODERS/trace-1 --turns 30 --dim 48 --seed 1
python -m experiments 26_held/maps DATASET ENCODERS    maps.md

MAPS.toml is data/specs/panda-held.toml with map = "marching", n = 24 and count = 1200.
"""

from __future__ import annotations

import argparse
from itertools import count, islice
from pathlib import Path
from typing import Any

from gcm_learn import dataset, seeding, solve
from gcm_learn.evaluation import Case, Entrant, ask, pairs, shares
from gcm_learn.recall import LearnedIndex, RandomIndex, RawIndex, RecallPlanner, remember

HERE = Path(__file__).resolve().parent
SPEC = HERE.parents[1] / "data" / "specs" / "panda-held.toml"
SEED, COUNT, CHECKS, SEEDS = 0x46, 150, (1, 20), (1, 2)
WAYS = ("maps", "traces", "raw neighbours", "random")


def fresh() -> Any:
    """Yield draws that the search catches."""
    drawn = dataset.read_spec(SPEC).drawn
    for k in count():
        share = drawn[k % len(drawn)]
        situation: Any = share.draw(seeding.rng(SEED, k), f"{share.family}-{k}")
        if solve(situation).caught:
            yield Case(situation, "fresh", share.family)


def main() -> None:
    """Ask, and write the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("records", type=Path)
    parser.add_argument("encoders", type=Path)
    given = parser.parse_args()
    records, entrants = dataset.open(given.records).where(split="train"), []
    for n in SEEDS:
        made = [LearnedIndex.load(given.encoders / f"{kind}-{n}") for kind in ("map", "trace")]
        memory = remember(records, made[1])
        plain = [index.fit(memory.situations(), n) for index in (RawIndex, RandomIndex)]
        filed = [remember(records, made[0]), memory, *map(memory.refiled, plain)]
        entrants += [
            Entrant(f"{way}, {checks}", RecallPlanner(one, checks), n)
            for way, one in zip(WAYS, filed, strict=True)
            for checks in CHECKS
        ]
    sheet = ask(entrants, list(islice(fresh(), COUNT)))
    compared = [(f"maps, {k}", f"{way}, {k}") for way in WAYS[1:] for k in CHECKS]
    told = "\n\n".join(map(str, [shares(sheet), pairs(sheet, compared)])) + "\n"
    (HERE / "maps.md").write_text(told, "utf-8")
    print(told)


if __name__ == "__main__":
    main()
