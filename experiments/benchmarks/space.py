"""Measure maps of hand-space in space on one core, side by side with scikit-fmm.

    python -m experiments benchmarks/space                 two arms, 80 cells a side
    python -m experiments benchmarks/space --cells 40      a smaller lattice

Times are processor times, not the wall clock's. Ratios are medians of paired runs in this one
process: A, B, A, B, ...  "First" is the first map of an arm, for which postures have to be found.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("NUMBA_NUM_THREADS", "1")

import argparse
import itertools
import statistics
import time
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from gcm_learn import MarchingParams, rng
from gcm_learn.arms import Base, SpatialArm
from gcm_learn.charts import HandLattice
from gcm_learn.motion import start_clearance
from gcm_learn.scene import Scene, pack
from gcm_learn.situation import Body, Situation, SolidQuadratic, Sphere, read_situations
from gcm_learn.wave.causal import march_in_space as march
from tests.spatial import EXAMPLES

SCENES, REPEATS = 3, 7
NOWHERE = (50.0, 50.0, 50.0)
STILL = (0.0, 0.0, 0.0)


def scene(arm: SpatialArm, seed: int) -> Situation:
    """Draw four moving spheres and a target far away, so that the whole ball is explored."""
    r, reach = rng(seed, 17), arm.reach
    bodies = [Body("target", "far", Sphere(0.1), SolidQuadratic(NOWHERE, STILL, STILL))]
    for k in range(4):
        way = r.normal(size=3)
        place = tuple((way * r.uniform(0.5, 0.9) * reach / np.linalg.norm(way)).tolist())
        velocity = tuple((r.uniform(-0.5, 0.5, 3) * reach).tolist())
        shape = Sphere(float(r.uniform(0.06, 0.12)) * reach)
        bodies.append(Body("obstacle", f"s{k}", shape, SolidQuadratic(place, velocity, STILL)))
    return Situation(f"four spheres {seed}", 3.0, arm, tuple(bodies))


def wide(arm: SpatialArm) -> Iterator[Scene]:
    """Yield scenes in which the front gets nearly everywhere: blocked ones would flatter us."""
    explore, chart = MarchingParams(n=16, margin=0.0, until="horizon"), HandLattice(arm, 16)
    for situation in (scene(arm, seed) for seed in itertools.count()):
        packed, bare = pack(situation), pack(replace(situation, bodies=situation.targets))
        if start_clearance(packed) <= 0.0:
            continue
        if march(packed, chart, explore).steps > 0.85 * march(bare, chart, explore).steps:
            yield packed


def _ms(f: Callable[[], object]) -> float:
    start = time.process_time()
    f()
    return 1e3 * (time.process_time() - start)


def marching_against_skfmm(arm: SpatialArm, n: int) -> str:
    """First arrivals with four moving spheres against scikit-fmm in the bare ball, order 2."""
    try:
        import skfmm
    except ImportError:
        return "left out: scikit-fmm is not installed"
    explore, lines = MarchingParams(n=n, margin=0.0, until="horizon"), []
    for packed in itertools.islice(wide(arm), SCENES):
        chart = HandLattice(arm, n)
        hands = chart.hands.reshape(n, n, n, 3)
        phi = np.linalg.norm(hands - np.array(chart.hand), axis=-1) - 1.5 * chart.spacing
        masked = np.ma.MaskedArray(phi, np.linalg.norm(hands, axis=-1) > chart.reach)
        first, ones = _ms(lambda: march(packed, chart, explore)), np.ones_like(phi)  # noqa: B023
        pairs = [
            (
                _ms(lambda: march(packed, chart, explore)),  # noqa: B023
                _ms(lambda: skfmm.travel_time(masked, ones, dx=chart.spacing, order=2)),  # noqa: B023
            )
            for _ in range(REPEATS)
        ]
        ours, theirs = (statistics.median(column) for column in zip(*pairs, strict=True))
        ratio = statistics.median(a / b for a, b in pairs)
        steps = march(packed, chart, explore).steps
        lines.append(
            f"{ratio:.2f} x, first {first / theirs:.2f} x  "
            f"({ours:.0f} ms against {theirs:.0f} ms; {steps} cells)"
        )
    return "\n    ".join(lines)


def main() -> None:
    """Print a block for each arm."""
    parser = argparse.ArgumentParser(description="Measure maps in space on one core.")
    parser.add_argument("--cells", type=int, default=80, help="cells along a side")
    n = parser.parse_args().cells
    examples = read_situations(EXAMPLES)
    for what, k in (("a human-like arm", 0), ("NAO's arm", 4)):
        arm = replace(examples[k].arm, base=Base())
        print(f"marching in space / scikit-fmm order 2, {what}")
        print(f"    {marching_against_skfmm(arm, n)}", flush=True)


if __name__ == "__main__":
    main()
