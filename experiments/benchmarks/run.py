"""Measure the engine on one core, side by side with what a user would take instead.

    make bench             this (about 4 minutes), then datasets (`dataset.py`) and `arena.py`
    python -m experiments benchmarks --situations 2000      fewer random situations

Times are processor times, not the wall clock's.  Ratios are medians of paired runs in this one
process: A, B, A, B, ...  Absolute times are only as good as the machine is quiet.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("NUMBA_NUM_THREADS", "1")

import argparse
import itertools
import statistics
import time
from collections.abc import Callable

import numpy as np
from numba import njit

from gcm_learn import Lattice, MarchingParams, WaveParams, families, get_planner, rng
from gcm_learn.arms import Arm
from gcm_learn.charts import hand_space, occupied_cells
from gcm_learn.evaluation import complaints
from gcm_learn.families import random_planar
from gcm_learn.scene import Scene, pack
from gcm_learn.situation import Body, Disc, PlanarQuadratic, Situation
from gcm_learn.wave import front_speed, kappa_of, stencil
from gcm_learn.wave.causal import march_in_plane as march, march_layers_in_plane as march_layers
from gcm_learn.wave.reference import propagate_reference
from gcm_learn.wave.solver import propagate_in_plane as propagate

SPEED = 3.4  # hand speed at which kappa is about 1/400 s
TAU = 400.0
SCENES = 9
EXPLORE = WaveParams(until="horizon")
MARCH = MarchingParams(until="horizon")


def scene(seed: int) -> Situation:
    """Draw three moving discs and a target far away, so that the whole ring is explored."""
    r = rng(seed, 3)
    hand = (float(r.uniform(0.5, 1.5)), float(r.uniform(-0.5, 0.5)))
    bodies = [Body("target", "far", Disc(0.1), _moving((50.0, 0.0), (0.0, 0.0)))]
    for k in range(3):
        angle, radius = r.uniform(-2.5, 2.5) + np.pi, r.uniform(0.8, 1.8)
        place = (float(radius * np.cos(angle)), float(radius * np.sin(angle)))
        velocity = (float(r.uniform(-1, 1)), float(r.uniform(-1, 1)))
        shape = Disc(float(r.uniform(0.08, 0.15)))
        bodies.append(Body("obstacle", f"disc {k}", shape, _moving(place, velocity)))
    return Situation(f"three discs {seed}", 1.0, Arm(hand, SPEED), tuple(bodies))


def _moving(place: tuple[float, float], velocity: tuple[float, float]) -> PlanarQuadratic:
    return PlanarQuadratic(place, velocity, (0.0, 0.0))


def setting_of(situation: Situation, horizon: float) -> tuple[Scene, Lattice]:
    """Pack a situation, with another horizon, and make the lattice of its arm."""
    arm, scene = situation.arm, pack(situation)
    scene = scene._replace(limits=scene.limits._replace(horizon=horizon))
    return scene, Lattice(80, arm.upper_arm, arm.elbow)


def paired(
    a: Callable[[], object], b: Callable[[], object], repeats: int = 15
) -> tuple[float, float, float]:
    """Medians of a and b [ms] and of the ratio a / b, run in turn, each warm."""
    times = [(_ms(a), _ms(b)) for _ in range(repeats)]
    ratio = statistics.median(x / y for x, y in times)
    return statistics.median(x for x, _ in times), statistics.median(y for _, y in times), ratio


def _ms(f: Callable[[], object]) -> float:
    """Time of one call after another call that finds compiled code and caches [ms]."""
    f()
    start = time.process_time()
    f()
    return 1e3 * (time.process_time() - start)


def over_scenes(pair: Callable[[Situation], tuple[float, float, float]]) -> tuple[float, ...]:
    """Medians of `paired` over the scenes."""
    return tuple(statistics.median(c) for c in zip(*map(pair, SITUATIONS), strict=True))


@njit(cache=True)
def _bare(B, lo, hi, rows, pairs, width):
    """The stencil of Eq. 10 over the whole lattice: no front, no obstacles, no arrival."""
    for _ in range(pairs):
        stencil.two_steps(B, lo, hi, rows, np.float32(0.2), np.float32(0.008), width, 5)


def bare_stencil(steps: int) -> Callable[[], None]:
    """Make a run of the bare stencil over 80 x 80 cells."""
    shape = stencil.layout(80)
    B = np.zeros(shape.length, dtype=np.float32)
    B[2 * shape.plane : 3 * shape.plane] = -2 / 7
    B[3 * shape.plane : 4 * shape.plane] = 0.2
    B[4 * shape.plane : 5 * shape.plane] = 4.0
    lo = np.array([(i + 1) * shape.width + stencil.LEFT for i in range(80)], dtype=np.uint64)
    hi = lo + np.uint64(80)
    return lambda: _bare(B, lo, hi, 80, steps // 2, shape.width)


def wave_against_stencil() -> str:
    """Wave kernel over 400 tau against the bare stencil for as many steps."""
    steps = round(TAU / EXPLORE.step)

    def pair(situation: Situation) -> tuple[float, float, float]:
        setting = setting_of(situation, TAU * kappa_of(*setting_of(situation, 1.0), EXPLORE))
        return paired(lambda: propagate(*setting, EXPLORE), bare_stencil(steps))

    wave, bare, ratio = over_scenes(pair)
    return f"{ratio:.2f} x  ({wave:.2f} ms against {bare:.2f} ms)"


def wave_against_reference() -> str:
    """Wave kernel against plain numpy, the same 400 tau."""
    first = SITUATIONS[0]
    setting = setting_of(first, TAU * kappa_of(*setting_of(first, 1.0), EXPLORE))
    wave, slow, ratio = paired(
        lambda: propagate(*setting, EXPLORE),
        lambda: propagate_reference(*setting, EXPLORE),
        repeats=3,
    )
    return f"{1 / ratio:.0f} x  ({wave:.2f} ms against {slow:.0f} ms)"


def marching_against_skfmm() -> str:
    """Causal marching with three moving discs against scikit-fmm with a static mask."""
    try:
        import skfmm
    except ImportError:
        return "left out: scikit-fmm is not installed"

    def pair(situation: Situation) -> tuple[float, float, float]:
        setting = setting_of(situation, 10.0)
        lattice = setting[1]
        inside = hand_space(lattice).inside.reshape(80, 80)
        phi = distance(*setting) - 1.5 * lattice.spacing
        blocked = ~inside | occupied_cells(situation, lattice, 0.0)
        masked = np.ma.MaskedArray(phi, blocked & (phi > 0))
        ones, h = np.ones_like(phi), float(lattice.spacing)
        return paired(
            lambda: march(*setting, MARCH),
            lambda: skfmm.travel_time(masked, ones, dx=h, order=2),
            repeats=41,
        )

    ours, theirs, ratio = over_scenes(pair)
    return f"{ratio:.2f} x  ({ours:.3f} ms against {theirs:.3f} ms)"


def free_space_errors() -> str:
    """Largest error of the arrival in free space, in cells: marching, scikit-fmm."""
    free = Situation("free", 10.0, Arm((0.9, -0.4), SPEED), SITUATIONS[0].bodies[:1])
    setting = setting_of(free, 10.0)
    lattice = setting[1]
    inside = hand_space(lattice).inside.reshape(80, 80)
    exact, h = distance(*setting), lattice.spacing
    ours = np.abs(march(*setting, MARCH).first * SPEED - exact)[inside].max() / h
    try:
        import skfmm
    except ImportError:
        return f"marching {ours:.1e} cells; scikit-fmm is not installed"
    phi = exact - 1.5 * h
    there = skfmm.travel_time(
        np.ma.MaskedArray(phi, ~inside), np.ones_like(phi), dx=float(h), order=2
    )
    theirs = np.abs(there - np.abs(phi))[inside].max() / h
    return f"marching {ours:.1e}, scikit-fmm {theirs:.2f} cells"


def distance(scene: Scene, lattice: Lattice) -> np.ndarray:
    """Exact distance of every cell to the hand (80, 80)."""
    x = lattice.centres
    return np.hypot(x[None, :] - scene.limb.x, x[:, None] - scene.limb.y)


def anisotropy() -> str:
    """Spread of the free front's speed over directions."""
    five, nine = (front_speed(WaveParams(laplacian=p)).anisotropy for p in (5, 9))
    free = Situation("free", 10.0, Arm((0.025, 0.025), SPEED), SITUATIONS[0].bodies[:1])
    setting = setting_of(free, 10.0)
    far = (distance(*setting) > 1.0) & hand_space(setting[1]).inside.reshape(80, 80)
    speed = distance(*setting)[far] / march(*setting, MARCH).first[far]
    marching = 1.0 - speed.min() / speed.max()
    return (
        f"5-point {100 * five:.1f} %, 9-point {100 * nine:.1f} %, marching {100 * marching:.2g} %"
    )


