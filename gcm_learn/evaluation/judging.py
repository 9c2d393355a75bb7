"""Verdicts on answers, by the referee alone, and the numbers of their movements."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from gcm_learn import artifacts
from gcm_learn.arms import PLANAR, ByKind, kind_named, kind_of
from gcm_learn.errors import SuiteError
from gcm_learn.evaluation.conditions import after
from gcm_learn.evaluation.entrants import WORDS, Answer
from gcm_learn.evaluation.sheet import Sheet
from gcm_learn.evaluation.sources import cases
from gcm_learn.evaluation.suites import SHIPPED
from gcm_learn.motion import Movement, collided_part
from gcm_learn.planners import Plan, plan_to_json
from gcm_learn.referee import examine, judge
from gcm_learn.situation import AnySituation, situation_from_json, situation_to_json

CLAIMS = ("caught", "declined", "start_blocked")
"""Outcomes that the referee can judge."""
OURS = "results"  # folder among the data
_POINTS = 101  # of a path, among which an extreme one is found
_UNIT = ByKind(
    {PLANAR: lambda arm: 1.0},
    default=lambda arm: float(kind_of(arm).pack(arm, ()).length),
)
"""Length that counts as 1 in sheets, in the unit of the arm."""


def judged(answer: Answer, situation: AnySituation, given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the sheet's columns of an answer, after the referee has judged its claims.

    Parameters
    ----------
    answer : Answer
    situation : Situation
        As it was when the answer's movement begins.
    given : mapping
        The same in the exchange format.
    """
    row: dict[str, Any] = {"outcome": answer.outcome, "ms": round(answer.ms, 4)}
    row["reason"] = answer.reason
    told: list[str] = []
    for plan in answer.plans:
        try:
            solution = json.loads(json.dumps(plan_to_json(plan, situation), allow_nan=False))
        except (TypeError, ValueError) as error:
            return row | {"outcome": "error", "reason": f"the solution is not JSON: {error}"}
        if answer.outcome == "caught" and solution["clearance"] is None:
            solution["clearance"] = examine(_known(given), solution).clearance  # nobody told it
        found = complaints_of(given, solution) if answer.outcome in CLAIMS else []
        told = told or found
        row |= {"solution": json.dumps(solution, separators=(",", ":")), "nodes": plan.nodes}
        row |= numbers(situation, plan.trajectory, row["outcome"])
        if not found:
            return row | _catch(row["outcome"], solution)
    if told:
        row |= {"outcome": "broken", "reason": told[0]}
    return row


def complaints_of(given: Mapping[str, Any], solution: Mapping[str, Any]) -> list[str]:
    """Return the referee's complaints, each as a text that names a field and the fault in it."""
    return [str(replace(c, name="")).removeprefix(": ") for c in judge(_known(given), solution)]


