"""Is this checkout slower than another one?

    python experiments/benchmarks/paired.py OTHER/.venv/bin/python --checkout OTHER

Two processes stay open, one with this checkout and this Python, one with the other's. Each of the
workloads is run by one and the other in turn, and who begins changes. What counts is processor
time, so that a busy machine does little harm. A line for each workload: medians, and the ratio new
to old with its 95 % interval (Student's t over the logarithms of the pairs).
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[2]
PAIRS = 15
SEED = 2024
DRAWN = {"random-planar": 12, "gate": 6, "crossing-swarm": 4, "falling-solid": 3, "pendulum": 3}
PLANNERS = (
    "gcm", "marching", "layered", "straight", "straight-wait", "potential",
    "recall", "hybrid",
)  # fmt: skip
given: list[Path] = []  # the file of --file, if any
STEPS = 1500  # of one arm; of many it is this many in all, ten times


def situations() -> list:
    """Those of the file that was given, or of several families, some of them in space."""
    from gcm_learn import families, read_situations

    if given:
        return read_situations(given[0])
    return [families.draw(name, SEED, k) for name, count in DRAWN.items() for k in range(count)]


def planning(name: str) -> Callable[[], None]:
    """Plans of all situations."""
    from gcm_learn import get_planner

    planner, asked = get_planner(name), situations()
    return lambda: [planner.plan(situation) for situation in asked] and None


def mapping(engine: str) -> Callable[[], None]:
    """Maps of all situations, explored to the horizon."""
    from gcm_learn import MarchingParams, WaveParams, build_map

    params = (WaveParams if engine == "wave" else MarchingParams)(until="horizon")
    asked = situations()
    return lambda: [build_map(situation, params) for situation in asked] and None


def drawing() -> Callable[[], None]:
    """Situations, drawn."""
    return lambda: situations() and None


def one_arm(fan: bool) -> Callable[[], None]:
    """Steps of one arm."""
    import gymnasium

    env = gymnasium.make("gcm_learn:CatchArm-v0", situations=situations(), fan=fan)

    def play() -> None:
        env.reset(seed=0)
        env.action_space.seed(0)
        for _ in range(STEPS):
            _, _, ended, late, _ = env.step(env.action_space.sample())
            if ended or late:
                env.reset()

    return play


def many_arms(fan: bool) -> Callable[[], None]:
    """Steps of a batch of arms."""
    import gymnasium

    envs = gymnasium.make_vec(
        "gcm_learn:CatchArm-v0", num_envs=100, vectorization_mode="vector_entry_point",
        situations=situations(), fan=fan,
    )  # fmt: skip
    rng = np.random.default_rng(0)
    actions = rng.uniform(-1.0, 1.0, (10 * STEPS // 100, 100, 2)).astype(np.float32)

    def play() -> None:
        envs.reset(seed=0)
        for action in actions:
            envs.step(action)

    return play


def reading() -> Callable[[], None]:
    """Situations from JSON and back."""
    from gcm_learn.situation import situation_from_json, situation_to_json

    asked = situations()
    return lambda: [situation_from_json(situation_to_json(s)) for s in asked * 10] and None


WORKLOADS: dict[str, Callable[[], Callable[[], None]]] = {
    **{f"plan {name}": lambda name=name: planning(name) for name in PLANNERS},  # type: ignore[misc]
    "map wave": lambda: mapping("wave"),
    "map marching": lambda: mapping("marching"),
    "draw": drawing,
    "read and write": reading,
    "one arm": lambda: one_arm(False),
    "one arm with its fan": lambda: one_arm(True),
    "100 arms": lambda: many_arms(False),
    "100 arms with fans": lambda: many_arms(True),
}


def serve() -> None:
    """Answer names of workloads with the processor time that they take [s]."""
    ready: dict[str, Callable[[], None]] = {}
    for line in sys.stdin:
        name = line.strip()
        if name not in ready:
            ready[name] = WORKLOADS[name]()
            ready[name]()  # compiles and loads
        ready[name]()  # warms caches again, which the other process has cooled
        start = time.process_time()
        ready[name]()
        print(f"{time.process_time() - start:.9f}", flush=True)


class Side:
    """One of the two processes."""

    def __init__(self, python: str, checkout: Path) -> None:
        options = ["--serve", *(f"--file={path}" for path in given)]
        one = {"NUMBA_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
        self.process = subprocess.Popen(
            [python, str(Path(__file__).resolve()), *options], cwd=checkout,
            env={**os.environ, **one, "PYTHONPATH": str(checkout)},
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        )  # fmt: skip

    def seconds(self, name: str) -> float:
        """Processor time of a workload."""
        assert self.process.stdin is not None and self.process.stdout is not None
        self.process.stdin.write(name + "\n")
        self.process.stdin.flush()
        answer = self.process.stdout.readline()
        if not answer:
            raise SystemExit(f"{name}: the process has ended, see above")
        return float(answer)


def compared(new: Side, old: Side, name: str, pairs: int) -> str:
    """A line: medians, and the ratio with its interval."""
    from scipy import stats

    times = np.empty((pairs, 2))
    for k in range(pairs):
        for column in (0, 1) if k % 2 else (1, 0):
            times[k, column] = (new, old)[column].seconds(name)
    logs = np.log(times[:, 0] / times[:, 1])
    half = stats.t.ppf(0.975, pairs - 1) * stats.sem(logs)
    low, high = np.exp(logs.mean() - half), np.exp(logs.mean() + half)
    ours, theirs = 1e3 * np.median(times, axis=0)
    return (
        f"| {name} | {theirs:.1f} | {ours:.1f} | {np.exp(logs.mean()):.3f} | "
        f"{low:.3f} to {high:.3f} | {'slower' if low > 1.05 else ''} |"
    )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description="Time this checkout against another one.")
    parser.add_argument("python", nargs="?", help="the other checkout's Python")
    parser.add_argument("--checkout", type=Path, help="its folder; by default that of its .venv")
    parser.add_argument("--pairs", type=int, default=PAIRS)
    parser.add_argument("--only", default="", help="workloads whose name contains this")
    parser.add_argument("--file", type=Path, help="situations of a file instead of drawn ones")
    parser.add_argument("--serve", action="store_true", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    given.extend([] if arguments.file is None else [arguments.file.resolve()])
    if arguments.serve:
        serve()
        return
    if arguments.python is None:
        parser.error("the other checkout's Python is missing")
    if arguments.pairs < 3:
        parser.error(f"--pairs: must be at least 3 (got {arguments.pairs})")
    chosen = [name for name in WORKLOADS if arguments.only in name]
    if not chosen:
        parser.error(f"--only: {arguments.only!r} is in none of {', '.join(WORKLOADS)}")
    python = Path(arguments.python).absolute()
    if not python.is_file():
        parser.error(f"{arguments.python}: there is no such Python")
    other = (arguments.checkout or python.parents[2]).resolve()
    if not (other / "gcm_learn").is_dir():
        parser.error(f"--checkout: {other} has no gcm_learn")
    new, old = Side(sys.executable, ROOT), Side(str(python), other)
    print("| workload | old [ms] | new [ms] | new / old | 95 % | |\n|---|---|---|---|---|---|")
    for name in chosen:
        print(compared(new, old, name, arguments.pairs), flush=True)


if __name__ == "__main__":
    main()
