"""The comparison itself: every method on every situation, on all cores."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache, partial
from typing import Any

from gcm_learn.arms import PLANAR, Kind, kind_of
from gcm_learn.evaluation.crew import Rows, rows_of
from gcm_learn.evaluation.kinds import CONTESTS
from gcm_learn.evaluation.methods import Method, Result, get_method
from gcm_learn.evaluation.movements import NAMES
from gcm_learn.evaluation.suites import Entry
from gcm_learn.evaluation.table import Results
from gcm_learn.evaluation.thinking import charged
from gcm_learn.situation import AnySituation, planar

DELAYS = (0.0, 0.02, 0.05, 0.1, 0.2)  # thinking that is charged [s]
_CHUNK = 10  # situations that a process takes at once


def compare(
    names: Sequence[str],
    entries: Sequence[Entry],
    *,
    charge: int = 100,
    workers: int | None = None,
    cluster: str | None = None,
    progress: Callable[[int], object] = lambda count: None,
) -> Results:
    """Let methods answer the same situations.

    Parameters
    ----------
    names : sequence of str
        See `methods.get_method`.
    entries : sequence of Entry
    charge : int
        Situations of each stratum for which charged thinking is measured.
    workers, cluster
        See `processes.crew_of`.  Thinking takes the time that it takes there.
    progress : callable
        Told how many answers are new.

    Returns
    -------
    Results
        Ordered by method and situation.
    """
    for name in names:  # refused here rather than in a process
        check_arms(name, entries)
    marked = zip(entries, _marked(entries, charge), strict=True)
    ordered = sorted(marked, key=lambda pair: (pair[0].suite, pair[0].index))
    calls = [
        partial(_answers, name, ordered[first : first + _CHUNK])
        for name in names
        for first in range(0, len(ordered), _CHUNK)
    ]
    return Results.of(rows_of(calls, workers, cluster, progress))


def check_arms(name: str, entries: Sequence[Entry]) -> None:
    """Refuse unknown methods, and methods that do not take all of the arms.

    Raises
    ------
    UnknownNameError, ArmKindError
    """
    method = get_method(name)
    for entry in entries:
        if not method.takes(kind_of(entry.situation)):
            planar(entry.situation, f"policy {name!r}")


def _marked(entries: Sequence[Entry], charge: int) -> list[bool]:
    """The first `charge` of each stratum."""
    seen: dict[str, int] = {}
    marks = []
    for entry in entries:
        seen[entry.stratum] = seen.get(entry.stratum, 0) + 1
        marks.append(seen[entry.stratum] <= charge)
    return marks


@lru_cache(maxsize=32)
def warmed(name: str, kind: Kind = PLANAR) -> Method:
    """Return a method that has answered a few times, so that nothing is left to compile or load."""
    from gcm_learn.families import draw

    made, example = get_method(name), CONTESTS.of(kind).example
    if example is not None:
        for k in range(3):
            made.run(draw(example, 3, k))
    return made


def _answers(name: str, entries: Sequence[tuple[Entry, bool]]) -> Rows:
    """A method's rows for some situations, and whether its thinking is charged there."""
    kinds = [kind_of(entry.situation) for entry, _ in entries]
    for kind in dict.fromkeys(kinds):
        if CONTESTS.of(kind).example is None:
            warmed(name, kind).run(entries[kinds.index(kind)][0].situation)
    return [
        row_of(warmed(name, kind), e, charge)
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
        "latency_ms": result.latency,
        **dict.fromkeys(NAMES),
        **_movement(situation, result),
    }
    for delay in DELAYS:
        key = f"charged_{round(1e3 * delay)}"
        row[key] = None
        if charge:
            row[key] = result.outcome if delay == 0.0 else charged(made, situation, delay)
    row["charged_own"] = None
    if charge:
        row["charged_own"] = charged(made, situation, 1e-3 * result.latency)
    return row


def _movement(situation: AnySituation, result: Result) -> dict[str, Any]:
    path = result.trajectory
    return {} if path is None else CONTESTS.of(situation).movement(situation, result, path)
