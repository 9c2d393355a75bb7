"""Time to a first verified catch in space, and to giving up, beside scikit-fmm on 80^3 cells.

python -m experiments benchmarks/first_catch --count 20      so many situations of each family
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("NUMBA_NUM_THREADS", "1")

import argparse
import time

import numpy as np

from gcm_learn import families
from gcm_learn.planners import TreeSearch, search_in_space

CELLS = 80
REPEATS = 5
SHOWN = (50, 90, 100)  # percentiles


def marching_ms() -> float:
    """Median time of scikit-fmm, order 2, from the middle of a cube without obstacles [ms]."""
    import skfmm

    place = np.linspace(-1.0, 1.0, CELLS)
    x, y, z = np.meshgrid(place, place, place, indexing="ij")
    ball, speed = np.sqrt(x * x + y * y + z * z) - 0.05, np.ones((CELLS,) * 3)
    spent = []
    for _ in range(REPEATS):
        began = time.perf_counter()
        skfmm.travel_time(ball, speed, dx=float(place[1] - place[0]), order=2)
        spent.append(1e3 * (time.perf_counter() - began))
    return float(np.median(spent))


def plans(planner: TreeSearch, count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Return whether each situation is caught, and the time that it takes [ms]."""
    names = families.family_names("spatial")
    drawn = [families.draw(name, seed, k) for k in range(count) for name in names]
    for situation in drawn[: len(names)]:  # compiles
        planner.plan(situation)
    made = [planner.plan(situation) for situation in drawn]
    return np.array([p.caught for p in made]), np.array([p.planning_ms for p in made])


def line(name: str, spent: np.ndarray, peer: float) -> str:
    """One row: how many, percentiles of the time, and the same in times of scikit-fmm."""
    if spent.size == 0:
        return f"{name:24s}    0"
    at = np.percentile(spent, SHOWN)
    ratios = "  ".join(f"{value / peer:7.3f}" for value in at)
    return f"{name:24s} {spent.size:4d}  " + "  ".join(f"{v:8.2f}" for v in at) + f"   {ratios}"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=20, help="situations of each family")
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    try:
        peer = marching_ms()
    except ImportError:
        peer = float("nan")
    print(f"scikit-fmm, order 2, {CELLS}^3: {peer:.0f} ms")
    print(f"{'[ms]':24s}    n    median       90%       max   the same, in its times")
    for name, planner in (
        ("first catch", TreeSearch()),
        ("default", search_in_space()),
    ):
        caught, spent = plans(planner, asked.count, asked.seed)
        print(line(name, spent[caught], peer))
        print(line("  giving up", spent[~caught], peer))


if __name__ == "__main__":
    main()
