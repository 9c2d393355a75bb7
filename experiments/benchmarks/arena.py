"""Steps a second of the arena, beside Gymnasium's Pendulum-v1.

    python -m experiments benchmarks/arena [--rounds 12]      the end of `make bench`

Actions are random. Planar situations have three bodies: a target and two obstacles drawn anywhere.
Others are of `crossing-swarm-space` and `throw-chain`. The time of one core is that for which its
thread was busy, so it is good on a shared machine too. The time of all cores is the clock's, which
other programs disturb. Rounds take turns, so that disturbances meet all alike. The medians are
printed, first those that have a target.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("NUMBA_NUM_THREADS", "1")

import argparse
import time
from collections.abc import Callable

import gymnasium
import numpy as np

from gcm_learn import families, rng
from gcm_learn.envs import CatchArms, CatchArms3D, CatchArmsPhysics, CatchChains, Pool
from gcm_learn.envs.vector import ManyArms
from gcm_learn.motion.rules import start_clearance
from gcm_learn.scene.packing import pack
from gcm_learn.situation import Situation

BODIES, SITUATIONS = 3, 256
FAMILY, CHAINS = "crossing-swarm-space", "throw-chain"
CORES = os.cpu_count() or 1
ARMS, STEPS = 512, 64  # of a core in a round of the batch
SINGLE = 4000  # steps of a round of a single environment
Clock = Callable[[], float]


def situations() -> list[Situation]:
    """Situations with three bodies, the limb free."""
    found: list[Situation] = []
    k = 0
    while len(found) < SITUATIONS:
        drawn = families.draw("random-planar", 3, k)
        k += 1
        if len(drawn.bodies) == BODIES and start_clearance(pack(drawn)) > 0.0:
            found.append(drawn)
    return found


def batch(arms: ManyArms, clock: Clock) -> float:
    """Steps a second of a round of all arms."""
    shape = (STEPS, arms.num_envs, arms.plant.commands)
    actions = rng(0).uniform(-1.0, 1.0, shape).astype(np.float32)
    since = clock()
    for action in actions:
        arms.step(action)
    return STEPS * arms.num_envs / (clock() - since)


def single(env: gymnasium.Env) -> float:
    """Steps a second of a round of one environment, resets among them."""
    env.reset(seed=0)
    actions = [env.action_space.sample() for _ in range(SINGLE)]
    since = time.thread_time()
    for action in actions:
        _, _, ended, late, _ = env.step(action)
        if ended or late:
            env.reset()
    return SINGLE / (time.thread_time() - since)


def main() -> None:
    """Measure everything in turns."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=12)
    rounds = parser.parse_args().rounds
    pool = Pool.of(situations())
    one, crew = CatchArms(ARMS, pool), CatchArms(CORES * ARMS, pool, threads=CORES)
    fan = CatchArms(ARMS, pool, fan=True)
    many = CatchArms3D(ARMS, FAMILY, pool=SITUATIONS)
    space = CatchArms3D(CORES * ARMS, many.pool, threads=CORES)
    chains = CatchChains(ARMS, CHAINS, pool=SITUATIONS)
    made = gymnasium.make("gcm_learn:CatchArm-v0", situations=pool)
    made_3d = gymnasium.make("gcm_learn:CatchArm3D-v0", situations=many.pool)
    physical = CatchArmsPhysics(16, FAMILY, pool=SITUATIONS)
    pendulum = gymnasium.make("Pendulum-v1")
    rows: dict[str, Callable[[], float]] = {
        "batch, a core": lambda: batch(one, time.thread_time),
        "batch, all cores, by the clock": lambda: batch(crew, time.perf_counter),
        "batch with the fan, a core": lambda: batch(fan, time.thread_time),
        "batch in space, a core": lambda: batch(many, time.thread_time),
        "batch in space, all cores": lambda: batch(space, time.perf_counter),
        "batch of Pandas, a core": lambda: batch(chains, time.thread_time),
        "16 arms with mass, a core": lambda: batch(physical, time.thread_time),
        "one CatchArm-v0": lambda: single(made),
        "one CatchArm3D-v0": lambda: single(made_3d),
        "one Pendulum-v1": lambda: single(pendulum),
    }
    for arms in (one, crew, fan, many, space, chains, physical):
        arms.reset(seed=0)
    seen: dict[str, list[float]] = {name: [] for name in rows}
    for k in range(rounds + 1):
        for name, measure in rows.items():
            rate = measure()
            if k:  # the first is to compile
                seen[name].append(rate)
    ratio = np.array(seen["one CatchArm-v0"]) / np.array(seen["one Pendulum-v1"])
    print(f"one CatchArm-v0 / one Pendulum-v1   [at least 1 x]\n    {np.median(ratio):.2f} x")
    print("batch on all cores   [at least 500,000 steps/s on two]")
    print(f"    {np.median(seen['batch, all cores, by the clock']):,.0f} steps/s on {CORES}")
    print("batch in space on all cores   [at least 150,000 steps/s on two]")
    print(f"    {np.median(seen['batch in space, all cores']):,.0f} steps/s on {CORES}")
    for name, rates in seen.items():
        low, middle, high = np.quantile(rates, [0.0, 0.5, 1.0])
        print(f"    {name:30} {middle:>9,.0f} steps/s ({low:,.0f} to {high:,.0f})")


if __name__ == "__main__":
    main()
