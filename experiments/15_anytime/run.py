"""What more time to think is worth, with a memory and without; writes ARM.json and ARM.png.

python -m experiments 15_anytime                     the plane: 150 of W and 100 of Q
python -m experiments 15_anytime --arm space         as much as there is in space
python -m experiments 15_anytime --minutes 9         what can be done in nine minutes

What is done is kept in out/ and not done again; Ctrl-C is safe.  The plane's situations are the
first of the frozen suites, which are drawn if they are not there (`--suites DIR`).
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from time import monotonic, process_time
from typing import Any, NamedTuple

import numpy as np

from gcm_learn import CognitiveMap, build_map, get_planner
from gcm_learn.evaluation import draw_suite, wilson
from gcm_learn.families import draw, family_names, get_family
from gcm_learn.planners.joints.layered import COARSE, FINE, LayeredInSpace
from gcm_learn.plots import style
from gcm_learn.recall import HybridPlanner
from gcm_learn.situation import AnySituation
from gcm_learn.storage import write_whole
from gcm_learn.wave import MarchingParams

HERE = Path(__file__).resolve().parent
DEADLINES = (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0)  # processor time [ms]
SUITES = {"W": 150, "Q": 100}
SEED, EACH = 1500, 12  # of situations in space, of each family
NEAR = 0.1  # of the horizon: as late as that counts as well caught
TOLD = (1, 10, 100)  # of these at the axis
NAMES = {"hybrid-random": "hybrid, random memories"}
COLOURS = {"hybrid": style.TARGET, "layered": style.OBSTACLE, "hybrid-random": style.FAINT}
OUT = HERE / "out"


class Case(NamedTuple):
    """A situation with a name that does not change."""

    group: str
    index: int
    situation: AnySituation


def in_plane(folder: Path | None) -> Iterator[Case]:
    """The first of W and of Q."""
    for name, count in SUITES.items():
        for entry in draw_suite(name, count, folder):
            yield Case(name, entry.index, entry.situation)


def in_space(folder: Path | None) -> Iterator[Case]:
    """Of all families in turn, without limits of acceleration."""
    for index in range(EACH):
        for name in family_names("spatial"):
            situation: Any = draw(get_family(name), SEED, index)
            free = replace(situation.arm, max_joint_acceleration=None, joint_rates=None)
            yield Case(name, index, replace(situation, arm=free))


@cache
def planners(arm: str) -> dict[str, Any]:
    """Who is compared: the hybrid, the same without memory, the same with random memories."""
    found: dict[str, Any] = {"layered": get_planner("layered")}
    hybrid: Any = get_planner("hybrid")
    if arm == "plane" or getattr(hybrid, "takes_space", False):
        chance: Any = get_planner("recall-random")
        found |= {"hybrid": hybrid, "hybrid-random": HybridPlanner(chance, name="hybrid-random")}
    return found


def recalled(arm: str) -> dict[str, Any]:
    """What memory says alone, and what one drawn at random does."""
    names = ("recall", "recall-random") if "hybrid" in planners(arm) else ()
    return {name: get_planner(name) for name in names}


@dataclass(frozen=True)
class InOrder:
    """Search in order of time in the plane: a map of a front that may wait, up to its contact."""

    def plan(self, situation: Any, bound: float | None = None) -> Any:
        """The map's interception, and how many arrivals it has."""
        ends = situation.horizon if bound is None else min(bound, situation.horizon)
        made: CognitiveMap = build_map(
            replace(situation, horizon=ends), MarchingParams(margin=0.0, lookback=0.0), wait=True
        )
        met = made.interception
        return Counted(None if met is None else met.time, int(made.sheets.count()))


class Counted(NamedTuple):
    """A search's answer."""

    catch_time: float | None
    nodes: int


@cache
def searches(arm: str) -> dict[str, Any]:
    """Searches whose nodes are counted."""
    if arm == "plane":
        return {"A*, to the earliest": get_planner("layered"), "in order of time": InOrder()}
    coarse, fine = COARSE._replace(weight=0.0), FINE._replace(weight=0.0)
    return {
        "A*, first catch": LayeredInSpace(),
        "A*, to the earliest": LayeredInSpace(earliest=True),
        "in order of time": LayeredInSpace(coarse=coarse, fine=fine),
    }


def answer(arm: str, case: Case) -> dict[str, Any]:
    """All that is asked of a situation."""
    situation: Any = case.situation
    row: dict[str, Any] = {"group": case.group, "index": case.index, "horizon": situation.horizon}
    row["answers"] = {
        name: [timed(planner, situation, deadline=1e-3 * ms) for ms in DEADLINES]
        for name, planner in planners(arm).items()
    }
    first = get_planner("layered").plan(situation)
    known = {"none": None, "A*": first.catch_time}
    known |= {name: p.plan(situation).catch_time for name, p in recalled(arm).items()}
    row["known"] = known
    row["nodes"] = {
        name: {
            bound: timed(search, situation, bound=when)
            for bound, when in known.items()
            if bound == "none" or when
        }
        for name, search in searches(arm).items()
    }
    return row


def timed(planner: Any, situation: AnySituation, **given: float | None) -> list[Any]:
    """When an answer catches [s], how long it took [ms], and how many nodes."""
    since = process_time()
    plan = planner.plan(situation, **given)
    return [plan.catch_time, round(1e3 * (process_time() - since), 3), plan.nodes]


