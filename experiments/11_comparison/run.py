"""Compare planners, memories and policies where thinking costs time and percepts are inexact (H1).

python -m experiments 11_comparison OUT [--count 1000]   goes on from where it was stopped

OUT holds the results and a page; table.md and charged.png are written beside this file. All methods
answer the same frozen situations.
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

from gcm_learn.evaluation import Results, compare, compare_under_noise, draw_suite, hash_of
from gcm_learn.plots import charged_figure, write_report

HERE = Path(__file__).parent
METHODS = (
    "straight", "gcm", "marching", "layered", "splines-random", "recall-random", "recall-raw",
    "recall", "hybrid", "ppo-clone", "ppo-clone@20",
)  # fmt: skip
DRAWN = ("gcm", "layered", "recall-raw", "recall", "hybrid", "ppo-clone")  # in the figure
NOISY = ("hybrid", "layered")
DEVIATIONS = (0.005, 0.01, 0.02)  # [forearms]


def spent() -> float:
    """Processor time of this process and those that it started and that have ended [s]."""
    return sum(
        usage.ru_utime + usage.ru_stime
        for usage in map(resource.getrusage, (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    )


def part(out: Path, name: str, do: Callable[[], Results]) -> Results:
    """Return the results of a part, made unless they are there; note its cost."""
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
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("out", type=Path)
    parser.add_argument("--count", type=int, default=1000, help="situations of W")
    parser.add_argument("--noisy", type=int, default=100, help="of W and of Q, under noise")
    parser.add_argument("--workers", type=int)
    given = parser.parse_args()
    workers = given.workers
    counts = {"W": given.count, "Q": given.noisy}
    drawn = {name: draw_suite(name, count, workers=workers) for name, count in counts.items()}
    charged = part(
        given.out, "charged",
        lambda: compare(METHODS, drawn["W"], charge=given.count, workers=workers),
    )  # fmt: skip
    few = [*drawn["W"][: given.noisy], *drawn["Q"]]
    noise = part(
        given.out, "noise", lambda: compare_under_noise(NOISY, few, DEVIATIONS, workers=workers)
    )
    page = write_report(charged, drawn["W"], given.out / "charged", "layered", noise)
    figure = charged_figure(charged.where(np.isin(charged["entrant"], DRAWN)))
    if figure is not None:
        figure.savefig(HERE / "charged.png", dpi=110)
    hashes = {name: f"{len(entries)}, {hash_of(entries)}" for name, entries in drawn.items()}
    costs = {
        path.parent.name: json.loads(path.read_text())
        for path in sorted(given.out.glob("*/cost.json"))
    }
    write_tables(HERE / "table.md", charged, noise, hashes, costs)
    print((HERE / "table.md").read_text("utf-8"))
    print(f"Open {page.resolve().as_uri()} in a browser.")


if __name__ == "__main__":
    main()
