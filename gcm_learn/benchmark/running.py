"""The protocol: each situation once and in order, after a warm-up that is not counted."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from gcm_learn import __version__
from gcm_learn.benchmark.cases import Case, Loaded, load_suite
from gcm_learn.benchmark.judging import ERROR, judged
from gcm_learn.benchmark.machine import REFERENCE_MS, factor_of, machine, passes, spent
from gcm_learn.benchmark.results import FORMAT, PROTOCOL, check_answer
from gcm_learn.errors import SuiteError
from gcm_learn.planners import (
    FAULTS,
    LIMIT,
    Planner,
    get_planner,
    in_words,
    name_of,
    plan_to_json,
    plan_with,
    source_of,
    taken,
)
from gcm_learn.processes import OutOfTime, time_limit


def run(
    method: Any,
    suites: Sequence[str | Loaded] = ("plane",),
    *,
    name: str = "",
    limit: float = LIMIT,
    part: Path | None = None,
    progress: Callable[[int], object] = lambda count: None,
) -> dict[str, Any]:
    """Ask a method about all situations of some suites.

    Parameters
    ----------
    method : str or object
        Anything that `get_planner` takes.
    suites : sequence of str or Loaded
        Names, or files of situations.
    name : str, optional
        Name of the method in results; by default what was given, or the object's name.
    limit : float
        Time on the wall for each answer [s]; one that takes longer is an error.
    part : Path, optional
        File of answers that are there already; new ones are added to it. It is begun anew if it is
        of another method, suite, limit, version or machine, or if the method's file has changed.
    progress : callable
        Told how many answers are new.

    Returns
    -------
    dict
        Values of a result file; `write_result` writes them.

    Raises
    ------
    UnknownNameError, SuiteError, ArmKindError
        Before anything is asked.
    """
    named = name or (method if isinstance(method, str) else name_of(method))
    planner = get_planner(method, name=named, limit=limit)
    loaded = [load_suite(suite) if isinstance(suite, str) else suite for suite in suites]
    if len({suite.name for suite in loaded}) < len(loaded):
        raise SuiteError(f"suites: two have one name ({', '.join(s.name for s in loaded)})")
    for suite in loaded:
        for case in suite.cases:
            taken(planner, case.item.situation)
    head = {
        "method": named, "source": source_of(method), "suites": [s.sha256 for s in loaded],
        "limit": limit, "package": __version__, "protocol": PROTOCOL, "machine": dict(machine()),
    }  # fmt: skip
    kept = Kept(part, head)
    kept.add({"passes": passes()})
    for suite in loaded:
        for answer in _answers(planner, suite, limit, kept.of(suite)):
            kept.add({"sha256": suite.sha256, "answer": answer})
            progress(1)
    kept.add({"passes": passes()})
    return _result(named, loaded, limit, kept)


class Kept:
    """Answers and calibrations, each also added to a file from which a run goes on.

    Parameters
    ----------
    path : Path, optional
    head : mapping
        First line of the file; a file with another one is begun anew.
    """

    def __init__(self, path: Path | None, head: Mapping[str, Any]) -> None:
        self._path = path
        self.lines: list[dict[str, Any]] = []
        if path is None:
            return
        found = _whole_lines(path)
        if found[:1] == [head]:
            self.lines = found[1:]
        told = [head, *self.lines]
        path.write_text("".join(json.dumps(line) + "\n" for line in told), "utf-8")

    def add(self, line: dict[str, Any]) -> None:
        """Keep a line."""
        self.lines.append(line)
        if self._path is not None:
            with self._path.open("a", encoding="utf-8") as stream:
                stream.write(json.dumps(line) + "\n")

    def of(self, suite: Loaded) -> list[dict[str, Any]]:
        """Return the answers of a suite."""
        return [line["answer"] for line in self.lines if line.get("sha256") == suite.sha256]

    @property
    def passes(self) -> list[float]:
        """All passes of calibration [ms]."""
        return [one for line in self.lines for one in line.get("passes", [])]


def _whole_lines(path: Path) -> list[dict[str, Any]]:
    """Return the lines of a file up to one that is damaged or was not written to its end."""
    found: list[dict[str, Any]] = []
    if path.exists():
        for text in path.read_text("utf-8", errors="replace").splitlines():
            try:
                line = json.loads(text)
                _check_line(line, bool(found))
            except ValueError:
                break
            found.append(line)
    return found


def _check_line(line: Any, after_head: bool) -> None:
    """Raise ValueError if a line is none of the head, passes of calibration or an answer."""
    if not isinstance(line, dict):
        raise ValueError("no object")
    if not after_head:
        return
    passes = line.get("passes", [])
    if not isinstance(passes, list) or not all(isinstance(one, float) for one in passes):
        raise ValueError("passes")
    if "passes" not in line:
        check_answer(line.get("answer"))


def _answers(
    planner: Planner, suite: Loaded, limit: float, done: Sequence[Mapping[str, Any]]
) -> Iterator[dict[str, Any]]:
    """Yield the answers that are missing."""
    if len(done) < len(suite.cases):
        _asked(planner, suite.warm_up, limit)
    for case in suite.cases[len(done) :]:
        answer = _asked(planner, case, limit)
        yield answer | {"complaints": list(judged(case, answer).complaints)}


def _asked(planner: Planner, case: Case, limit: float) -> dict[str, Any]:
    """Return an answer and the processor time that it took, as JSON has them."""
    situation, since = case.item.situation, spent()
    plan, message = None, ""
    try:
        with time_limit(limit):
            plan = plan_with(planner, situation)
    except OutOfTime:
        message = f"no answer within {limit:g} s"
    except Exception as error:
        message = in_words(error)
    answer: dict[str, Any] = {"name": case.name, "ms": round(1e3 * (spent() - since), 3)}
    if plan is not None:
        try:
            values = plan_to_json(plan, situation)
            solution = json.loads(json.dumps(values, allow_nan=False))
            fault = plan.status if plan.status in FAULTS else ""
            told = {"nodes": plan.nodes, "fault": fault, "message": plan.message}
            return answer | told | {"solution": solution}
        except (TypeError, ValueError) as error:
            message = f"the solution is not JSON: {error}"
    return answer | {"nodes": 0, "fault": ERROR, "message": message, "solution": {}}


def _result(method: str, suites: Sequence[Loaded], limit: float, kept: Kept) -> dict[str, Any]:
    runs = [
        {"suite": s.name, "version": s.version, "sha256": s.sha256, "answers": kept.of(s)}
        for s in suites
    ]
    measured = kept.passes
    calibration = {
        "passes_ms": measured,
        "reference_ms": REFERENCE_MS,
        "factor": factor_of(measured),
    }
    return {
        "format": FORMAT,
        "method": method,
        "protocol": PROTOCOL,
        "package": __version__,
        "machine": dict(machine()),
        "calibration": calibration,
        "limit_s": limit,
        "runs": runs,
    }
