"""Covers of held catches (H21): growth, checks, a profile of the proof, and a control.

python -m experiments 20_cover/held grow --free 3 --minutes 60   as run.py, for the held families
python -m experiments 20_cover/held check --draws 100000         the same, and corners, judge, time
python -m experiments 20_cover/held profile                      causes of cuts, where time goes
python -m experiments 20_cover/held control          obstacles taken as fixed in a cell
python -m experiments 20_cover/held report                       held.md

Results are added to held.json.
"""

from __future__ import annotations

import argparse
import json
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from time import perf_counter
from typing import Any

import numpy as np

from gcm_learn.cover import (
    Budget,
    Cover,
    Question,
    broken_of,
    examine,
    grow,
    held as proof,
    is_cover,
    load_cover,
    parametric_family,
)
from gcm_learn.evaluation import Table
from gcm_learn.processes import Here
from gcm_learn.situation import Margin
from gcm_learn.storage import write_whole

HERE = Path(__file__).resolve().parent
FAMILIES = "held-belt,held-belt-varied"
SAMPLE = 200  # examined cells whose time is measured
TIMES = (2.0, 5.0, 10.0, 30.0, 60.0, 120.0, 300.0)  # of the share that is told [s]


def clocked(spent: Counter[str], call: Callable[..., Any], name: Callable[[Any], str]) -> Any:
    """Return a function that adds the time of its calls to a sum, by what they return."""

    def timed(*given: Any) -> Any:
        since = perf_counter()
        result = call(*given)
        spent[name(result)] += 1e3 * (perf_counter() - since)  # type: ignore[assignment]
        return result

    return timed


def profiled(family: str, run: Any) -> None:
    """Note why cells were cut, along which parameter, and where the time of examinations goes."""
    for free in (3, 4, 5):
        folder = run.folder_of(family, free)
        if not is_cover(folder):
            continue
        cover = load_cover(folder)
        names = [parameter.name for parameter in cover.family.parameters]
        cuts = Counter(f"{c.reason}: {names[c.axis]}" for c in cover.cells if c.axis >= 0)
        done = [cell for cell in cover.leaves() if cell.held >= 0]
        sides = [np.log2((cover.family.high - cover.family.low) / (c.high - c.low)) for c in done]
        depth = dict(zip(names, np.mean(sides, axis=0).round(1).tolist(), strict=True))
        row = {"cuts": dict(cuts.most_common()), "halvings": depth, "ms": _times(cover)}
        run.note("profile", f"{family}-{free}", row)


def _times(cover: Cover) -> dict[str, float]:
    """Measure a sample of the examined cells anew, without stored catches; mean times [ms]."""
    asked = [cell for cell in cover.cells if cell.held >= 0 or cell.reason not in ("", "grasp")]
    chosen = np.random.default_rng(0).permutation(len(asked))[:SAMPLE]
    spent: Counter[str] = Counter()
    kept = proof.solve, proof.verify
    found = {True: "search that finds", False: "search that finds nothing"}
    proof.solve = clocked(spent, proof.solve, lambda plan: found[plan.caught])
    proof.verify = clocked(spent, proof.verify, lambda verdict: "proof")
    since = perf_counter()
    for k in chosen:
        low, high = asked[k].low, asked[k].high
        examine(Question(cover.family, 0.5 * (low + high), 0.5 * (high - low), []))
    whole = 1e3 * (perf_counter() - since)
    proof.solve, proof.verify = kept
    spent["the rest"] = whole - sum(spent.values())  # type: ignore[assignment]
    return {name: round(took / len(chosen), 2) for name, took in spent.items()}


def controlled(family: str, run: Any, draws: int = 4000) -> None:
    """Grow a cover by a proof that takes obstacles as in the middle of each cell; verify draws."""
    cover = Cover(parametric_family(family).free(run.CHECKED))
    proof.Margin = lambda now, rate: Margin(0.0, 0.0)  # type: ignore[misc,assignment]
    grow(cover, Budget(run.SHARE, 5.0), Here())
    proof.Margin = Margin  # type: ignore[misc]
    broken, drawn = broken_of(cover, draws, run.SEEDS["check"])
    run.note("control", family, {"share": cover.share, "draws": drawn, "broken": broken})


def results(folder: Path) -> dict[str, str]:
    """Return the page of the results."""
    import report

    found = json.loads((folder / "held.json").read_text("utf-8"))
    parts = ["## Growth", report.growth(found["growth"]), "## Share over time, one process"]
    parts += [_shares(found["growth"]), "## Draws from proven cells, 3 parameters"]
    parts += [report.drawn(found), "## Time of an answer", report.times(found["times"])]
    parts += ["## Why cells are cut", _cuts(found["profile"]), "## Time of an examination"]
    parts += [_spent(found["profile"]), "## Control: obstacles taken as fixed in a cell"]
    rows = [[name, f"{100 * r['share']:.1f}", r["draws"], r["broken"]]
            for name, r in found["control"].items()]  # fmt: skip
    parts += [str(Table(["family", "covered [%]", "draws", "broken"], rows))]
    return {"held.md": "\n\n".join(parts) + "\n"}


def _shares(rows: dict[str, Any]) -> str:
    """Return what was covered at some times."""
    made = []
    for name, row in rows.items():
        time, share = [c[3] for c in row["curve"]], [100.0 * c[2] for c in row["curve"]]
        known = [f"{np.interp(t, time, share):.0f}" if t < time[-1] else "" for t in TIMES]
        made.append([name, *known, f"{share[-1]:.1f} at {time[-1]:.0f} s"])
    return str(Table(["cover", *(f"{t:g} s [%]" for t in TIMES), "end [%]"], made))


def _cuts(rows: dict[str, Any]) -> str:
    """Return the causes of cuts, and how often each parameter was halved."""
    made = []
    for name, row in rows.items():
        causes = ", ".join(f"{cause} {count:,}" for cause, count in row["cuts"].items())
        halved = ", ".join(f"{name} {times:g}" for name, times in row["halvings"].items())
        made.append([name, causes, halved])
    return str(Table(["cover", "cuts, by cause and parameter", "halvings of proven cells"], made))


def _spent(rows: dict[str, Any]) -> str:
    """Return where the time goes."""
    parts = ("search that finds", "search that finds nothing", "proof", "the rest")
    made = [[name, *(f"{row['ms'].get(p, 0.0):.2f}" for p in parts)] for name, row in rows.items()]
    return str(Table(["cover", *(f"{part} [ms]" for part in parts)], made))


def main() -> None:
    """Do what the words ask for."""
    import run

    run.RESULTS, run.ROWS = HERE / "held.json", 40
    acts = {"check": run.checked, "corners": run.cornered, "judge": run.refereed, "time": run.timed}
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("what", choices=("grow", *acts, "profile", "control", "report"))
    parser.add_argument("--families", default=FAMILIES)
    parser.add_argument("--free", default="3")
    parser.add_argument("--minutes", type=float, default=60.0)
    parser.add_argument("--draws", type=int, default=1000)
    given = parser.parse_args()
    if given.what == "report":
        write_whole(HERE / "held.md", results(HERE)["held.md"])
        return
    for family in given.families.split(","):
        if given.what == "grow":
            for free in map(int, given.free.split(",")):
                run.grown(family, free, given.minutes, 1)
        elif given.what in acts:
            acts[given.what](family, given.draws)
        else:
            {"profile": profiled, "control": controlled}[given.what](family, run)


if __name__ == "__main__":
    main()
