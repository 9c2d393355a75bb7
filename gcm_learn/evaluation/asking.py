"""Asking: every entrant about every case under every condition, resumed after Ctrl-C."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

from gcm_learn import __version__
from gcm_learn.arms import kind_of
from gcm_learn.errors import SuiteError
from gcm_learn.evaluation.conditions import OWN, Condition, after, check
from gcm_learn.evaluation.entrants import Answer, Entrant, asked, entrants_of, method_of, summary
from gcm_learn.evaluation.judging import judged
from gcm_learn.evaluation.machine import REFERENCE_MS, factor_of, machine, passes
from gcm_learn.evaluation.noise import mind_of, seen
from gcm_learn.evaluation.sheet import OUTCOMES, PROTOCOL, Sheet
from gcm_learn.evaluation.sources import WARM_UP, Case, cases_of
from gcm_learn.processes import Crew, Here
from gcm_learn.situation import situation_to_json

JOURNAL = "answers.jsonl"
WARM_UPS = 3  # cases that an entrant is asked in a process before all others
Row = dict[str, Any]
_WARM: set[tuple[Entrant, str]] = set()
"""Entrants that have answered in this process, with the kinds of arms."""


class CaseQuestion(NamedTuple):
    """A case, the entrants and conditions to ask, and warm-up cases of its kind of arm."""

    case: Case
    asked: tuple[tuple[Entrant, tuple[Condition, ...]], ...]
    warm_ups: tuple[Case, ...]


def ask(
    entrants: Sequence[Any],
    cases: Any,
    conditions: Sequence[Condition] = (Condition(),),
    *,
    keep: str | Path | None = None,
    crew: Crew | None = None,
    progress: Callable[[int], object] = lambda rows: None,
) -> Sheet:
    """Let entrants answer the same cases under the same conditions; the referee judges.

    Parameters
    ----------
    entrants : sequence of Entrant, str or object
        Planners by name, ``recall@DIR`` with a memory, actors (``clone``, ``clone@20``), ``.zip``
        files of Stable-Baselines3, ``mine.py:Mine``, ``module:name``, or objects.
    cases : sequence of Case or Situation, or str
        See `cases`; a file, suite or family by its name is taken whole.
    conditions : sequence of Condition
    keep : path-like, optional
        Folder in which answers are kept as they come. The same call goes on from there after
        Ctrl-C, and asks nothing again that was answered by the same version on the same machine.
    crew : Crew, optional
        Processes that do the work; by default this one.
    progress : callable
        Called with the number of new rows.

    Returns
    -------
    Sheet
        Rows in the order of cases, entrants and conditions.

    Raises
    ------
    UnknownNameError, SuiteError, ArmKindError
        Before anything is asked.
    """
    found = cases_of(cases)
    counted = [case for case in found if case.stratum != WARM_UP]
    who = entrants_of(entrants, alone=crew is None or isinstance(crew, Here))
    for condition in conditions:
        check(condition)
    for entrant in who:
        _check(entrant, counted, conditions)
    journal = Journal(None if keep is None else Path(keep))
    left = list(_questions(found, counted, who, conditions, journal))
    if left:
        journal.add({"passes": passes()})
        for rows in (crew or Here()).map(answers, left):
            for row in rows:
                journal.add(row)
            progress(len(rows))
        journal.add({"passes": passes()})
    return _sheet(counted, who, conditions, journal)


def asked_for(entrants: int, cases: Sequence[Case], conditions: int) -> int:
    """Return the number of rows of a sheet."""
    return entrants * conditions * sum(case.stratum != WARM_UP for case in cases)


def _check(entrant: Entrant, counted: Sequence[Case], conditions: Sequence[Condition]) -> None:
    """Raise an error for an entrant that does not take the arms, or the conditions."""
    method = method_of(entrant, conditions[0].limit)
    for case in {kind_of(case.situation).name: case for case in counted}.values():
        method.check(case.situation)
        if any(condition.noise for condition in conditions):
            mind_of(method)


def _questions(
    found: Sequence[Case],
    counted: Sequence[Case],
    who: Sequence[Entrant],
    conditions: Sequence[Condition],
    journal: Journal,
) -> Iterator[CaseQuestion]:
    """Yield the questions whose rows the journal lacks; each case begins with another entrant."""
    first: dict[str, list[Case]] = {}
    for case in sorted(found, key=lambda case: case.stratum != WARM_UP):
        first.setdefault(kind_of(case.situation).name, []).append(case)
    for number, case in enumerate(counted):
        turn = number % max(len(who), 1)
        missing = []
        for entrant in (*who[turn:], *who[:turn]):
            lacks = [c for c in conditions if row_key(entrant, case, c) not in journal.rows]
            if lacks:
                missing.append((entrant, tuple(lacks)))
        if missing:
            warm_ups = first[kind_of(case.situation).name][:WARM_UPS]
            yield CaseQuestion(case, tuple(missing), tuple(warm_ups))


def answers(question: CaseQuestion) -> list[Row]:
    """Return the rows of a question, answered by this process."""
    rows: list[Row] = []
    for entrant, conditions in question.asked:
        key = entrant, kind_of(question.case.situation).name
        method, limit = method_of(entrant, conditions[0].limit), conditions[0].limit
        for warm in question.warm_ups if key not in _WARM else ():
            if asked(method, warm.situation, limit).outcome == "error":
                break
        _WARM.add(key)
        rows += _under(entrant, question.case, conditions)
    return rows


def _under(entrant: Entrant, case: Case, conditions: Sequence[Condition]) -> Iterator[Row]:
    """Yield an entrant's rows of a case; an error without thinking is copied to thinking times."""
    plain: dict[float, tuple[Answer, Row]] = {}
    for condition in sorted(conditions, key=lambda c: (c.noise, c.thinking != 0.0)):
        method = method_of(entrant, condition.limit)
        row: Row = {"key": row_key(entrant, case, condition)}
        if condition.noise > 0.0:
            yield row | seen(method, case, condition)
            continue
        needs = condition.thinking in (OWN, 0.0)
        if needs and condition.limit not in plain:
            answer = asked(method, case.situation, condition.limit)
            plain[condition.limit] = answer, judged(answer, case.situation, json.loads(case.text))
        if condition.thinking == 0.0:
            yield row | {"charged": 0.0} | plain[condition.limit][1]
            continue
        first = plain.get(condition.limit)
        own = 1e-3 * first[0].ms if first is not None else 0.0
        charged = own if condition.thinking == OWN else float(condition.thinking)
        row["charged"] = charged
        if first is not None and first[0].outcome == "error":
            yield row | first[1]
            continue
        moved = after(case.situation, charged)
        if isinstance(moved, str):
            yield row | {"outcome": moved, "ms": 0.0}
            continue
        answer = asked(method, moved, condition.limit)
        there = judged(answer, moved, situation_to_json(moved))
        gone = len(case.situation.targets) - len(moved.targets)
        yield row | there | {"targets": there.get("targets", 0) + gone}


