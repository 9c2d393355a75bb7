"""Which chart, which order and how many postures should plans in space use? Writes charts.md.

python -m experiments 13_space/charts              5 situations of each family
python -m experiments 13_space/charts --minutes 5  what can be done in five minutes

The situations are the first that run.py asks. Its table has more sizes of the joints' lattice.
Finished parts are kept in out/ and not repeated; Ctrl-C is safe.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
from run import drawn, families, timed

from gcm_learn.planners.joints.layered import COARSE, FINE, LayeredInSpace
from gcm_learn.planners.joints.marching import posture_marching
from gcm_learn.storage import write_whole

HERE = Path(__file__).resolve().parent
COUNT = 5  # situations of each family
POSTURES = (1, 4, 8)
SIZES = (16, 24)  # of the joints' lattice for the earliest catch, beside the default of 10^4 nodes
STRAIGHT = "straight moves only"

Rows = list[dict[str, Any]]


def joints(size: int = 10, weight: float = 1.0, earliest: bool = False) -> LayeredInSpace:
    """Search over the joints; a weight of 0 is the order of the catch's time alone."""
    coarse, fine = (e._replace(nodes=size**4, weight=weight) for e in (COARSE, FINE))
    return LayeredInSpace(coarse=coarse, fine=fine, earliest=earliest)


def methods() -> dict[str, Any]:
    """What is compared."""
    none = (e._replace(tries=()) for e in (COARSE, FINE))
    out: dict[str, Any] = {STRAIGHT: LayeredInSpace("layered", 32, 12, *none)}
    for wait in (False, True):
        for k in POSTURES:
            name = f"hand 40^3, K = {k}, {'sheets' if wait else 'first arrivals'}"
            out[name] = posture_marching((k,), wait=wait)
    out["joints 10^4, motion left breaks ties"] = joints()
    out["joints 10^4, time of the catch alone"] = joints(weight=0.0)
    out["joints 10^4, earliest under its bound"] = joints(earliest=True)
    for size in SIZES:
        out[f"joints {size}^4, earliest under its bound"] = joints(size, earliest=True)
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
            answers = {name: timed(situation, planner) for name, planner in asked.items()}
            rows.append({"family": family, "index": index, **answers})
            stream.write(json.dumps(rows[-1]) + "\n")
            stream.flush()
    write_whole(HERE / "charts.md", table(rows))


if __name__ == "__main__":
    main()
