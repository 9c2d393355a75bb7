"""The comparison itself: every method on every situation, on all cores."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache, partial
from typing import Any

from gcm_learn.arms import PLANAR, Kind, kind_of
from gcm_learn.evaluation.entrants import Entrant, Rows, entrants_of, is_alone, rows_of
from gcm_learn.evaluation.kinds import CONTESTS, charged
from gcm_learn.evaluation.methods import Method, Result
from gcm_learn.evaluation.movements import NAMES
from gcm_learn.evaluation.suites import Entry
from gcm_learn.evaluation.table import Results
from gcm_learn.planners import LIMIT
from gcm_learn.situation import AnySituation, planar

DELAYS = (0.0, 0.02, 0.05, 0.1, 0.2)  # thinking that is charged [s]
_CHUNK = 10  # situations that a process takes at once


def compare(
    methods: Sequence[str | Any],
    entries: Sequence[Entry],
    *,
    charge: int = 100,
    limit: float | None = LIMIT,
    workers: int | None = None,
    cluster: str | None = None,
    progress: Callable[[int], object] = lambda count: None,
) -> Results:
    """Let methods answer the same situations.

    Parameters
    ----------
    methods : sequence of str or object
        Names, references or objects, see `methods.get_method`.  Of two with one name the second
        gets a number.
    entries : sequence of Entry
    charge : int
        Situations of each stratum for which charged thinking is measured.
    limit : float, optional
        Time on the wall for each answer of a method from outside [s]; one that takes longer is an
        error, see `processes.time_limit`.
    workers, cluster
        See `processes.crew_of`.  Thinking takes the time that it takes there.
    progress : callable
        Told how many answers are new.

    Returns
    -------
    Results
        Ordered by method and situation.
    """
    calls_in_all = len(methods) * -(-len(entries) // _CHUNK)
    alone = is_alone(calls_in_all, workers, cluster)
    entrants = entrants_of(methods, limit, alone=alone)
    for entrant in entrants:  # refused here rather than in a process
        check_arms(entrant, entries)
    marked = zip(entries, _marked(entries, charge), strict=True)
    ordered = sorted(marked, key=lambda pair: (pair[0].suite, pair[0].index))
    calls = [
        partial(_answers, entrant, ordered[first : first + _CHUNK])
        for entrant in entrants
        for first in range(0, len(ordered), _CHUNK)
    ]
    rows = rows_of(calls, workers, cluster, progress)
    named = zip(entrants, methods, strict=True)
    return replace(Results.of(rows), given={e.name: m for e, m in named if e.name != m})


def check_arms(entrant: Entrant, entries: Sequence[Entry]) -> None:
    """Refuse unknown methods, and methods that do not take all of the arms.

    Raises
    ------
    UnknownNameError, ArmKindError
    """
    method = entrant.method()
    for entry in entries:
        if not method.takes(kind_of(entry.situation)):
            planar(entry.situation, f"policy {entrant.name!r}")


def _marked(entries: Sequence[Entry], charge: int) -> list[bool]:
    """The first `charge` of each stratum."""
    seen: dict[str, int] = {}
    marks = []
    for entry in entries:
        seen[entry.stratum] = seen.get(entry.stratum, 0) + 1
        marks.append(seen[entry.stratum] <= charge)
    return marks


@lru_cache(maxsize=32)
def warmed(entrant: Entrant, kind: Kind = PLANAR) -> Method:
    """Return a method that has answered a few times, so that nothing is left to compile or load."""
    from gcm_learn.families import draw

    made, example = entrant.method(), CONTESTS.of(kind).example
    if example is not None:
        for k in range(3):
            if made.run(draw(example, 3, k)).outcome == "error":
                break
    return made


def _answers(entrant: Entrant, entries: Sequence[tuple[Entry, bool]]) -> Rows:
    """A method's rows for some situations, and whether its thinking is charged there."""
    kinds = [kind_of(entry.situation) for entry, _ in entries]
    for kind in dict.fromkeys(kinds):
        if CONTESTS.of(kind).example is None:
            warmed(entrant, kind).run(entries[kinds.index(kind)][0].situation)
    return [
        row_of(warmed(entrant, kind), e, charge)
        for kind, (e, charge) in zip(kinds, entries, strict=True)
    ]


def row_of(made: Method, entry: Entry, charge: bool) -> dict[str, Any]:
    """One answer, with everything that is measured of it."""
    situation = entry.situation
    result = made.run(situation)
    row: dict[str, Any] = {
        "suite": entry.suite,
        "index": entry.index,
        "family": entry.family,
        "stratum": entry.stratum,
        "earliest": entry.earliest,
        "entrant": made.name,
        "outcome": result.outcome,
        "reason": result.reason or None,
        "latency_ms": result.latency,
        **dict.fromkeys(NAMES),
        **_movement(situation, result),
    }
    for delay in DELAYS:
        key = f"charged_{round(1e3 * delay)}"
        row[key] = None
        if charge:
            row[key] = result.outcome if delay == 0.0 else _charged(made, situation, delay, result)
    row["charged_own"] = None
    if charge:
        row["charged_own"] = _charged(made, situation, 1e-3 * result.latency, result)
    return row


def _charged(made: Method, situation: AnySituation, delay: float, result: Result) -> str | None:
    """Return the outcome after some thinking; a method that failed is not asked again."""
    return "error" if result.outcome == "error" else charged(made, situation, delay)


def _movement(situation: AnySituation, result: Result) -> dict[str, Any]:
    path = result.trajectory
    return {} if path is None else CONTESTS.of(situation).movement(situation, result, path)
