"""Measure the families: strata, thrown-away draws and cost; write a table.

python -m experiments 03_families              300 situations a family: half an hour on one core
python -m experiments 03_families --count 30   a quick look
python -m experiments 03_families --kind chain  families for chains, likewise `spatial`
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from time import process_time
from typing import NamedTuple

from experiments.common.tables import line, table
from gcm_learn import seeding
from gcm_learn.families import draw, family_names, get_family
from gcm_learn.motion.rules import start_clearance
from gcm_learn.planners import solve
from gcm_learn.scene.packing import pack
from gcm_learn.situation import AnySituation

HERE = Path(__file__).resolve().parent
SEED = 20
FRONTS = {"straight": "L", "marching": "W", "layered": "Q"}


class Measured(NamedTuple):
    """Families of one kind of arm: the table's file, planners with their strata, and examples."""

    file: str
    names: tuple[str, ...]
    planners: dict[str, str]
    warm: tuple[str, ...]


IN_SPACE = tuple(family_names("spatial"))
WITH_CHAINS = tuple(family_names("chain"))
KINDS = {
    "planar": Measured("table.md", tuple(family_names("planar")), FRONTS, ("gate", "pendulum")),
    "spatial": Measured("table-space.md", IN_SPACE, FRONTS, IN_SPACE),
    "chain": Measured("table-chain.md", WITH_CHAINS, {"straight": "L", "search": "W"}, WITH_CHAINS),
}
BATCH = 25  # draws that are timed together; the fastest batch is the least disturbed one


def blocked(situation: AnySituation) -> bool:
    """Return whether the limb touches something at t = 0."""
    return start_clearance(pack(situation)) <= 0.0


def timed(work: Callable[[], object]) -> tuple[object, float]:
    """Return the result of some work, and its processor time [ms]."""
    before = process_time()
    result = work()
    return result, 1e3 * (process_time() - before)


def row(name: str, count: int, planners: dict[str, str]) -> list[str]:
    """Return what is measured of one family."""
    family = get_family(name)
    sketches = (family.sketch(seeding.rng(SEED + 1, k), "x") for k in range(count))
    thrown = sum(map(blocked, sketches)) / count
    situations: list[AnySituation] = []
    batches = []
    for first in range(0, count, BATCH):
        last = min(first + BATCH, count)
        drawn, ms = timed(lambda a=first, b=last: [draw(family, SEED, k) for k in range(a, b)])
        situations += drawn
        batches.append(1e3 * ms / (last - first))
    strata = dict.fromkeys((*planners.values(), "U"), 0)
    spent: dict[str, list[float]] = {planner: [] for planner in planners}
    for situation in situations:
        found = "U"
        for planner, stratum in planners.items():
            plan, ms = timed(lambda p=planner, s=situation: solve(s, p))
            spent[planner].append(ms)
            if found == "U" and plan.caught:
                found = stratum
        strata[found] += 1
    shares = [f"{100 * strata[s] / count:.0f}" for s in strata]
    means = [f"{sum(ms) / count:.1f}" for ms in spent.values()]
    final = list(spent.values())[-1]
    slow = f"{sorted(final)[int(0.95 * count)]:.0f}"
    return [name, *shares, f"{100 * thrown:.0f}", f"{min(batches):.0f}", *means, slow]


def main() -> None:
    """Measure all families and write table.md."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=300, help="situations of each family")
    parser.add_argument("--kind", choices=KINDS, default="planar", help="of the families' arms")
    given = parser.parse_args()
    count, measured = given.count, KINDS[given.kind]
    for planner in measured.planners:  # compiled code is loaded before anything is timed
        for name in measured.warm:
            solve(draw(name, SEED, count), planner)
    rows = []
    for name in measured.names:
        rows.append(row(name, count, measured.planners))
        print(line(rows[-1]), flush=True)
    note = f"{count} situations each, seed {SEED}. Shares in %, planners in ms of processor time."
    strata = (*measured.planners.values(), "U")
    head = ("family", *strata, "thrown away", "draw [µs]", *measured.planners, "95 %")
    (HERE / measured.file).write_text(f"{table(head, rows)}\n\n{note}\n", "utf-8")


if __name__ == "__main__":
    main()
