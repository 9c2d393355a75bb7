"""H11 decided: what replanning wins back, with a memory and without; writes h11.md.

python -m experiments 14_body/h11 --seed SEED

SEED is int(first eight hexadecimal digits of the hash of the commit that froze this, 16).  All ways
play a situation before the next one is drawn.  What is done is kept in out/ and not done again.
H11 holds for a planner if replanning (`broken`) loses at most MOST points of what the same planner
catches that plans once with exact eyes, and planning once loses more than that.
"""

from __future__ import annotations

import argparse
import json
from functools import cache
from pathlib import Path
from time import monotonic, process_time
from typing import Any, NamedTuple

import numpy as np
from closed_loop import CHOSEN, DROPOUTS, SEED, situation_of

from gcm_learn.evaluation import difference, holm, mcnemar, wilson
from gcm_learn.execution import (
    OUTCOMES,
    Loop,
    Perception,
    PhysicalPlant,
    Planning,
    body_for,
    run_closed_loop,
)
from gcm_learn.families import family_names
from gcm_learn.planners import Planner, get_planner
from gcm_learn.recall import HybridPlanner
from gcm_learn.storage import write_whole

HERE = Path(__file__).resolve().parent
COUNT = 156  # situations, of the twelve families in turn
MOST = 10.0  # points that may be lost
FOLDER = HERE / "out"


class Way(NamedTuple):
    """Who acts, and what is seen."""

    planner: str
    habit: str
    noise: float


WAYS = (
    Way("layered", "once", 0.0),
    Way("layered", "once", CHOSEN),
    Way("layered", "broken", CHOSEN),
    Way("hybrid", "once", 0.0),
    Way("hybrid", "once", CHOSEN),
    Way("hybrid", "broken", CHOSEN),
    Way("hybrid-random", "broken", CHOSEN),
)
PAIRS = (  # differences of catches that are shown: the first less the second
    *((WAYS[0], WAYS[k]) for k in (1, 2)),
    *((WAYS[3], WAYS[k]) for k in (4, 5)),
    *((WAYS[5], WAYS[k]) for k in (2, 6)),
)


@cache
def planner_of(name: str) -> Planner:
    """A planner by name; `hybrid-random` asks memories at random."""
    if name == "hybrid-random":
        recall: Any = get_planner("recall-random")
        return HybridPlanner(recall, name=name)
    return get_planner("search" if name == "layered" else name)  # its name in the outcomes


def play(way: Way, seed: int, index: int) -> dict[str, Any]:
    """Play one episode of an arm with mass."""
    situation = situation_of(index, seed)
    loop = Loop(Perception(place=way.noise, dropouts=DROPOUTS))
    plant: Any = PhysicalPlant(situation, body_for(situation.arm))
    mind: Any = Planning(planner_of(way.planner), way.habit)  # type: ignore[arg-type]
    since = process_time()
    course = run_closed_loop(mind, plant, situation, loop, seed, index)
    return {
        "seed": seed,
        "index": index,
        "way": way,
        "outcome": OUTCOMES[course.outcome],
        "time": course.time,
        "took": [round(thought.took, 4) for thought in course.thoughts],
        "seconds": round(process_time() - since, 3),
    }


def write_table(rows: dict[tuple[int, Way], dict[str, Any]], seed: int) -> None:
    """Catches of all ways on the situations that all have played, and differences in pairs."""
    played = [k for k in range(COUNT) if all((k, way) in rows for way in WAYS)]
    caught = {w: np.array([rows[k, w]["outcome"] == "caught" for k in played]) for w in WAYS}
    lines = [
        f"{len(played)} situations of seed {seed}; 95 % intervals; p by McNemar's test after Holm.",
        "",
        "| planner | plans | noise [forearms] | caught % | touched % | thoughts | ms | 90 % |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for way in WAYS:
        mine = [rows[k, way] for k in played]
        touched = sum(row["outcome"] == "touched" for row in mine)
        took = 1e3 * np.array([t for row in mine for t in row["took"]] or [np.nan])
        shares = [wilson(int(n), len(played)) for n in (caught[way].sum(), touched)]
        cells = [*way, *(told(share) for share in shares)]
        cells += [f"{took.size / len(played):.1f}", f"{np.median(took):.0f}"]
        lines.append("| " + " | ".join(map(str, [*cells, f"{np.quantile(took, 0.9):.0f}"])) + " |")
    lines += ["", "| first | second | points between | p |", "|---|---|---|---|"]
    groups = np.array(played) % len(family_names("spatial"))
    found = holm([mcnemar(caught[a], caught[b])[2] for a, b in PAIRS])
    for (a, b), p in zip(PAIRS, found, strict=True):
        gap = difference(caught[a], caught[b], groups)
        names = (" ".join(map(str, way)) for way in (a, b))
        lines.append("| " + " | ".join([*names, told(gap), f"{p:.2g}"]) + " |")
    write_whole(HERE / "h11.md", ("\n".join(lines) + "\n").encode())


def told(interval: Any) -> str:
    """A share with its interval, in percent."""
    return f"{100 * interval.value:.1f} ({100 * interval.low:.1f} to {100 * interval.high:.1f})"


def main() -> None:
    """Play what is missing, then write the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--seed", type=int, required=True)
    parser.add_argument("--count", type=int, default=COUNT)
    parser.add_argument("--minutes", type=float, default=1e9)
    given, since = parser.parse_args(), monotonic()
    FOLDER.mkdir(exist_ok=True)
    path, rows = FOLDER / f"h11-{given.seed}.jsonl", {}
    for text in path.read_text().splitlines() if path.exists() else []:
        row = json.loads(text)
        rows[row["index"], Way(*row["way"])] = row
    for way in WAYS:  # compiled before anything is charged
        play(way, SEED, 0)
    with path.open("a") as stream:
        for index in range(given.count):
            if monotonic() - since > 60.0 * given.minutes:
                break
            for way in WAYS:
                if (index, way) not in rows:
                    rows[index, way] = play(way, given.seed, index)
                    stream.write(json.dumps(rows[index, way]) + "\n")
                    stream.flush()
    write_table(rows, given.seed)


if __name__ == "__main__":
    main()
