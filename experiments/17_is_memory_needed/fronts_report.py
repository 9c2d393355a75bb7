"""Tables of fronts and fallbacks, computed from outcomes.

A hybrid answers with what its front says, and asks its fallback where the front has no catch. So
each front and each fallback is asked once of a situation, and all hybrids are joined from that.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np

from experiments.common.comparing import complaints
from experiments.common.outcomes import Outcomes, read
from experiments.common.tables import percent, points, table
from gcm_learn.evaluation import chance, difference, holm, mcnemar, wilson

CHARGED_MS = 20.0  # thinking
FRONTS = ("learned", "raw", "random", "splines")
WHAT = {"caught": "20 ms charged", "ready": "20 ms charged, ready by then"}
FILES = {"fronts.md": "outcomes-fronts.csv.gz", "fronts-space.md": "outcomes-fronts-space.csv.gz"}


class Hybrid(NamedTuple):
    """Answers of a front before a fallback, by situation."""

    caught: np.ndarray  # (n,) bool
    ready: np.ndarray  # (n,) bool: caught, and answered by 20 ms
    ms: np.ndarray  # (n,): processor time
    family: np.ndarray  # (n,)


def results(folder: Path) -> dict[str, str]:
    """Return the tables of the suites whose outcomes are kept."""
    known = {name: folder / file for name, file in FILES.items()}
    return {name: page(read(file)) for name, file in known.items() if file.exists()}


def hybrids(found: Outcomes) -> dict[tuple[str, str], Hybrid]:
    """Return all hybrids by front and fallback."""
    fallbacks = [name for name in found.methods() if name not in FRONTS]
    every = dict(zip(found.methods(), found.by_situation(found.methods()), strict=True))
    made = {}
    for front in ("none", *(name for name in FRONTS if name in every)):
        for fallback in fallbacks:
            last = every[fallback]
            first = every.get(front)
            caught = np.zeros(len(last), bool) if first is None else first["caught"]
            spent = np.zeros(len(last)) if first is None else first["ms"]
            ms = spent + np.where(caught, 0.0, last["ms"])
            both = caught | last["caught"]
            made[front, fallback] = Hybrid(both, both & (ms <= CHARGED_MS), ms, last["family"])
    return made


def page(found: Outcomes) -> str:
    """Return all tables."""
    made = hybrids(found)
    first = found.where(method=found.methods()[0])
    counts = {s: len(first.where(stratum=s)) for s in ("W", "Q")}
    parts = [
        f"{counts['W']} situations of W and {counts['Q']} of Q as they are after 20 ms of rest. "
        f"The referee complains of {complaints(found)} catches."
    ]
    for what, title in WHAT.items():
        parts += [f"## Fronts and fallbacks: {title}", shares(made, what)]
    for what, title in WHAT.items():
        parts += [f"## Worth of the learned front: {title}", worth(made, what)]
    parts += ["## Processor time of hybrids: median, 90 %", latencies(made)]
    return "\n\n".join(parts) + "\n"


def _cells(made: dict[tuple[str, str], Hybrid], title: str, cell: object) -> str:
    """Return a table of all fronts before all fallbacks."""
    behind = list(dict.fromkeys(b for _, b in made))
    rows = [
        [front, *(cell(made[front, b]) for b in behind)]  # type: ignore[operator]
        for front in dict.fromkeys(f for f, _ in made)
    ]
    return table([title, *behind], rows)


def shares(made: dict[tuple[str, str], Hybrid], what: str) -> str:
    """Return every front before every fallback [%]."""

    def cell(one: Hybrid) -> str:
        caught = getattr(one, what)
        return percent(wilson(int(caught.sum()), len(caught)))

    return _cells(made, "front", cell)


def latencies(made: dict[tuple[str, str], Hybrid]) -> str:
    """Return processor times of hybrids [ms]."""
    return _cells(
        made, "front, ms", lambda one: f"{np.median(one.ms):.1f}, {np.quantile(one.ms, 0.9):.1f}"
    )


def worth(made: dict[tuple[str, str], Hybrid], what: str) -> str:
    """Compare the learned front with the others before the same fallback; Holm over the table."""
    head = [
        "fallback", "learned before it, less", "points", "only learned", "only the other", "p",
        "p (Holm)",
    ]  # fmt: skip
    rows, chances = [], []
    for front, fallback in sorted(made, key=lambda pair: pair[1]):
        if front == "learned":
            continue
        mine, other = made["learned", fallback], made[front, fallback]
        first, second = getattr(mine, what), getattr(other, what)
        more, less, p = mcnemar(first, second)
        gap = points(difference(first, second, mine.family))
        rows.append([fallback, front, gap, str(more), str(less)])
        chances.append(p)
    both = zip(rows, chances, holm(chances), strict=True)
    return table(head, [[*row, chance(p), chance(q)] for row, p, q in both])