def plan_against_kernel(situations: int = 120) -> str:
    """Whole plan of caught situations against the wave kernel that stops at the same contact."""
    planner, ratios = get_planner("gcm"), []
    for k in range(situations):
        situation = random_planar(rng(7, k))
        if not planner.plan(situation).caught:
            continue
        setting = setting_of(situation, situation.horizon)
        ratios.append(
            paired(lambda: planner.plan(situation), lambda: propagate(*setting, WaveParams()), 7)[2]  # noqa: B023
        )
    low, mid, high = np.percentile(ratios, [10, 50, 90])
    return f"{mid:.2f} x  (10 to 90 %: {low:.2f} to {high:.2f}; {len(ratios)} plans)"


def layered_against_marching(situations: int = 60) -> str:
    """Layered marching against plain marching on what a straight line does not solve."""
    straight, ratios, times = get_planner("straight"), [], []
    for k, name in itertools.product(
        range(situations), ("random-planar", "crossing-swarm", "gate")
    ):
        situation = families.draw(name, 13, k)
        if straight.plan(situation).caught:
            continue
        setting = setting_of(situation, situation.horizon)
        layers, _, ratio = paired(
            lambda: march_layers(*setting, MarchingParams()),  # noqa: B023
            lambda: march(*setting, MarchingParams()),  # noqa: B023
            5,
        )
        ratios.append(ratio)
        times.append(layers)
    low, mid, high = np.percentile(ratios, [10, 50, 90])
    return (
        f"{mid:.2f} x  (10 to 90 %: {low:.2f} to {high:.2f}; {len(ratios)} situations; "
        f"median {np.median(times):.2f} ms)"
    )


