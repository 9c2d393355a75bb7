"""Which chart, which order and how many postures should plans in space use? Writes charts.md.

python -m experiments 13_space/charts              5 situations of each family
python -m experiments 13_space/charts --minutes 5  what can be done in five minutes

The situations are the first that run.py asks.
Finished parts are kept in out/ and not repeated; Ctrl-C is safe.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from run import THOUGHT, drawn, families, timed

from gcm_learn.planners import get_planner
from gcm_learn.planners.joints.marching import posture_marching
from gcm_learn.storage import write_whole

HERE = Path(__file__).resolve().parent
COUNT = 5  # situations of each family
POSTURES = (1, 4, 8)
STRAIGHT, TREES = "straight moves with waits", "joints and time, trees"
LONGER = f"{TREES}, {1e3 * THOUGHT:.0f} ms"

Rows = list[dict[str, Any]]


def methods() -> dict[str, Any]:
    """What is compared."""
    out: dict[str, Any] = {STRAIGHT: get_planner("straight-wait")}
    for wait in (False, True):
        for k in POSTURES:
            name = f"hand 40^3, K = {k}, {'sheets' if wait else 'first arrivals'}"
            out[name] = posture_marching((k,), wait=wait)
    out[TREES] = out[LONGER] = get_planner("search")
    return out


def table(rows: Rows) -> str:
    """Catches, processor time, and how late catches are."""
    left = [row for row in rows if row[STRAIGHT][0] is None]
    lines = [
        f"{len(rows)} situations; straight moves leave {len(left)} of them.",
        "",
        "| chart and order | caught | of what straight moves leave | ms where it catches, median /"
        " 90 % | ms where it does not | later than the earliest of all, median / 90 % [ms] |"
        " broken |",
        "|---|---|---|---|---|---|---|",
    ]
    for name in methods():
        caught = [row for row in rows if row[name][0] is not None]
        missed = [row for row in rows if row[name][0] is None]
        late = [1e3 * (row[name][0] - _earliest(row)) for row in caught]
        times = [_spread([row[name][1] for row in some]) for some in (caught, missed)]
        hard = sum(row[name][0] is not None for row in left)
        broken = sum(bool(row[name][2]) for row in rows)
        cells = [f"{len(caught)}", f"{hard}", *times, _spread(late), f"{broken}"]
        lines.append(f"| {name} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def _earliest(row: dict[str, Any]) -> float:
    return min(row[name][0] for name in methods() if row[name][0] is not None)


def _spread(values: list[float]) -> str:
    return f"{np.median(values):.1f} / {np.quantile(values, 0.9):.1f}" if values else "-"


def main() -> None:
    """Run what is missing and write charts.md."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=COUNT, help="situations of each family")
    parser.add_argument("--minutes", type=float, default=np.inf, help="no new one after that")
    arguments = parser.parse_args()
    file, asked = HERE / "out" / "charts.jsonl", methods()
    file.parent.mkdir(exist_ok=True)
    rows = [json.loads(line) for line in file.read_text().splitlines()] if file.exists() else []
    done = {(row["family"], row["index"]) for row in rows}
    for planner in asked.values():  # kernels are loaded, so that nobody is charged for that
        planner.plan(drawn(families()[0], 10_000))
    started = process_time()
    with file.open("a") as stream:
        for index, family in ((k, f) for k in range(arguments.count) for f in families()):
            if (family, index) in done or process_time() - started > 60.0 * arguments.minutes:
                continue
            situation = drawn(family, index)
            answers = {
                name: timed(situation, planner, **({"deadline": THOUGHT} if name == LONGER else {}))
                for name, planner in asked.items()
            }
            rows.append({"family": family, "index": index, **answers})
            stream.write(json.dumps(rows[-1]) + "\n")
            stream.flush()
    write_whole(HERE / "charts.md", table(rows))


if __name__ == "__main__":
    main()
