"""Grow covers of the belt families, and check draws from their proven cells.

python -m experiments 20_cover grow --free 2,3 --minutes 60   covers, kept in out/, and their curves
python -m experiments 20_cover check --draws 1000000          draws verified, three free parameters
python -m experiments 20_cover corners                        all corners of proven cells verified
python -m experiments 20_cover judge --draws 20000            draws judged by the referee
python -m experiments 20_cover time --draws 20000             processor time of answers
python -m experiments 20_cover report                         table.md, cells.png, curve.png

`--families belt` does one of the families only. Results are added to results.json.
"""

from __future__ import annotations

import argparse
import json
from itertools import product
from pathlib import Path
from time import perf_counter, thread_time
from typing import Any

import numpy as np

from gcm_learn.cover import (
    FAMILIES,
    Budget,
    Cover,
    broken_of,
    draws,
    grow,
    is_cover,
    load_cover,
    parametric_family,
    with_cover,
)
from gcm_learn.evaluation import complaints
from gcm_learn.processes import crew_of
from gcm_learn.seeding import rng
from gcm_learn.storage import write_whole

HERE = Path(__file__).resolve().parent
OUT = HERE / "out"
RESULTS = HERE / "results.json"
SHARE = 0.95  # of the hypothesis
SEEDS = {"check": 1, "judge": 2, "time": 3}
CHECKED = 3  # free parameters of the covers that are checked: those of the hypothesis
ROWS = 200  # of a curve that are kept
PART = 20_000  # draws that are noted at once


def results() -> dict[str, Any]:
    """Return what has been measured so far."""
    return json.loads(RESULTS.read_text("utf-8")) if RESULTS.exists() else {}


def note(part: str, name: str, row: dict[str, Any]) -> None:
    """Add a row to the results."""
    found = results()
    found.setdefault(part, {})[name] = row
    write_whole(RESULTS, json.dumps(found, indent=1) + "\n")
    print(part, name, {key: value for key, value in row.items() if key != "curve"}, flush=True)


def folder_of(family: str, free: int) -> Path:
    """Return the folder of a cover."""
    return OUT / f"{family}-{free}"


def grown(family: str, free: int, minutes: float, workers: int) -> None:
    """Grow a cover until its share or the time is reached."""
    folder = folder_of(family, free)
    fresh = Cover(parametric_family(family).free(free))
    cover = load_cover(folder) if is_cover(folder) else fresh
    with crew_of(workers) as crew:
        grow(cover, Budget(SHARE, minutes), crew, keep=lambda done: done.save(folder))
    row = {
        "share": cover.share,
        "catches": len(cover.used),
        "cells": cover.examined,
        "seconds": round(cover.seconds, 1),
        "missing": cover.missing(),
        "curve": thinned(cover.curve),
    }
    note("growth", f"{family}-{free}", row)


def thinned(curve: list[Any]) -> list[Any]:
    """Return some rows of a curve, its last one among them."""
    return curve[:: max(len(curve) // ROWS, 1)] + curve[-1:]


def checked(family: str, count: int) -> None:
    """Verify draws from proven cells, in parts that are noted one by one; go on after the last."""
    cover = load_cover(folder_of(family, CHECKED))
    row = results().get("verified", {}).get(family, {"draws": 0, "broken": 0})
    while row["draws"] < count:
        part = min(PART, count - row["draws"])
        broken, drawn = broken_of(cover, part, SEEDS["check"], first=row["draws"])
        row = {"draws": row["draws"] + drawn, "broken": row["broken"] + broken}
        note("verified", family, row)


def cornered(family: str, most: int) -> None:
    """Verify the catches of proven cells in all corners, where bounds are least; evenly chosen."""
    cover = load_cover(folder_of(family, CHECKED))
    held = [cell for cell in cover.leaves() if cell.held >= 0]
    asked = [
        (cover.catches[cell.held], np.where(corner, cell.high, cell.low))
        for cell in held
        for corner in product((False, True), repeat=len(cell.low))
    ]
    chosen, broken = asked[:: -(-len(asked) // most)], 0
    for catch, theta in chosen:
        broken += not catch.verdict(cover.family, theta).good
    note("corners", family, {"draws": len(chosen), "broken": broken})


def refereed(family: str, count: int) -> None:
    """Let the referee judge answers to draws from proven cells."""
    planner = with_cover(folder_of(family, CHECKED))
    cover, broken, caught = planner.covers[0], 0, 0
    for theta, _ in draws(cover, count, SEEDS["judge"]):
        situation = cover.family.situation(theta)
        plan = planner.plan(situation)
        caught += plan.caught
        broken += plan.caught and bool(complaints(situation, plan))
    note("judged", family, {"draws": count, "caught": caught, "broken": broken})


def timed(family: str, count: int) -> None:
    """Measure answers to draws from the whole box, covered or not."""
    for free in (2, 3, 4, 5):
        if not is_cover(folder_of(family, free)):
            continue
        planner, random = with_cover(folder_of(family, free)), rng(SEEDS["time"], free)
        asked = planner.covers[0].family
        took, wall = [], []
        for k in range(count + 100):
            situation = asked.situation(random.uniform(asked.low, asked.high))
            since, begun = thread_time(), perf_counter()
            planner.plan(situation)
            if k >= 100:  # code is loaded
                took.append(1e3 * (thread_time() - since))
                wall.append(1e3 * (perf_counter() - begun))
        shares = {f"{q:g}": float(np.quantile(took, q)) for q in (0.5, 0.99, 0.999)}
        within = float(np.mean(np.array(took) <= 0.2))
        row = {"answers": count, "ms": shares, "within_0.2_ms": within}
        row["wall_ms"] = {f"{q:g}": float(np.quantile(wall, q)) for q in (0.5, 0.99, 0.999)}
        note("times", f"{family}-{free}", row)


def main() -> None:
    """Do what the words ask for."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("what", choices=("grow", "check", "corners", "judge", "time", "report"))
    parser.add_argument("--families", default=",".join(FAMILIES))
    parser.add_argument("--free", default="2,3,4,5")
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--workers", type=int, default=1)
    parser.add_argument("--draws", type=int, default=1000)
    given = parser.parse_args()
    if given.what == "report":
        from report import write

        write()
        return
    for family in given.families.split(","):
        if given.what == "grow":
            for free in map(int, given.free.split(",")):
                grown(family, free, given.minutes, given.workers)
        else:
            act = {"check": checked, "corners": cornered, "judge": refereed, "time": timed}[
                given.what
            ]
            act(family, given.draws)


if __name__ == "__main__":
    main()
