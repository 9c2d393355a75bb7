"""Ask recall and its controls: found again by a learned index, unlearned ones and at random.

python -m experiments 05_recall plane               situations of W and Q: half an hour
python -m experiments 05_recall standin             situations unlike the families'
python -m experiments 05_recall space --count 2000  arms in joints, also off their training;
                                                    space-accelerated and recall-panda likewise

Writes a sheet, its page and a table into out/; Ctrl-C is safe. The tables beside this file are of
earlier runs, in which checks, looks and bends were counted, too.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import Any

from neighbours import ClearanceIndex
from standin import standins

from gcm_learn.arms import CHAIN, PLANAR
from gcm_learn.dataset import make_item, read_spec
from gcm_learn.evaluation import Case, Entrant, ask, cases, page, pairs, shares
from gcm_learn.recall import RandomIndex, RawIndex, RecallPlanner, shipped_memory

HERE = Path(__file__).resolve().parent
SEED, CHECKS = 3887612067, 20
SEEDS = {"space": 3437426931, "space-accelerated": 885590443, "recall-panda": 240_101}
"""By specification of data/specs. In space they are heads of the hashes of the commits that froze
code, memory and encoder; that of the Panda was written down before its memory was trained."""
PLANNERS = ["recall", "recall-1", "recall-raw", "recall-random", "hybrid", "search"]
PARTS = ("plane", "standin", *SEEDS)


def filed(kind: Any, own: Any) -> list[Entrant]:
    """Return the memory of a kind of arm under its own index and others, with 20 checks and one."""
    memory = shipped_memory("recall", kind)
    fits = {"raw": RawIndex} | ({} if own is None else {"clearance": own})
    found = {name: memory.refiled(index.fit(memory.situations())) for name, index in fits.items()}
    found |= {"recall": memory, "random": memory.refiled(RandomIndex())}
    made = {name: RecallPlanner(one, CHECKS) for name, one in found.items()}
    made |= {f"{n}, 1 check": RecallPlanner(one, 1, novelty=0.0) for n, one in found.items()}
    return [Entrant(name, planner) for name, planner in made.items()]


def drawn(name: str, count: int) -> Iterator[Case]:
    """Yield what a specification draws under a seed of its own; the suite is the split."""
    spec = read_spec(HERE.parents[1] / "data" / "specs" / f"{name}.toml")
    spec = replace(spec, seed=SEEDS[name], count=count, audit=0.0)
    for record in (make_item(spec, k) for k in range(count)):
        if record.situation is not None and record.stratum != "U":
            yield Case(record.situation, record.split, record.family, record.stratum)


def main() -> None:
    """Ask, and write what came of it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("part", choices=PARTS)
    parser.add_argument("--count", type=int, default=300, help="of W and of Q, or draws in space")
    part, count = vars(parser.parse_args()).values()
    if part in SEEDS:
        found = list(drawn(part, count))
        entrants = filed(CHAIN, None) if part == "recall-panda" else PLANNERS
    else:
        some = cases("W", "Q", count=count, seed=SEED) if part == "plane" else standins(SEED)
        found, entrants = list(islice(some, 2 * count)), filed(PLANAR, ClearanceIndex)
    sheet = ask(entrants, found, keep=HERE / "out" / part)
    sheet.save(HERE / "out" / part / "sheet.parquet")
    told = [shares(sheet, ("entrant", "stratum")), pairs(sheet, "recall", "suite")]
    (HERE / "out" / part / "table.md").write_text("\n\n".join(map(str, told)) + "\n", "utf-8")
    print(f"Open {page(sheet, HERE / 'out' / part, reference='recall').as_uri()} in a browser.")


if __name__ == "__main__":
    main()
