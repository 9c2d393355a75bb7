"""A minute at the belt: a Panda picks by search, by memory and by cover, and thinking is charged.

python -m experiments 27_belt prepare            a memory and a cover, in minutes
python -m experiments 27_belt ask --minutes 10   table.md
python -m experiments 27_belt/film               film.gif
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np
import world
from scipy.stats import t as student

from gcm_learn import Movement, get_planner, rng, solve
from gcm_learn.arms import kind_of
from gcm_learn.cover import FAMILIES, Budget, Cover, grow, is_cover, load_cover, with_cover
from gcm_learn.evaluation import Table
from gcm_learn.planners import Plan, plan_to_json
from gcm_learn.planners.outside import judged_anew
from gcm_learn.processes import Here
from gcm_learn.recall import HybridPlanner, Memory, RawIndex, RecallPlanner, waypoints_of
from gcm_learn.referee import examine
from gcm_learn.situation import situation_to_json

HERE = Path(__file__).resolve().parent
OUT = HERE / "out"
DRAWS, SHARE = 2000, 0.95  # that a memory is made of; of the family, by the cover
BUDGETS = (0.01, 0.02, 0.05, 0.1)  # charged for each thought [s]
LOOK = 0.02  # from look to look at an empty belt [s]
LEAST = 1e-9  # turn or time that is told from none [rad], [s]
SEED = 27

FAMILIES["pick"] = world.picks  # so that its cover can be read
Ask = Callable[[Any], Plan]


def prepare() -> None:
    """Make a memory and a cover of the family."""
    family, random = world.picks(), rng(SEED, 0)
    asked = [family.situation(random.uniform(family.low, family.high)) for _ in range(DRAWS)]
    plans = [solve(situation) for situation in asked]
    pairs = [
        (s, waypoints_of(s, plan)) for s, plan in zip(asked, plans, strict=True) if plan.caught
    ]
    memory = Memory(RawIndex.fit(asked), kind=kind_of(asked[0]))
    memory.add([s for s, _ in pairs], [way for _, way in pairs])
    memory.save(OUT / "memory")
    cover = load_cover(OUT / "cover") if is_cover(OUT / "cover") else Cover(family)
    grow(cover, Budget(SHARE), Here(), keep=lambda done: done.save(OUT / "cover"))
    print(f"{len(memory)} catches; cover of {cover.share:.3f} in {cover.seconds:.0f} s")


def entrants() -> dict[str, Ask]:
    """Return planners; each answers with the first catch that it finds."""
    search: Any = get_planner("search")
    hybrid: Any = HybridPlanner(RecallPlanner(Memory.load(OUT / "memory"), 20), search)
    covered = with_cover(OUT / "cover")
    names = [body.name for body in world.picks().middle.bodies]

    def by_cover(situation: Any) -> Plan:
        """Ask the cover about the wanted part alone; the whole pick is verified later."""
        own = {b.name: b for b in situation.bodies} | {"part": situation.targets[0]}
        plan = covered.plan(replace(situation, bodies=tuple(own[name] for name in names)))
        return plan if plan.caught else search.plan(situation)

    return {
        "search": search.plan,
        "memory, then search": hybrid.plan,
        "cover, then search": by_cover,
    }


def gone_to(moves: Any, posture: np.ndarray) -> Movement:
    """Return a movement that goes on from its rest to a rest, straight in the joints.

    The way there has seven pieces of constant jerk.
    """
    arm, first = world.PANDA, moves.joints[-1]
    way = posture - first
    most: Any = (arm.max_joint_speed, arm.max_joint_acceleration, arm.max_joint_jerk)
    far = np.maximum(np.abs(way), LEAST)
    speed, force, jerk = (0.98 * (np.array(row) / far).min() for row in most)
    rise = min(force / jerk, (0.5 / jerk) ** (1 / 3))
    force = rise * jerk
    level = min(0.5 * (math.sqrt(rise**2 + 4.0 / force) - 3.0 * rise), speed / force - rise)
    top = force * (rise + level)
    cruise = max(0.0, 1.0 / top - (2.0 * rise + level))
    spans = (rise, level, rise, cruise, rise, level, rise)
    states = [(0.0, 0.0, 0.0)]
    for span, sign in zip(spans, (1, 0, -1, 0, -1, 0, 1), strict=True):
        s, v, a = states[-1]
        j = sign * jerk
        s += span * (v + span * (a / 2 + span * j / 6))
        states.append((s, v + span * (a + span * j / 2), a + span * j))
    share, pace, _ = np.array(states[1:]).T[:, np.array(spans) > LEAST]
    times = moves.duration + np.cumsum(spans)[np.array(spans) > LEAST]
    share[-1], pace[-1] = 1.0, 0.0
    return Movement(
        arm,
        np.concatenate([moves.time, times]),
        np.concatenate([moves.joints, first + share[:, None] * way]),
        np.concatenate([moves.rates, pace[:, None] * way]),
    )


def ways_home(moves: Any) -> Iterator[Movement]:
    """Yield a movement that goes on to home: straight, or drawn back and up at first."""
    home, last = np.array(world.HOME), moves.joints[-1]
    yield gone_to(moves, home)
    for share in (0.5, 1.0):
        drawn = last + share * (home - last)
        drawn[0] = last[0]
        yield gone_to(gone_to(moves, drawn), home)


def picked(situation: Any, plan: Plan) -> tuple[Any, Any] | None:
    """Return the situation and the verified plan of a whole pick, the way home included."""
    whole = world.with_place(situation)
    for moves in ways_home(plan.trajectory):
        # a proven plan would be verified for the clearance that it had before
        found = replace(plan, trajectory=moves, placed=moves.duration, clearance=None)
        fault, clearance = judged_anew(whole, found)
        if fault is None:
            return whole, replace(found, clearance=clearance)
    return None


@dataclass(eq=False)
class Run:
    """A minute at the belt with one planner: its picks and planning times."""

    minute: world.Minute
    budget: float
    legs: list[tuple[float, Any, Any]] = field(default_factory=list)
    """When the arm goes [s], the situation then, and the plan."""
    thoughts: list[tuple[float, bool]] = field(default_factory=list)
    """Of each call of the planner: processor time [s], and if a plan came in time."""

    @property
    def thinks(self) -> float:
        """Median processor time of a plan [s]."""
        return float(np.median([took for took, _ in self.thoughts]))

    @property
    def broken(self) -> int:
        """Picks of which the referee complains."""
        given = ((situation_to_json(s), plan_to_json(plan)) for _, s, plan in self.legs)
        return sum(bool(examine(*pair).complaints) for pair in given)


def at_the_belt(minute: world.Minute, ask: Ask, budget: float) -> Run:
    """Return the run of a minute, in which each plan takes the budget, or longer if it is late.

    A plan is for one part. If none is found in time, the next plan is for the next part.
    """
    run, t, gone, vain = Run(minute, budget), 0.0, set[str](), 0
    while t < world.LENGTH:
        ready = minute.reached(t + budget, gone)
        if not ready:
            t += LOOK
            continue
        situation = minute.moment(t + budget, ready[vain % len(ready)], gone)
        since = process_time()
        plan = ask(situation)
        found = picked(situation, plan) if plan.caught else None
        took = process_time() - since
        timely = found is not None and took <= budget
        run.thoughts.append((took, timely))
        t, vain = t + max(budget, took), vain + 1
        if found is not None and timely:
            run.legs.append((t, *found))
            gone.add(situation.name)
            t, vain = t + found[1].trajectory.duration, 0
    return run


HEAD = ["by, charged", "in the bin", "of those seen [%]", "more than search", "missed",
        "thoughts in vain", "late", "median thought [ms]", "mean pick [s]", "broken"]  # fmt: skip


def row(name: str, runs: list[Run], by_search: list[Run]) -> list[Any]:
    """Return means of some minutes, with the difference from the search in the same minutes."""
    count, seen = len(runs), sum(len(run.minute.parts) for run in runs)
    thoughts = [thought for run in runs for thought in run.thoughts]
    late = sum(took > run.budget for run in runs for took, _ in run.thoughts)
    vain = sum(not timely for _, timely in thoughts)
    picks = sum(len(run.legs) for run in runs)
    more = [len(run.legs) - len(other.legs) for run, other in zip(runs, by_search, strict=True)]
    off = float(student.ppf(0.975, count - 1) * np.std(more, ddof=1)) / math.sqrt(count)
    mean = float(np.mean(more))
    return [
        f"{name}, {1e3 * runs[0].budget:g} ms",
        picks / count,
        picks / seen,
        "–" if runs is by_search else f"{mean:+.1f} ({mean - off:+.1f} to {mean + off:+.1f})",
        (seen - picks) / count,
        vain / count,
        late / count,
        1e3 * float(np.median([took for took, _ in thoughts])),
        float(np.mean([plan.trajectory.duration for run in runs for _, _, plan in run.legs])),
        sum(run.broken for run in runs),
    ]


def main() -> None:
    """Prepare, or ask and write a table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=["prepare", "ask"])
    parser.add_argument("--minutes", type=int, default=10, help="minutes, of other seeds each")
    given = parser.parse_args()
    if given.minutes < 2:
        parser.error("--minutes: intervals need at least 2")
    OUT.mkdir(exist_ok=True)
    if given.what == "prepare":
        prepare()
        return
    minutes, rows = [world.Minute(k) for k in range(given.minutes)], []
    asked = entrants()
    for ask in asked.values():
        at_the_belt(minutes[0], ask, BUDGETS[-1])  # for nothing: kernels are loaded
    for budget in BUDGETS:
        by_search: list[Run] = []
        for name, ask in asked.items():
            runs = [at_the_belt(minute, ask, budget) for minute in minutes]
            by_search = by_search or runs
            rows.append(row(name, runs, by_search))
            print(rows[-1], flush=True)
    told = str(Table(HEAD, rows))
    (HERE / "table.md").write_text(told + "\n", "utf-8")
    print(told)


if __name__ == "__main__":
    main()
