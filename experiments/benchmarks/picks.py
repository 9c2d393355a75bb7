"""Table of the share of held catches that `search` finds, by preset.

python -m experiments benchmarks/picks > experiments/benchmarks/picks.md
"""

from __future__ import annotations

import argparse
import time

import numpy as np

from gcm_learn import families, solve
from gcm_learn.planners import plan_to_json
from gcm_learn.referee import examine
from gcm_learn.situation import situation_to_json

PRESETS = [name for name in families.PRESETS if families.preset_families(name)[0].holds.share]
SEED = 5


def row(preset: str, count: int) -> str:
    """Return the preset's row: drawn with places, caught, placed, times, broken promises."""
    places = placed = broken = 0
    times = []
    for k in range(-1, count):  # once for nothing: kernels are loaded
        situation = families.draw(preset, SEED, max(k, 0))
        began = time.process_time()
        plan = solve(situation)
        took = 1e3 * (time.process_time() - began)
        if k >= 0:
            broken += bool(examine(situation_to_json(situation), plan_to_json(plan)).complaints)
            places += situation.targets[0].place is not None
            placed += plan.placed is not None
            times += [took] if plan.caught else []
    most = np.quantile(times, (0.5, 0.9))
    counts = f"{100 * len(times) / count:.0f} | {places} | {placed}"
    return f"| {preset} | {counts} | {most[0]:.0f} | {most[1]:.0f} | {broken} |"


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=100, help="draws of each preset")
    count = parser.parse_args().count
    print(f"`search` on {count} draws of each preset (seed {SEED}). Times are of those caught.\n")
    print("| preset | caught [%] | with a place | placed | median [ms] | 90 % [ms] | broken |")
    print("|---|---|---|---|---|---|---|")
    for name in PRESETS:
        print(row(name, count))


if __name__ == "__main__":
    main()
