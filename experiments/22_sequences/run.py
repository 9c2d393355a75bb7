"""Is memory needed to catch several targets in one movement? Writes outcomes, then tables.

python -m experiments 22_sequences choose [WORLD]   methods on validation draws, choice.json
python -m experiments 22_sequences ask [WORLD]      what is missing of the fresh situations
python -m experiments 22_sequences later [WORLD]    a method that was added afterwards
python -m experiments 22_sequences report           outcomes, tables, the figure

WORLD is space or panda. The memories come from `21_experience`: its parts draw and train go
before. Finished parts are kept in out/ and not repeated. Ask on a machine that does nothing else.
"""

from __future__ import annotations

import argparse
import itertools
import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from time import process_time
from typing import Any, NamedTuple

import memories
from report import asked_of, best_without, write_figure

from experiments.common.asking import ask_in_turns, publish, rows_of
from experiments.common.charging import after
from experiments.common.freezing import frozen_seed
from experiments.common.judging import complaints
from gcm_learn.families import draw, preset_families
from gcm_learn.planners import Deadline, Plan, TreeSearch, get_planner
from gcm_learn.planners.orders import ORDERS, Course
from gcm_learn.planners.sequences import joined

HERE = Path(__file__).resolve().parent
OUT, CHOICE = HERE / "out", HERE / "choice.json"
FROZEN = HERE / "frozen.json"
"""Commits that froze code and generator, and the seeds that their hashes give."""
VALIDATION, EACH = 1522, 60  # seed and situations by which the best without memory is chosen
PARTS = ("world", "method")  # of the outcomes, which are kept until they are asked anew
WARM = 3  # situations that are asked first and not counted
PERIODS = (1, 2, 5, 10)  # of thinking that are charged
PERIOD = 0.02  # [s]
LATER = "grow, search"
"""Method of `gcm-learn solve --deadline`, which was made after the fresh situations were seen."""
ROUNDS = {"search": 375, "short search": 94}  # postures of a leg's search


class World(NamedTuple):
    """Sequences of one kind of arm."""

    preset: str
    """Source of situations; its one family is drawn."""
    spec: str
    """Whose catches are remembered."""
    count: int
    """Fresh situations."""


WORLDS = {
    "space": World("space-sequences", "space-accelerated", 300),
    "panda": World("panda-sequences", "panda-accelerated", 300),
}


def drawn(world: World, seed: int) -> Iterator[tuple[int, Any]]:
    """Yield situations with several targets of which most are wanted, without end."""
    (family,) = preset_families(world.preset)
    for number in itertools.count():
        situation = draw(family, seed, number)
        if situation.catch == "most" and len(situation.targets) >= 3:
            yield number, situation


def methods(world: World) -> dict[str, tuple[str, Any]]:
    """Return the order and the planner of legs of all methods by name."""
    legs = {name: TreeSearch(rounds=rounds) for name, rounds in ROUNDS.items()}
    orders = [order for order in ORDERS if order != "grow"]
    made = {f"{order}, {name}": (order, leg) for order in orders for name, leg in legs.items()}
    for source in ("synthetic", "stored"):
        for way, join in memories.joined(world.spec, source).items():
            for name, leg in legs.items():
                made[f"bound, {source} {way} {name}"] = ("bound", join(leg))
    return made | {LATER: ("grow", get_planner("search"))}


def answer(order: str, leg: Any, situation: Any, budget: float) -> tuple[Plan | None, int]:
    """Return the plan that is there after a time [s], or None, and how many courses were found.

    The time has the check of the whole movement in it.
    """
    deadline, since, found = Deadline(budget), process_time(), []
    for course in ORDERS[order](leg.plan, Course(situation), lambda: deadline.over):
        found.append((process_time() - since, course))
    for spent, course in reversed(found):
        since = process_time()
        if spent < budget:
            plan = joined(situation, course.legs, 1e3 * spent)
            if plan.caught and spent + process_time() - since <= budget:
                return plan, len(found)
    return None, len(found)


def answers(
    number: int, situation: Any, asked: Sequence[tuple[str, tuple[str, Any]]]
) -> Iterator[dict[str, Any]]:
    """Yield the outcomes of all methods with all budgets."""
    about = {"situation": number, "targets": len(situation.targets), "stratum": "", "family": ""}
    for periods in PERIODS:
        moved = after(situation, periods * PERIOD)
        for name, (order, leg) in asked:
            row = about | {"method": name, "periods": periods, "got": 0}
            if isinstance(moved, str):
                yield row | {"caught": moved == "caught", "got": int(moved == "caught")}
                continue
            plan, found = answer(order, leg, moved, periods * PERIOD)
            row |= {"caught": plan is not None, "courses": found}
            if plan is not None:
                row |= {"got": 1 + len(plan.on_the_way), "catch_time": plan.catch_time}
                row |= {"complaints": len(complaints(moved, plan))}
            yield row


def ask(name: str, seed: int, count: int, file: Path, names: set[str] | None = None) -> None:
    """Ask methods, by default all but `LATER`, what is missing."""
    world, made = WORLDS[name], methods(WORLDS[name])
    names = made.keys() - {LATER} if names is None else names
    some = [(method, how) for method, how in made.items() if method in names]
    cases = list(itertools.islice(drawn(world, seed), WARM + count))

    def named(number: int, situation: Any, asked: Any) -> Iterator[dict[str, Any]]:
        return (row | {"world": name} for row in answers(number, situation, asked))

    for number, situation in cases[:WARM]:  # kernels are loaded now
        list(named(number, situation, some))
    ask_in_turns(file, cases[WARM:], some, named)


def choose(name: str) -> None:
    """Note for each budget which greedy method, which without and which with memory is the best."""
    made = json.loads(CHOICE.read_text("utf-8")) if CHOICE.exists() else {}
    file = OUT / f"validation-{name}.jsonl"
    ask(name, VALIDATION, EACH, file)
    made[name] = best_without(rows_of([file]))
    CHOICE.write_text(json.dumps(made, indent=1) + "\n", "utf-8")


def main() -> None:
    """Do one of the parts."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("part", choices=("choose", "ask", "later", "report"))
    parser.add_argument("world", nargs="?", choices=tuple(WORLDS), help="all by default")
    given = parser.parse_args()
    for name in [given.world] if given.world else WORLDS:
        if given.part == "choose":
            choose(name)
        elif given.part in ("ask", "later"):
            seed = frozen_seed(FROZEN, name)
            file = OUT / f"fresh-{seed}-{name}-{given.part}.jsonl"
            choice = json.loads(CHOICE.read_text("utf-8")).get(name)
            if choice is None:
                parser.error(f"{name}: no methods are chosen yet; `choose {name}` comes before")
            chosen = asked_of(choice)
            names = chosen if given.part == "ask" else {LATER}
            ask(name, seed, WORLDS[name].count, file, names)
    if given.part == "report":
        publish(HERE, sorted(OUT.glob("fresh-*.jsonl")), write_figure, PARTS)


if __name__ == "__main__":
    main()
