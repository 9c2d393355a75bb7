"""Share of catches that have a verified stop, by family, as a table.

python -m experiments benchmarks/stops > experiments/benchmarks/stops.md
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable

from gcm_learn import families, solve
from gcm_learn.errors import StopError
from gcm_learn.motion import with_stop

FAMILIES = ("conveyor-chain", "panda-crowded-accelerated", "panda-easy", "sequence-chain")
SEED = 5


def stops(family: str, count: int) -> tuple[int, int]:
    """Return the numbers of catches, and of those that can brake afterwards."""
    caught = stopped = 0
    for k in range(count):
        situation = families.draw(family, SEED, k)
        plan = solve(situation)
        if plan.trajectory is not None and plan.caught:
            caught += 1
            try:
                with_stop(situation, plan.trajectory)
                stopped += 1
            except StopError:
                pass
    return caught, stopped


def table(rows: Iterable[tuple[str, int, int]], count: int) -> str:
    """Return the table of families, with all of them in the last row."""
    listed = list(rows)
    listed.append(("all", sum(r[1] for r in listed), sum(r[2] for r in listed)))
    lines = [f"| {name} | {c} | {s} | {100 * s / max(c, 1):.0f} |" for name, c, s in listed]
    head = "| family | caught | with a verified stop | share [%] |\n|---|---|---|---|"
    return f"`search` on {count} draws of each family (seed {SEED}).\n\n{head}\n" + "\n".join(lines)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=40, help="draws of each family")
    count = parser.parse_args().count
    print(table(((name, *stops(name, count)) for name in FAMILIES), count))


if __name__ == "__main__":
    main()
