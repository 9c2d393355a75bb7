"""What recall catches in space, beside its controls and where it was not trained; writes space.md.

python -m experiments 05_recall/space [--spec space-accelerated] [--count 3000]

Situations are drawn as a specification of data/specs says (space.toml, if no other is named, after
which the table is named, too), with a seed of their own. What is asked is kept in out/ and not
asked again. Every catch is judged by the tests' referee.
"""

from __future__ import annotations

import argparse
import json
import time
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from gcm_learn.dataset import make_item, read_spec
from gcm_learn.evaluation import wilson
from gcm_learn.planners import get_planner, plan_to_json
from gcm_learn.situation import situation_to_json
from tests.referee_of_spatial_arms import judge

HERE = Path(__file__).resolve().parent
REPOSITORY = HERE.parents[1]
SEEDS = {"space": 3437426931, "space-accelerated": 885590443}
"""Heads of the hashes of the commits that froze code, memory and encoder, by specification."""
AUDIT = 0.2  # share that the yardstick labels, where accelerations have no limits
PLANNERS = ("recall", "recall-1", "recall-raw", "recall-random", "hybrid")
GROUPS = {
    "as trained": ("train", "validation", "test"),
    "families": ("test-family",),
    "arms": ("test-arms",),
    "faster": ("test-fast",),
    "crowded": ("test-crowded",),
}
"""Splits of the specification: whatever this seed draws, no memory has seen."""


def answered(spec: Any, k: int) -> dict[str, Any]:
    """What all say of the situation of item k, and what it is."""
    record = make_item(spec, k)
    if record.situation is None:
        return {"item": k, "split": None}
    row: dict[str, Any] = {"item": k, "split": record.split, "stratum": record.stratum}
    row["yardstick"] = None if record.oracle is None else record.oracle.stratum
    if record.stratum == "U" and row["yardstick"] in (None, "U"):
        return row
    told = situation_to_json(record.situation)
    for name in (*PLANNERS, "layered"):  # of the record's plan the clock alone tells how long
        began = time.process_time()
        plan = get_planner(name).plan(record.situation)
        ms = 1e3 * (time.process_time() - began)
        found = judge(told, plan_to_json(plan, record.situation)).complaints if plan.caught else []
        row[name] = {"caught": plan.caught, "ms": round(ms, 3), "complaints": found}
    row["layered"]["caught"] = record.stratum != "U"
    return row


def share(rows: list[dict[str, Any]], name: str) -> str:
    """A share with its 95 % interval, in percent."""
    if not rows:
        return ""
    found = wilson(sum(row[name]["caught"] for row in rows), len(rows))
    return "{:.0f} ({:.0f}–{:.0f})".format(*(100 * one for one in found))


def table(rows: list[dict[str, Any]]) -> str:
    """Catches by stratum where all is as in training, then by what is not."""
    some = {group: [r for r in rows if r["split"] in splits] for group, splits in GROUPS.items()}
    columns = {s: [r for r in some["as trained"] if r["stratum"] == s] for s in "LWQ"}
    hard = {g: [r for r in kept if r["stratum"] in "WQ"] for g, kept in some.items()}
    columns |= {f"W and Q, {group}": kept for group, kept in hard.items()}
    columns |= {
        f"yardstick's {s}": [r for r in some["as trained"] if r["yardstick"] == s] for s in "WQ"
    }
    columns = {name: kept for name, kept in columns.items() if kept}
    head = ["asked", *columns, "complaints", "ms", "90 %"]
    lines = ["| " + " | ".join(head) + " |", "|---" * len(head) + "|"]
    counts = [str(len(kept)) for kept in columns.values()]
    lines.append("| situations | " + " | ".join(counts) + " | | | |")
    for name in (*PLANNERS, "layered"):
        told = [row[name] for row in rows]
        wrong = sum(bool(one["complaints"]) for one in told)
        judged = "" if name == "layered" else f"{wrong} of {sum(one['caught'] for one in told)}"
        ms = [f"{np.quantile([one['ms'] for one in told], q):.1f}" for q in (0.5, 0.9)]
        cells = [share(kept, name) for kept in columns.values()]
        lines.append("| `" + "` | ".join([name, " | ".join([*cells, judged, *ms])]) + " |")
    return "\n".join(lines)


def main() -> None:
    """Ask what was not asked yet; write space.md."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--spec", default="space", choices=SEEDS, help="of data/specs")
    parser.add_argument("--count", type=int, default=2000, help="situations")
    parser.add_argument("--minutes", type=float, default=np.inf, help="no new one after that")
    given, began = parser.parse_args(), time.monotonic()
    seed = SEEDS[given.spec]
    spec = replace(
        read_spec(REPOSITORY / "data" / "specs" / f"{given.spec}.toml"),
        seed=seed,
        count=given.count,
        audit=AUDIT if given.spec == "space" else 0.0,
    )
    kept = HERE / "out" / f"{given.spec}-{seed}.jsonl"
    kept.parent.mkdir(exist_ok=True)
    rows = (
        [json.loads(line) for line in kept.read_text("utf-8").splitlines()] if kept.exists() else []
    )
    with kept.open("a", encoding="utf-8") as file:
        for k in range(len(rows), given.count):
            if time.monotonic() - began > 60.0 * given.minutes:
                break
            rows.append(answered(spec, k))
            file.write(json.dumps(rows[-1]) + "\n")
            file.flush()
    strata = Counter(row["stratum"] for row in rows if row["split"] is not None)
    caught = [row for row in rows if "layered" in row]
    note = (
        f"{len(rows)} situations of seed {seed}, {strata['U']} of which `layered` does not catch; "
        "catches [%] of the others with 95 % intervals (Wilson), beside them of what the "
        "yardstick labels W and Q, where it was asked, what the referee complains of, of so "
        "many catches, and processor time [ms], median and 90 %."
    )
    (HERE / f"{given.spec}.md").write_text(f"{table(caught)}\n\n{note}\n", "utf-8")


if __name__ == "__main__":
    main()
