"""Compare planners, memories and policies where thinking costs time and percepts are inexact (H1).

python -m experiments 11_comparison charged OUT    writes table.md and charged.png beside this file
python -m experiments 11_comparison noise OUT      writes inexact.md

OUT holds the results and a page. All methods answer the same frozen situations.
"""

from __future__ import annotations

import argparse
import json
import resource
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from report import write_charged, write_inexact

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


def part(out: Path, name: str, do: Callable[[], Results]) -> tuple[Results, dict[str, float]]:
    """Return the results of a part, made unless they are there, and its cost in minutes."""
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
    cost: dict[str, float] = json.loads((folder / "cost.json").read_text())
    return Results.load(file), cost


def main() -> None:
    """Draw, compare, report."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("part", choices=("charged", "noise"))
    parser.add_argument("out", type=Path)
    parser.add_argument("--count", type=int, default=300, help="of W; under noise half W, half Q")
    parser.add_argument("--workers", type=int)
    given = parser.parse_args()
    do = charge if given.part == "charged" else perceive
    do(given.out, given.count, given.workers)


def charge(out: Path, count: int, workers: int | None) -> None:
    """Ask what is caught if thinking is charged."""
    drawn = draw_suite("W", count, workers=workers)
    charged, cost = part(
        out, "charged", lambda: compare(METHODS, drawn, charge=count, workers=workers)
    )
    page = write_report(charged, drawn, out / "charged", "layered")
    figure = charged_figure(charged.where(np.isin(charged["entrant"], DRAWN)))
    if figure is not None:
        figure.savefig(HERE / "charged.png", dpi=110)
    write_charged(HERE / "table.md", charged, f"W ({count}, {hash_of(drawn)})", cost)
    print(f"Open {page.resolve().as_uri()} in a browser.")


def perceive(out: Path, count: int, workers: int | None) -> None:
    """Ask what is caught if percepts are inexact."""
    drawn = {name: draw_suite(name, count // 2, workers=workers) for name in "WQ"}
    some = [*drawn["W"], *drawn["Q"]]
    noise, cost = part(
        out, "noise", lambda: compare_under_noise(NOISY, some, DEVIATIONS, workers=workers)
    )
    about = ", ".join(f"{name} ({len(few)}, {hash_of(few)})" for name, few in drawn.items())
    write_inexact(HERE / "inexact.md", noise, about, cost)


if __name__ == "__main__":
    main()