def table(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Catches and lateness by deadline, nodes by bound."""
    out: dict[str, Any] = {"situations": len(rows), "deadlines": DEADLINES}
    rows = [row for row in rows if earliest(row) < np.inf]
    out |= {"catchable": len(rows), "methods": {}, "nodes": {}}
    for name in rows[0]["answers"]:
        out["methods"][name] = [
            by_then([(row, row["answers"][name][k]) for row in rows], ms)
            for k, ms in enumerate(DEADLINES)
        ]
    for search in rows[0]["nodes"]:
        whole = [row for row in rows if row["known"]["A*"] and row["nodes"][search]["none"][2] > 0]
        bounds = [bound for bound in rows[0]["known"] if bound != "none"]
        out["nodes"][search] = {bound: under(whole, search, bound) for bound in bounds}
    return out


def earliest(row: dict[str, Any]) -> float:
    """The earliest catch that anybody knows [s]."""
    told = [one[0] for mine in row["answers"].values() for one in mine]
    told += [row["known"]["A*"]]
    told += [one[0] for name, all_of_it in row["nodes"].items() if "A*" in name
             for one in all_of_it.values()]  # fmt: skip
    return min((t for t in told if t is not None), default=np.inf)


def by_then(told: list[tuple[dict[str, Any], list[Any]]], ms: float) -> dict[str, Any]:
    """What was caught by a deadline, and how much later than the earliest that is known."""
    late = np.array([
        (one[0] - earliest(row)) / row["horizon"] if one[0] is not None else np.inf
        for row, one in told
    ])  # fmt: skip
    caught, well = np.isfinite(late), late <= NEAR
    over = np.array([one[1] - ms for _, one in told])
    return {
        "caught": list(wilson(int(caught.sum()), len(told))),
        "well caught": list(wilson(int(well.sum()), len(told))),
        "later, mean [horizons]": float(late[caught].mean()) if caught.any() else None,
        "ms beyond, median": float(np.median(over)),
        "ms beyond, 95 %": float(np.quantile(over, 0.95)),
    }


def under(rows: list[dict[str, Any]], search: str, bound: str) -> dict[str, Any]:
    """Nodes under a bound, as shares of those without, where the bound is known."""
    both = [(row["nodes"][search]["none"], row["nodes"][search].get(bound), row) for row in rows]
    pairs = [(free, held, row) for free, held, row in both if held is not None]
    if not pairs:
        return {"situations": 0}
    off = [(row["known"][bound] - earliest(row)) / row["horizon"] for *_, row in pairs]
    found = [(free, held) for free, held, _ in pairs if held[0] is not None]
    shares = [held[2] / free[2] for free, held in found] or [np.nan]
    return {
        "situations": len(pairs),
        "bound after the earliest, median [horizons]": float(np.median(off)),
        "nodes without, median": float(np.median([free[2] for free, *_ in pairs])),
        "finds a catch": len(found),
        "nodes there, share, median": float(np.median(shares)),
        "nodes there, share, 10 %": float(np.quantile(shares, 0.1)),
        "nodes there, share of all": of_all(found),
        "nodes elsewhere, share of all": of_all([(f, h) for f, h, _ in pairs if h[0] is None]),
    }


def of_all(pairs: list[Any]) -> float | None:
    """Nodes of second answers, as a share of those of first ones."""
    return sum(h[2] for _, h in pairs) / sum(f[2] for f, _ in pairs) if pairs else None


def figure(made: dict[str, Any], path: Path) -> None:
    """Catch rate and lateness over the time that there is."""
    drawn = style.new_figure(8.0, 3.0)
    rate, late = drawn.subplots(1, 2)
    for name, mine in made["methods"].items():
        colour = COLOURS[name]
        told = NAMES.get(name, name)
        rate.plot(DEADLINES, [100 * one["caught"][0] for one in mine], color=colour, label=told)
        rate.plot(DEADLINES, [100 * one["well caught"][0] for one in mine], "--", color=colour)
        later = [one["later, mean [horizons]"] for one in mine]
        late.plot(DEADLINES, [np.nan if t is None else 100 * t for t in later], color=colour)
    rate.set_ylabel("caught [%]; dashed: early")
    late.set_ylabel("mean delay [% of horizon]")
    for panel in (rate, late):
        panel.set_xscale("log")
        panel.set_xticks(TOLD, [str(one) for one in TOLD])
        panel.set_xlabel("time to think [ms]")
    rate.legend(frameon=False)
    drawn.savefig(path)


def main() -> None:
    """Answer what is missing, then write table and figure."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--arm", choices=("plane", "space"), default="plane")
    parser.add_argument("--minutes", type=float, default=np.inf, help="no new one after that")
    parser.add_argument("--suites", type=Path, help="where frozen suites are kept")
    asked, started = parser.parse_args(), monotonic()
    OUT.mkdir(exist_ok=True)
    path = OUT / f"{asked.arm}.jsonl"
    rows = [json.loads(line) for line in path.read_text().splitlines()] if path.exists() else []
    known = {(row["group"], row["index"]) for row in rows}
    cases = list({"plane": in_plane, "space": in_space}[asked.arm](asked.suites))
    for case in cases[:3]:
        answer(asked.arm, case)  # kernels are loaded now
    order = np.random.default_rng(0).permutation(len(cases))  # whatever is done is a fair part
    with path.open("a") as stream:
        for case in (cases[k] for k in order):
            late = monotonic() - started > 60.0 * asked.minutes
            if late or (case.group, case.index) in known:
                continue
            rows.append(answer(asked.arm, case))
            stream.write(json.dumps(rows[-1]) + "\n")
            stream.flush()
    made = table(rows)
    write_whole(HERE / f"{asked.arm}.json", json.dumps(made, indent=1) + "\n")
    figure(made, HERE / f"{asked.arm}.png")


if __name__ == "__main__":
    main()
