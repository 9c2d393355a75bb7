"""Compare all ways to catch on the same frozen situations (H1 and the whole comparison).

python -m experiments 11_comparison OUT [--count 1000]   goes on where it was stopped

OUT holds the results and a page for each part; table.md and the figures are written beside this
file.
"""

from __future__ import annotations

import argparse
import json
import resource
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from report import write_tables

from gcm_learn.evaluation import Entry, Results, compare, compare_under_noise, draw_suite, hash_of
from gcm_learn.plots import charged_figure, rates_figure, write_report

HERE = Path(__file__).parent
POLICIES = (
    "straight", "straight-wait", "potential", "gcm", "marching", "layered", "splines-random",
    "recall-random", "recall-raw", "recall-1", "recall", "hybrid", "clone", "ppo-clone",
    "ppo-clone@20", "sac",
)  # fmt: skip
DRAWN = ("gcm", "layered", "recall-raw", "recall", "hybrid", "ppo-clone")  # in the charged figure
NOISY = ("hybrid", "layered")
DEVIATIONS = (0.005, 0.01, 0.02)  # [forearms]


def spent() -> float:
    """Processor time of this process and those that it started and that have ended [s]."""
    return sum(
        usage.ru_utime + usage.ru_stime
        for usage in map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    )


def part(out: Path, name: str, do: Callable[[], Results]) -> Results:
    """The results of a part, made unless they are there; what it took is noted."""
    folder = out / name
    folder.mkdir(parents=True, exist_ok=True)
    file = folder / "results.parquet"
    if not file.exists():
        since, cpu = time.perf_counter(), spent()
        made = do()
        took = {"minutes": (time.perf_counter() - since) / 60, "cpu": (spent() - cpu) / 60}
        (folder / "cost.json").write_text(json.dumps(took) + "\n")
        made.save(file)
        print(f"{name}: {took['minutes']:.1f} min, {took['cpu']:.1f} min of a core", flush=True)
    return Results.load(file)


def main() -> None:
    """Draw, compare, report."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    parser.add_argument("--count", type=int, default=1000, help="situations of a stratum")
    parser.add_argument("--rare", type=int, help="of Q and U, if fewer")
    parser.add_argument("--natural", type=int, default=300, help="situations of the natural mix")
    parser.add_argument("--charge", type=int, default=100, help="of L, Q and U; of W it is all")
    parser.add_argument("--noisy", type=int, default=100, help="of W and of Q, under noise")
    parser.add_argument("--workers", type=int)
    given = parser.parse_args()
    workers, hashes = given.workers, dict[str, str]()
    counts = dict.fromkeys("LW", given.count) | dict.fromkeys("QU", given.rare or given.count)

    def suite(name: str, count: int) -> list[Entry]:
        entries = draw_suite(name, count, workers=workers)
        hashes[name] = f"{len(entries)}, {hash_of(entries)}"
        return entries

    drawn = {name: suite(name, counts[name]) for name in counts}
    detours = part(
        given.out, "W",
        lambda: compare(POLICIES, drawn["W"], charge=given.count, workers=workers),
    )  # fmt: skip
    others = [entry for name in "LQU" for entry in drawn[name]]
    rest = part(
        given.out, "L, Q and U",
        lambda: compare(POLICIES, others, charge=given.charge, workers=workers),
    )  # fmt: skip
    few = [entry for name in "WQ" for entry in drawn[name][: given.noisy]]
    noise = part(
        given.out, "noise", lambda: compare_under_noise(NOISY, few, DEVIATIONS, workers=workers)
    )
    natural: Results | None = None
    if given.natural:
        mix = suite("natural", given.natural)
        natural = part(
            given.out, "natural", lambda: compare(POLICIES, mix, charge=0, workers=workers)
        )
        write_report(natural, mix, given.out / "natural")
    whole = Results.joined(detours, rest)
    (given.out / "all").mkdir(exist_ok=True)
    page = write_report(whole, [*drawn["W"], *others], given.out / "all", "layered", noise)
    rates_figure(whole).savefig(HERE / "figure.png", dpi=110)
    figure = charged_figure(detours.where(np.isin(detours["entrant"], DRAWN)))
    if figure is not None:
        figure.savefig(HERE / "charged.png", dpi=110)
    costs = {
        path.parent.name: json.loads(path.read_text())
        for path in sorted(given.out.glob("*/cost.json"))
    }
    write_tables(HERE / "table.md", whole, detours, noise, natural, hashes, costs)
    print((HERE / "table.md").read_text("utf-8"))
    print(f"Open {page.resolve().as_uri()} in a browser.")


if __name__ == "__main__":
    main()