def _known(given: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return a situation for the referee, in which an arm of an added kind becomes a chain."""
    kind = kind_named(given["arm"].get("kind", PLANAR.name))
    if kind.as_chain is None:
        return given
    asked: Any = situation_from_json(given)
    return situation_to_json(replace(asked, arm=kind.as_chain(asked.arm)))


def complaints(situation: AnySituation, plan: Plan) -> list[str]:
    """Return the complaints of the referee about a plan."""
    return complaints_of(situation_to_json(situation), plan_to_json(plan, situation))


def _catch(outcome: str, solution: Mapping[str, Any]) -> dict[str, Any]:
    """Return the columns of a catch."""
    if outcome != "caught":
        return {}
    return {
        "catch_time": solution["catch_time"],
        "clearance": solution["clearance"],
        "targets": max(len(solution.get("catches", ())), 1),
    }


def numbers(situation: AnySituation, path: Movement | None, outcome: str) -> dict[str, Any]:
    """Return the columns of a movement; lengths are in forearms, or in an arm's own unit."""
    if path is None or path.duration <= 0.0:
        return {}
    unit, time = _UNIT.of(path.arm)(path.arm), np.linspace(0.0, path.duration, _POINTS)
    steps = np.linalg.norm(np.diff(path.hand_at(time), axis=0), axis=1) / unit
    turns = np.abs(np.diff(path.joints_at(time), axis=0)).max()
    span = path.duration / (_POINTS - 1)
    made: dict[str, Any] = {
        "path": float(steps.sum()),
        "peak_hand": float(steps.max() / span),
        "peak_joint": float(turns / span),
    }
    if outcome == "touched" and kind_of(path.arm) == PLANAR:
        made["part"] = collided_part(situation, path)  # type: ignore[arg-type]
    return made


def movement_of(situation: AnySituation, solution: str) -> Movement | None:
    """Return the movement of a solution's text, or None."""
    rows = json.loads(solution).get("trajectory") if solution else None
    if rows is None:
        return None
    parts = {
        name: np.array(rows[name], float) for name in ("time", "joints", "rates") if name in rows
    }
    if kind_of(situation) == PLANAR:
        parts["path"] = np.array(rows["hand"], float)
    return Movement(situation.arm, **parts)


def judged_again(sheet: Sheet) -> Sheet:
    """Return the sheet after the referee has judged its claims again, from the sheet's columns."""
    outcomes, reasons = sheet["outcome"].copy(), sheet["reason"].copy()
    for k in np.flatnonzero(np.isin(outcomes.astype(str), CLAIMS)).tolist():
        thinking = 0.0 if sheet["noise"][k] > 0.0 else float(sheet["charged"][k])
        asked, solution = json.loads(sheet["situation"][k]), sheet["solution"][k]
        outcomes[k], reasons[k] = _verdict(asked, thinking, solution, outcomes[k])
    return replace(sheet, columns={**sheet.columns, "outcome": outcomes, "reason": reasons})


def _verdict(asked: dict[str, Any], thinking: float, text: str, told: str) -> tuple[str, str]:
    """Return the outcome of a solution, and the reason of a broken promise."""
    if thinking > 0.0:
        moved = after(situation_from_json(asked), thinking)
        if isinstance(moved, str):
            return moved, ""
        asked = situation_to_json(moved)
    if not text:
        return ("broken", "solution: is missing") if told == "caught" else (told, "")
    solution = json.loads(text)
    found = complaints_of(asked, solution)
    status = str(solution.get("status"))
    return ("broken", found[0]) if found else (WORDS.get(status, status), "")


def read_sheets(paths: Sequence[str | Path], *, ours: bool = False) -> Sheet:
    """Read sheets, and judge their answers again.

    Parameters
    ----------
    paths : sequence of path-like
        Files, or folders of them.
    ours : bool
        Add the answers of this package's methods to the same suites, or to all without `paths`.

    Raises
    ------
    FileFormatError, SuiteError
        In one line: a file is no sheet, or has other situations than a suite that ships.
    """
    parts = [_shipped_as(Sheet.load(file), file) for file in _files(paths)]
    asked = {suite for part in parts for suite in part.each("suite")}
    if ours:
        folder = artifacts.find("data", OURS)
        if folder is None:
            raise SuiteError(artifacts.missing("data", f"folder {OURS!r}"))
        known = [Sheet.load(file) for file in _files([folder])]
        parts += [part.where(suite=asked) if asked else part for part in known]
    parts = [part for part in parts if len(part)]
    if not parts:
        raise SuiteError("no sheet has an answer")
    return judged_again(Sheet.joined(*parts))


def _files(paths: Sequence[str | Path]) -> list[Path]:
    """Return sheets by their own names or in folders."""
    found: list[Path] = []
    for path in map(Path, paths):
        found += sorted(path.glob("*.parquet")) if path.is_dir() else [path]
    return found


def _shipped_as(sheet: Sheet, file: Path) -> Sheet:
    """Return the sheet with shipped suites' situations and strata replaced by the shipped ones."""
    columns = {name: column.copy() for name, column in sheet.columns.items()}
    for suite in set(sheet.each("suite")) & set(SHIPPED):
        known = {case.key: case for case in cases(suite)}
        for k in np.flatnonzero(sheet["suite"] == suite).tolist():
            case = known.get(sheet["key"][k])
            if case is None:
                raise SuiteError(f"{file}: {sheet['name'][k]!r} is not of the suite {suite!r}")
            columns["situation"][k], columns["stratum"][k] = case.text, case.stratum
    return replace(sheet, columns=columns)