def violations(situations: int) -> str:
    """Plans reported as caught that break a promise, by the independent referee."""
    lines = []
    for name in ("gcm", "marching", "layered", "straight"):
        planner, caught, broken, ms = get_planner(name), 0, 0, []
        for k in range(situations):
            situation = random_planar(rng(11, k))
            plan = planner.plan(situation)
            ms.append(plan.planning_ms)
            if plan.caught:
                caught += 1
                broken += bool(complaints(situation, plan))
        lines.append(
            f"{name}: {broken} of {caught} caught of {situations} "
            f"(median {np.median(ms):.2f} ms, 99 % {np.percentile(ms, 99):.1f} ms)"
        )
    return "\n    ".join(lines)


def scenes() -> list[Situation]:
    """Scenes in which the front gets through most of the ring: blocked ones would flatter us."""
    drawn = (scene(seed) for seed in range(1000))
    wide = (s for s in drawn if march(*setting_of(s, 10.0), MARCH).steps >= 3500)
    return list(itertools.islice(wide, SCENES))


SITUATIONS = scenes()


def main() -> None:
    """Print one line for each measurement, with its target."""
    parser = argparse.ArgumentParser(description="Measure the engine on one core.")
    parser.add_argument("--situations", type=int, default=20_000, help="random situations to judge")
    arguments = parser.parse_args()
    table: list[tuple[str, str, Callable[[], str]]] = [
        ("wave kernel / bare stencil, 400 tau", "at most 0.7 x", wave_against_stencil),
        ("numpy reference / wave kernel", "at least 100 x", wave_against_reference),
        ("marching / scikit-fmm order 2", "at most 0.3 x", marching_against_skfmm),
        ("error in free space", "marching no larger", free_space_errors),
        ("front speed anisotropy", "9-point 3.5 %, marching 1 %", anisotropy),
        ("whole plan / wave kernel alone", "at most 1.3 x", plan_against_kernel),
        ("layered marching / marching", "at most 5 x", layered_against_marching),
        ("broken promises", "0", lambda: violations(arguments.situations)),
    ]
    for what, target, measure in table:
        print(f"{what}   [{target}]\n    {measure()}", flush=True)


if __name__ == "__main__":
    main()
