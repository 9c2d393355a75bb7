"""Reach among recorded bodies that a predictor foretells, with and without margins (H20).

python -m experiments 25_margins TRACKS [--seed HEX] [--development]

TRACKS are states of table-tennis balls (.json.gz) or people (.csv). Writes a table beside this
file, and answers into out/.
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np
from scenes import FREE, HORIZON, Balls, People, draws

from gcm_learn.evaluation import Case, Sheet, Table, ask, calibrate, pairs
from gcm_learn.evaluation.calibration import split
from gcm_learn.evaluation.judging import judged_again
from gcm_learn.evaluation.statistics import wilson
from gcm_learn.outside import read_tracks, windows
from gcm_learn.situation import Margin

HERE, HALVES, SEEDS = Path(__file__).parent, 0, 20
SAME_LOSS = {"balls": 0.135, "people": 0.15}
"""Constant margins that lose as many catches as the calibrated one, by --development [m]."""
GRID = (0.02, 0.05, 0.1, 0.15, 0.2, 0.25)


def in_truth(sheet: Sheet, truth: dict[str, Case]) -> Sheet:
    """Return plans by what their entrant knew, judged where bodies move as they were recorded."""
    cases = [truth[name] for name in sheet["name"]]
    texts = {"situation": [c.text for c in cases], "key": [c.key for c in cases]}
    texts |= {"entrant": sheet["suite"], "suite": ["truth"] * len(cases)}
    columns = {name: np.array(rows, dtype=object) for name, rows in texts.items()}
    told = replace(sheet, columns={**sheet.columns, **columns})
    plans, found = told.caught, told["outcome"].copy()
    judged = judged_again(told.where(plans))
    touches = np.array(["touch" in reason for reason in judged["reason"]])
    found[plans] = np.where(touches, "touched", judged["outcome"])
    return replace(told, columns={**told.columns, "outcome": found})


def outcomes(real: Sheet, margins: dict[str, Margin | None]) -> Table:
    """Return plans, touches among them and catches, by what was known."""
    rows = []
    for name, margin in margins.items():
        part = real.where(entrant=name)
        touched = int((part["outcome"] == "touched").sum())
        broken, caught = int((part["outcome"] == "broken").sum()), int(part.caught.sum())
        plans, of = caught + touched + broken, len(part)
        now, rate = (margin.now, margin.rate) if margin else (0.0, 0.0)
        ms = float(np.median(part["ms"] * part["factor"]))
        rows.append([name, now, rate, of, plans, touched, broken, wilson(touched, plans),
                     wilson(caught, of), ms])  # fmt: skip
    return Table(["known by", "now [m]", "rate [m/s]", "scenes", "plans", "touch", "broken",
                  "touch of plans [%]", "caught [%]", "median [ms]"], rows)  # fmt: skip


def main() -> None:
    """Ask, and write what came of it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("tracks", type=Path)
    parser.add_argument("--seed", type=lambda text: int(text, 16), default=0, help="of scenes")
    parser.add_argument("--count", type=int, default=500, help="scenes")
    parser.add_argument("--development", action="store_true", help="scenes from the first half")
    given = parser.parse_args()
    kind = People if given.tracks.suffix == ".csv" else Balls
    name = kind.__name__.lower()
    found = windows(read_tracks(given.tracks, HORIZON), HORIZON, kind.looks, HALVES)
    done = calibrate(found, kind.predictor, seed=HALVES)
    joint = calibrate(found, kind.predictor, 1.0 - 0.05 / kind.count, HALVES)
    even = calibrate(found, kind.predictor, seed=HALVES, shapes=(1.0,))
    margins = {"exact": None, "no margin": FREE, "calibrated": done.margin,
               "calibrated jointly": joint.margin, "constant, same cover": even.margin,
               "constant, same loss": Margin(SAME_LOSS[name], 0.0)}  # fmt: skip
    if given.development:
        margins |= {f"constant {c:g}": Margin(c, 0.0) for c in GRID}
    for_shape, for_margin, held_out = split(len(found), HALVES)
    half = np.concatenate([for_shape, for_margin]) if given.development else held_out
    drawn = draws(kind([found[k] for k in half]), given.seed, given.count)
    worlds = {known: [Case(one.situation(margin), known) for one in drawn]
              for known, margin in margins.items()}  # fmt: skip
    out = HERE / "out" / f"{name}-{given.seed:08x}{'d' * given.development}"
    sheet = ask(["search"], [case for cases in worlds.values() for case in cases], keep=out)
    real = in_truth(sheet, {case.situation.name: case for case in worlds["exact"]})
    real.save(out / "sheet.parquet")
    more = range(1, 1 if given.development else SEEDS)
    seeds = [done, *(calibrate(found, kind.predictor, seed=s) for s in more)]
    rows = [[s, c.margin.now, c.margin.rate, c.within, c.held_out, c.covered]
            for s, c in enumerate(seeds)]  # fmt: skip
    covers = Table(["halves", "now [m]", "rate [m/s]", "within", "of", "held [%]"], rows)
    told = "\n\n".join(map(str, [outcomes(real, margins), pairs(real, "exact"), covers]))
    where = out if given.development else HERE
    (where / f"{name}.md").write_text(told + "\n", "utf-8")
    print(told)


if __name__ == "__main__":
    main()
