"""Table of what clouds and meshes cost: trees, distances, and plans beside those among solids.

python -m experiments benchmarks/world > experiments/benchmarks/world.md
python -m experiments benchmarks/planted >> experiments/benchmarks/world.md
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from gcm_learn import families, solve
from gcm_learn.compiled import njit
from gcm_learn.families.chain.measured import cloud_of, mesh_of
from gcm_learn.planners import plan_to_json
from gcm_learn.referee import examine
from gcm_learn.scene import pack
from gcm_learn.scene.shapes.choice import gap_of_bone
from gcm_learn.situation import Body, Box, Situation, situation_to_json

Change = Callable[[np.random.Generator, Body], Body]
PRESETS, SEED, RADIUS = ("panda-easy", "panda-crowded"), 6, 0.005


def points(count: int) -> Change:
    """Return a change of a solid into so many points on its surface."""
    return lambda rng, body: replace(body, shape=cloud_of(rng, mesh_of(body.shape), count, RADIUS))


CHANGES: dict[str, Change] = {
    "solids": lambda rng, body: body,
    "clouds of 1,000 points": points(1000),
    "clouds of 20,000 points": points(20_000),
    "meshes": lambda rng, body: replace(body, shape=mesh_of(body.shape)),
}


def changed(situation: Situation, change: Change, seed: int) -> Situation:
    """Return a situation with other shapes of its obstacles."""
    rng = np.random.default_rng(seed)
    bodies = (b if b.role == "target" else change(rng, b) for b in situation.bodies)
    return replace(situation, bodies=tuple(bodies), format="gcm-learn/situation@4")


def swarm(k: int, count: int = 50, size: int = 200) -> tuple[Situation, Situation]:
    """Return a Panda among so many balls that fly, and the same as clouds of so many points."""
    config = {"family": "swarm-chain", "strays": [count, count], "stray": [0.02, 0.03]}
    family = families.family_from_dict({**config, "arm": {"model": "panda"}})
    solid: Any = families.draw(family, SEED, k)
    return solid, changed(solid, points(size), k)


def timed(situation: Situation) -> tuple[float, bool, bool]:
    """Return the time of a plan [ms], whether it caught, and whether its promise is broken."""
    pack(situation)  # trees are built once
    took = []
    for _ in range(2):
        began = time.process_time()
        plan = solve(situation)
        took.append(1e3 * (time.process_time() - began))
    answer = plan_to_json(plan)
    return min(took), plan.caught, bool(examine(situation_to_json(situation), answer).complaints)


def row(name: str, pairs: list[tuple[Situation, Situation]]) -> str:
    """Return the row of what changed situations cost beside those among solids."""
    before, after = ([timed(s) for s in column] for column in zip(*pairs, strict=True))
    ratios = [b[0] / a[0] for a, b in zip(before, after, strict=True)]
    cost = f"{np.median([t for t, *_ in before]):.1f} | {np.median([t for t, *_ in after]):.1f}"
    caught = f"{sum(c for _, c, _ in before)} | {sum(c for _, c, _ in after)}"
    spread = f"{np.median(ratios):.2f} | {np.quantile(ratios, 0.9):.2f}"
    return f"| {name} | {len(pairs)} | {cost} | {spread} | {caught} | {sum(b for *_, b in after)} |"


@njit
def _gaps(bodies, p, q):
    total = 0.0
    for i in range(len(p)):
        a, b = (p[i, 0], p[i, 1], p[i, 2]), (q[i, 0], q[i, 1], q[i, 2])
        total += gap_of_bone(bodies, 0, a, b, 1e300, 1e300)
    return total


def distances(count: int) -> str:
    """Return times of the tree of a box's cloud, and of a capsule's exact distance to it."""
    rng = np.random.default_rng(SEED)
    cloud = cloud_of(rng, mesh_of(Box((0.3, 0.3, 0.3))), count, RADIUS)
    situation = changed(families.draw("panda-easy", SEED, 0), lambda rng, body: body, 0)
    body = replace(situation.obstacles[0], shape=cloud)
    began = time.process_time()
    bodies = pack(replace(situation, bodies=(body, *situation.targets))).bodies
    tree = 1e3 * (time.process_time() - began)
    p = rng.uniform(-0.8, 0.8, (5000, 3))
    q, took = p + 0.15 * rng.normal(size=p.shape), []
    for _ in range(6):
        began = time.process_time()
        _gaps(bodies, p, q)
        took.append(time.process_time() - began)
    return f"| {count:,} | {tree:.1f} | {1e6 * min(took) / len(p):.2f} |"


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=30, help="draws of each preset")
    count = parser.parse_args().count
    solids = [families.draw(name, SEED, k) for name in PRESETS for k in range(count)]
    solve(solids[0])  # kernels are loaded
    print(f"`search` on {count} draws each of {' and '.join(PRESETS)} (seed {SEED}), and among")
    print("50 flying balls. Times are of one core, without trees; ratios are of pairs.\n")
    print("| obstacles | plans | solids [ms] | these [ms] | ratio | 90 % | solids caught | caught"
          " | broken |\n|---|---|---|---|---|---|---|---|---|")  # fmt: skip
    for name, change in list(CHANGES.items())[1:]:
        print(row(name, [(s, changed(s, change, k)) for k, s in enumerate(solids)]))
    print(row("50 moving clouds of 200 points", [swarm(k) for k in range(count)]))
    print(
        "\nThe tree of a cloud, with all that packing takes, and the exact distance of a capsule:\n"
    )
    print("| points | tree [ms] | distance [us] |\n|---|---|---|")
    for size in (1000, 10_000, 20_000):
        print(distances(size))


if __name__ == "__main__":
    main()
