"""Situations of every stratum, as families yield them: drawn by number, families taking turns.

A suite of one stratum and equal shares of families has to look long for what some families hardly
ever yield. Here draw number k is what family k mod n draws, whatever stratum it is of. The suites
`L`, `W`, `Q` and `U` are the first draws of their stratum, so one draw serves all of them. From
some number on there is enough of L and W, and what two fast planners say to be either is passed
over.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from gcm_learn import families
from gcm_learn.processes import Crew
from gcm_learn.situation import canonical, planar, situation_to_json
from gcm_learn.storage import write_whole

SEED = 9108
CHUNK = 50  # draws of a file
FOLDER = "turns"
ENOUGH = 3500  # draws that yield as many of L and W as a suite can have: more than a third each
MOST = 100_000  # draws that are looked through for a suite
STRATA = {
    "L": "a straight line catches; all families",
    "W": "a way round is needed, no waiting; all families",
    "Q": "waiting is needed; all families",
    "U": "nothing catches; all families",
}
FAMILIES = (
    "static-clutter", "static-clutter-solid", "moving-point", "moving-point-solid",
    "crossing-swarm", "crossing-swarm-solid", "falling", "falling-solid", "spinning",
    "spinning-solid", "pendulum", "gate", "gate-solid", "behind-mover", "behind-mover-solid",
    "late-target", "late-target-solid", "random-planar", "random-solid",
)  # fmt: skip
"""Families that frozen suites are drawn from, in this order; later families are not among them."""
Draw = dict[str, Any]


def drawn(number: int, seed: int = SEED) -> Draw | None:
    """Return draw `number` as JSON values; None if it is passed over or its start is blocked."""
    from gcm_learn.planners import Problem, StraightPlanner, bounds, marching, stratum

    family = FAMILIES[number % len(FAMILIES)]
    situation, _ = canonical(planar(families.draw(family, seed, number), "a frozen suite"))
    answer = Problem(situation, "oracle").early_answer()
    if answer is not None and answer.status == "start_blocked":
        return None
    if number >= ENOUGH:
        if StraightPlanner().plan(situation).caught or marching().plan(situation).caught:
            return None
    known = bounds(situation)
    return {
        "index": number,
        "family": family,
        "stratum": stratum(situation, known),
        "earliest": known.upper if math.isfinite(known.upper) else None,
        "situation": situation_to_json(situation),
    }


def first_of(
    wanted: str,
    count: int,
    folder: Path,
    crew: Crew,
    seed: int = SEED,
    progress: Callable[[int], object] = lambda found: None,
) -> list[Draw]:
    """The first draws of a stratum; classified draws are kept in a folder.

    Parameters
    ----------
    wanted : str
        L, W, Q or U.
    count : int
    folder : Path
        Of suites.
    crew : Crew
    seed : int
    progress : callable
        Told how many more were found.
    """
    found: list[Draw] = []
    for lines in _chunks(folder / FOLDER, crew, seed):
        here = [d for d in map(json.loads, lines) if d is not None and d["stratum"] == wanted]
        found += here
        progress(len(here))
        if len(found) >= count:
            break
    return found[:count]


def _chunks(folder: Path, crew: Crew, seed: int) -> Iterator[list[str]]:
    """Yield the lines of each file in order; draw and write the files that are missing."""
    folder.mkdir(parents=True, exist_ok=True)
    firsts = range(0, MOST, CHUNK)
    missing = [first for first in firsts if not _file(folder, first).exists()]
    drawing = crew.results(_drawn, [(first, seed) for first in missing])
    for first in firsts:
        while not _file(folder, first).exists():
            number, lines = next(drawing)
            write_whole(_file(folder, missing[number]), "".join(line + "\n" for line in lines))
        yield _file(folder, first).read_text("utf-8").splitlines()


def _file(folder: Path, first: int) -> Path:
    return folder / f"draws_{first:07d}.jsonl"


def _drawn(part: tuple[int, int]) -> list[str]:
    """The lines of CHUNK situations from a number on, under a seed."""
    first, seed = part
    return [json.dumps(drawn(number, seed)) for number in range(first, first + CHUNK)]
