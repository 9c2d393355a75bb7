"""How fast datasets are made and read: ``python -m experiments benchmarks/dataset [RECORDS]``.

Rates leave out the start of the processes and the loading of compiled code, a few seconds each
time. Next to them stands the processor time of a record, made and written in this process. It means
the same on a busy machine.
The natural mix is the family random-planar, drawn as it comes.
"""

from __future__ import annotations

import argparse
import resource
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from gcm_learn import dataset
from gcm_learn.dataset import DatasetSpec, FamilyShare, Folder, make_shard, warm_up

MAPS = {"wave": ("gcm", "layered"), "marching": ("marching", "layered")}
READS = 20_000
ALONE = 10  # shards that this process makes
RUNGS = 1  # maps that a planner tries, as for the training set


def natural(engine: str, count: int, rungs: int = RUNGS) -> DatasetSpec:
    """Situations drawn evenly, with the map and plan of an engine and the layered plan."""
    return DatasetSpec(
        name=f"natural-{engine}",
        seed=7,
        count=count,
        families=(FamilyShare("random-planar"),),
        planners=MAPS[engine],
        map=engine,  # type: ignore[arg-type]
        rungs=rungs,
        shard_size=100,
    )


def cost(spec: DatasetSpec, folder: Path) -> float:
    """Processor time of a record, made and written in this process [s].

    Each shard is made twice and the cheaper time taken: others on the machine take turns in its
    caches.
    """
    Folder(folder).make()
    warm_up(spec)
    total = 0.0
    for shard in range(ALONE):
        times = []
        for _ in range(2):
            start = time.thread_time()
            make_shard(spec, shard, str(folder))
            times.append(time.thread_time() - start)
        total += min(times)
    return total / (ALONE * spec.shard_size)


def rate(spec: DatasetSpec, folder: Path, workers: int) -> float:
    """Records a second, once every process has made its first shard."""
    moments: list[tuple[float, int]] = []
    dataset.generate(
        spec, folder, workers, progress=lambda n: moments.append((time.perf_counter(), n))
    )
    start, later = moments[workers][0], moments[workers + 1 :]
    return sum(n for _, n in later) / (later[-1][0] - start)


def making(folder: Path, count: int) -> None:
    """Print what a record costs, and the rates of one and of two processes."""
    for engine in MAPS:
        for rungs in (RUNGS, 2):
            spent = cost(natural(engine, count, rungs), folder / f"{engine}-alone-{rungs}")
            print(
                f"{engine:9} {1e3 * spent:.2f} ms of one core a record, {rungs} rungs: "
                f"{2.0 / spent:.0f}/s on two"
            )
        rates = {w: rate(natural(engine, count), folder / f"{engine}-{w}", w) for w in (1, 2)}
        manifest = dataset.open(folder / f"{engine}-2").manifest
        shares = ", ".join(f"{share:.0%} {name}" for name, share in manifest["shares"].items())
        speeds = f"{rates[1]:6.0f}/s by 1 process, {rates[2]:6.0f}/s by 2"
        ratio, size = rates[2] / rates[1], manifest["bytes_per_record"]
        print(f"{engine:9} {speeds} ({ratio:.2f} x), {size:.0f} bytes each; {shares}")


def reading(folder: Path) -> None:
    """Print the rates of the cache and of the stream."""
    records = dataset.open(folder / "wave-2")
    cache = records.cache()
    places = np.random.default_rng(0).integers(0, len(cache), READS).tolist()
    for name, take in (("examples", lambda e: e.arrival.sum()), ("pictures", lambda e: e.image())):
        start, spent = time.perf_counter(), time.thread_time()
        for k in places:
            take(cache[k])
        _tell(f"cache     {name} at random", READS, start, spent)
        start, spent, seen = time.perf_counter(), time.thread_time(), 0
        for epoch in range(-(-READS // len(records))):
            for example in records.stream(0, epoch):
                take(example)
                seen += 1
        _tell(f"stream    {name}, shuffled", seen, start, spent)


def _tell(what: str, count: int, start: float, spent: float) -> None:
    wall, own = count / (time.perf_counter() - start), count / (time.thread_time() - spent)
    print(f"{what}: {wall:.0f}/s, {own:.0f}/s of processor time")


def memory(folder: Path, count: int) -> None:
    """Print the largest memory of the parent while many cheap records are made."""
    cheap = natural("marching", count)
    spec = replace(cheap, planners=("straight",), map="none", strata={"L": 1.0}, shard_size=250)
    curve: list[tuple[int, float]] = []
    done = 0

    def note(new: int) -> None:
        nonlocal done
        done += new
        if done >= (len(curve) + 1) * count // 10:
            curve.append((done, resident()))

    dataset.generate(spec, folder / "memory", 2, progress=note)
    print("memory    " + ", ".join(f"{n}: {size:.0f} MB" for n, size in curve))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(f"          {resident():.0f} MB after the manifest, {peak:.0f} MB at most")


def resident() -> float:
    """Resident memory of this process [MB]."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize() / 1e6


def main() -> None:
    """Measure all."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("records", type=int, nargs="?", default=4000)
    count = parser.parse_args().records
    with tempfile.TemporaryDirectory() as name:
        memory(Path(name), 25 * count)
        making(Path(name), count)
        reading(Path(name))


if __name__ == "__main__":
    main()