def row_key(entrant: Entrant, case: Case, condition: Condition) -> str:
    """Return the text that tells a row of the journal from all others."""
    return json.dumps([entrant.name, entrant.known, entrant.seed, case.suite, case.key, *condition])


class Journal:
    """Rows and calibrations, each also added to a file from which `ask` goes on.

    Parameters
    ----------
    folder : Path, optional
        Its file is begun anew if another version or machine has written it.
    """

    def __init__(self, folder: Path | None) -> None:
        self.rows: dict[str, Row] = {}
        self.passes: list[float] = []
        self._path = None if folder is None else folder / JOURNAL
        if self._path is None:
            return
        self._path.parent.mkdir(parents=True, exist_ok=True)
        head = {"package": __version__, "protocol": PROTOCOL, "machine": dict(machine())}
        kept = _whole_lines(self._path)
        lines = kept if kept[:1] == [head] else [head]
        self._path.write_text("".join(json.dumps(line) + "\n" for line in lines), "utf-8")
        for line in lines[1:]:
            self._take(line)

    def add(self, line: Mapping[str, Any]) -> None:
        """Keep a row, or passes of calibration."""
        self._take(line)
        if self._path is not None:
            with self._path.open("a", encoding="utf-8") as stream:
                stream.write(json.dumps(line) + "\n")

    def _take(self, line: Mapping[str, Any]) -> None:
        if "passes" in line:
            self.passes += line["passes"]
        else:
            self.rows[line["key"]] = dict(line)


def _whole_lines(path: Path) -> list[Row]:
    """Return the lines of a file before the first damaged or incomplete line."""
    found: list[Row] = []
    if path.exists():
        for text in path.read_text("utf-8", errors="replace").splitlines():
            try:
                line = json.loads(text)
                _check_line(line, bool(found))
            except (ValueError, TypeError, KeyError):
                break
            found.append(line)
    return found


def _check_line(line: Any, after_head: bool) -> None:
    """Raise an error if a line is none of the head, passes of calibration or a row."""
    if not isinstance(line, dict):
        raise ValueError("no object")
    if after_head and "passes" in line:
        if not all(isinstance(one, float) for one in line["passes"]):
            raise ValueError("passes")
    elif after_head and (
        line["outcome"] not in OUTCOMES or not isinstance(line["key"], str) or line["ms"] < 0.0
    ):
        raise ValueError("row")


def _sheet(
    counted: Sequence[Case],
    who: Sequence[Entrant],
    conditions: Sequence[Condition],
    journal: Journal,
) -> Sheet:
    """Return the rows that were asked for, whole."""
    factor = factor_of(journal.passes) if journal.passes else 1.0
    rows = []
    for case, entrant, condition in product(counted, who, conditions):
        known = journal.rows[row_key(entrant, case, condition)]
        rows.append(known | _about(case) | {
            "entrant": entrant.name, "seed": entrant.seed, "thinking": condition.told,
            "noise": condition.noise, "limit": condition.limit, "factor": factor,
        })  # fmt: skip
    if not rows:
        raise SuiteError("nothing is asked: cases, entrants and conditions need one each")
    calibration = {"passes_ms": journal.passes, "reference_ms": REFERENCE_MS, "factor": factor}
    run = {
        "entrants": [entrant.name for entrant in who], "package": __version__,
        "protocol": PROTOCOL, "machine": dict(machine()), "calibration": calibration,
    }  # fmt: skip
    return Sheet.of(rows, runs=[run], entrants={e.name: summary(e) for e in who})


def _about(case: Case) -> Row:
    """Return the columns of a case."""
    several = case.situation.catch != "any"
    return {
        "suite": case.suite, "name": case.situation.name, "key": case.key, "family": case.family,
        "stratum": case.stratum, "earliest": case.earliest, "situation": case.text,
        "wanted": len(case.situation.targets) if several else 1,
    }  # fmt: skip
