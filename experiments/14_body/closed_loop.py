"""What perception noise costs who plans once, and what replanning wins back; writes closed-loop.md.

python -m experiments 14_body/closed_loop --minutes 9            as much as nine minutes allow
python -m experiments 14_body/closed_loop --plant physical       the arm with mass
python -m experiments 14_body/closed_loop --count 24             a quick look
python -m experiments 14_body/closed_loop --policy NAME          another trained actor

Development data.  What is done is kept in out/ and not done again; Ctrl-C is safe.  Thinking is
charged by processor time, so numbers vary a little from machine to machine.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path
from time import monotonic, process_time
from typing import Any, NamedTuple

import numpy as np

from gcm_learn.arms import SPATIAL, SpatialArm
from gcm_learn.evaluation.statistics import difference, mcnemar, wilson
from gcm_learn.execution import (
    OUTCOMES,
    ExactPlant,
    Loop,
    Mind,
    Perception,
    PhysicalPlant,
    Planning,
    body_for,
    run_closed_loop,
)
from gcm_learn.families import draw, family_names, get_family
from gcm_learn.planners import get_planner
from gcm_learn.policies import actor_names, shipped_actor
from gcm_learn.situation import Situation
from gcm_learn.storage import write_whole

HERE = Path(__file__).resolve().parent
SEED = 1400
COUNT = 204  # situations, of the twelve families in turn
RAMP = (0.08, 0.14)  # times in which joints come to their full speed [s]
NOISES = (0.005, 0.01)  # standard deviations that are tried [forearms]
CHOSEN = 0.0125  # that at which planning once loses 25 to 35 points
DROPOUTS = 0.5  # that begin in a second
LARGER = (0.025, 0.05)  # that replanning is tried with too
HABITS = ("once", "broken", "always")
POLICY = "ppo-space"
"""A trained actor, which acts anew in every period."""
FOLDER = HERE / "out"


class Case(NamedTuple):
    """One episode."""

    plant: str
    noise: float
    habit: str
    """Of `layered`, or the name of a trained actor."""
    thinking: str
    """"charged", or "one period": every thought takes that long."""
    index: int


def cases(plant: str, count: int, policy: str) -> Iterator[Case]:
    """All that is to be done, what matters most first."""
    rows = [(0.0, "once", "charged")] + [(CHOSEN, habit, "charged") for habit in HABITS]
    if policy in actor_names(SPATIAL):
        rows += [(noise, policy, "charged") for noise in (0.0, CHOSEN)]
    if plant == "exact":
        rows += [(0.0, "broken", "charged"), (CHOSEN, "broken", "one period")]
        rows += [(noise, "broken", "charged") for noise in LARGER]
        rows += [(noise, "once", "charged") for noise in NOISES]
    for noise, habit, thinking in dict.fromkeys(rows):
        for index in range(count):
            yield Case(plant, noise, habit, thinking, index)


def situation_of(index: int, seed: int = SEED) -> Situation[SpatialArm]:
    """A situation of the next family, at rest; its arm has limits of acceleration and a body."""
    names = family_names("spatial")
    family: Any = get_family(names[index % len(names)])
    arms: dict[str, Any] = {"ramp": RAMP, "human": 0.5, "nao": 0.5}
    return draw(replace(family, arm=replace(family.arm, **arms)), seed, index)


@cache
def mind_of(habit: str) -> Mind:
    """Who acts."""
    if habit in HABITS:
        return Planning(get_planner("search"), habit)
    return shipped_actor(habit).mind()


def play(case: Case) -> dict[str, Any]:
    """Play one episode."""
    situation = situation_of(case.index)
    perception = Perception(place=case.noise, dropouts=DROPOUTS)
    loop = Loop(perception, thinking=None if case.thinking == "charged" else perception.period)
    if case.plant == "exact":
        plant: Any = ExactPlant(situation)
    else:
        plant = PhysicalPlant(situation, body_for(situation.arm))
    since = process_time()
    course = run_closed_loop(mind_of(case.habit), plant, situation, loop, SEED, case.index)
    return case._asdict() | {
        "outcome": OUTCOMES[course.outcome],
        "time": course.time,
        "thoughts": len(course.thoughts),
        "took": [round(thought.took, 4) for thought in course.thoughts],
        "found": sum(thought.found for thought in course.thoughts),
        "seconds": round(process_time() - since, 3),
    }


def done(path: Path) -> dict[Case, dict[str, Any]]:
    """What was played before."""
    if not path.exists():
        return {}
    rows = [json.loads(line) for line in path.read_text().splitlines()]
    return {Case(*(row[name] for name in Case._fields)): row for row in rows}


def write_table(rows: dict[Case, dict[str, Any]]) -> None:
    """One line for each way, on the situations that all of its plant have played."""
    lines = [
        "| plant | noise [forearms] | plans | thinking | situations | caught % | touched % "
        "| lost against exact eyes | thoughts | ms, median / 90 % |",
        "|---|---|---|---|---|---|---|---|---|---|",
    ]
    for plant in dict.fromkeys(case.plant for case in rows):
        ways = {case[:4] for case in rows if case.plant == plant}
        order = (*HABITS, *sorted({way[2] for way in ways} - set(HABITS)))
        for way in sorted(ways, key=lambda way: (order.index(way[2]), way[1:])):
            mine = {c.index: row for c, row in rows.items() if c[:4] == way}
            best = (plant, 0.0, "once" if way[2] in HABITS else way[2], "charged")
            exact = {c.index: row for c, row in rows.items() if c[:4] == best != way}
            lines.append(_line(way, mine, exact))
    write_whole(HERE / "closed-loop.md", ("\n".join(lines) + "\n").encode())


def _line(way: tuple[Any, ...], mine: dict[int, Any], exact: dict[int, Any]) -> str:
    plant, noise, habit, thinking = way
    n = len(mine)
    caught = wilson(sum(row["outcome"] == "caught" for row in mine.values()), n)
    touched = wilson(sum(row["outcome"] == "touched" for row in mine.values()), n)
    both = sorted(set(mine) & set(exact))
    lost = ""
    if both:
        first = np.array([exact[k]["outcome"] == "caught" for k in both])
        second = np.array([mine[k]["outcome"] == "caught" for k in both])
        gap = difference(first, second, np.array(both) % len(family_names("spatial")))
        lost = f"{_share(gap)}, p = {mcnemar(first, second)[2]:.2g}"
    took = 1e3 * np.array([t for row in mine.values() for t in row["took"]] or [np.nan])
    cost = f"{np.median(took):.0f} / {np.quantile(took, 0.9):.0f}"
    thoughts = np.mean([row["thoughts"] for row in mine.values()])
    cells = (plant, f"{noise:g}", habit, thinking, n, _share(caught), _share(touched), lost)
    return "| " + " | ".join(map(str, (*cells, f"{thoughts:.1f}", cost))) + " |"


def _share(interval: Any) -> str:
    return f"{100 * interval.value:.1f} ({100 * interval.low:.1f} to {100 * interval.high:.1f})"


def main() -> None:
    """Play what is missing, then write the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--plant", choices=("exact", "physical"), default="exact")
    parser.add_argument("--count", type=int, default=COUNT)
    parser.add_argument("--minutes", type=float, default=1e9)
    parser.add_argument("--only", help="rows of this habit or actor")
    parser.add_argument("--policy", default=POLICY, help="left out where there is none")
    given = parser.parse_args()
    FOLDER.mkdir(exist_ok=True)
    path = FOLDER / "closed-loop.jsonl"
    rows, since = done(path), monotonic()
    get_planner("search").plan(situation_of(0))  # compiled before anything is charged
    with path.open("a") as stream:
        for case in cases(given.plant, given.count, given.policy):
            if monotonic() - since > 60.0 * given.minutes:
                break
            if case not in rows and given.only in (None, case.habit):
                rows[case] = play(case)
                stream.write(json.dumps(rows[case]) + "\n")
                stream.flush()
    write_table(rows)


if __name__ == "__main__":
    main()
