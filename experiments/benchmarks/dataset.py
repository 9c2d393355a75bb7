"""How fast datasets are made and read: ``python experiments/benchmarks/dataset.py [RECORDS]``.

Rates are those of a run under way: the start of the processes and the loading of compiled code, a
few seconds each time, are left out. The natural mix is the family random-planar, drawn as it comes.
"""

from __future__ import annotations

import resource
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from gcm_learn import dataset
from gcm_learn.dataset import DatasetSpec, FamilyShare

MAPS = {"wave": ("gcm", "layered"), "marching": ("marching", "layered")}
READS = 20_000


def natural(engine: str, count: int) -> DatasetSpec:
    """Situations drawn evenly, with the map and plan of an engine and the layered plan."""
    return DatasetSpec(
        name=f"natural-{engine}",
        seed=7,
        count=count,
        families=(FamilyShare("random-planar"),),
        planners=MAPS[engine],
        map=engine,  # type: ignore[arg-type]
        rungs=2,
        shard_size=100,
    )


def rate(spec: DatasetSpec, folder: Path, workers: int) -> float:
    """Records a second, once every process has made its first shard."""
    moments: list[tuple[float, int]] = []
    dataset.generate(
        spec, folder, workers, progress=lambda n: moments.append((time.perf_counter(), n))
    )
    start, later = moments[workers][0], moments[workers + 1 :]
    return sum(n for _, n in later) / (later[-1][0] - start)


def making(folder: Path, count: int) -> None:
    """Print the rates of one and of two processes."""
    for engine in MAPS:
        rates = {w: rate(natural(engine, count), folder / f"{engine}-{w}", w) for w in (1, 2)}
        manifest = dataset.open(folder / f"{engine}-2").manifest
        shares = ", ".join(f"{share:.0%} {name}" for name, share in manifest["shares"].items())
        print(
            f"{engine:9} {rates[1]:6.0f}/s by 1 process, {rates[2]:6.0f}/s by 2 "
            f"({rates[2] / rates[1]:.2f} x), {manifest['bytes_per_record']:.0f} bytes each; "
            f"{shares}"
        )


def reading(folder: Path) -> None:
    """Print the rates of the cache and of the stream, pictures included."""
    records = dataset.open(folder / "wave-2")
    cache = records.cache()
    places = np.random.default_rng(0).integers(0, len(cache), READS).tolist()
    start = time.perf_counter()
    for k in places:
        cache[k].image()
    print(f"cache     {READS / (time.perf_counter() - start):6.0f} pictures/s at random")
    start, seen = time.perf_counter(), 0
    for epoch in range(-(-READS // len(records))):
        for example in records.stream(0, epoch):
            example.image()
            seen += 1
    print(f"stream    {seen / (time.perf_counter() - start):6.0f} pictures/s, shuffled")


def memory(folder: Path, count: int) -> None:
    """Print the largest memory of the parent while many cheap records are made."""
    spec = replace(
        natural("marching", count),
        planners=("straight",),
        map="none",
        n=16,
        rungs=1,
        shard_size=250,
    )
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


def main(count: int) -> None:
    """Measure all."""
    with tempfile.TemporaryDirectory() as name:
        memory(Path(name), 25 * count)
        making(Path(name), count)
        reading(Path(name))


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 4000)
