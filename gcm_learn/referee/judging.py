"""The verdict on one solution, and on files of them."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from gcm_learn.referee import form
from gcm_learn.referee.contact import Nearest, nearest_obstacle, overlap
from gcm_learn.referee.joint_arms import Models
from gcm_learn.referee.kinds import Arm, Columns, arm_of, checked, version_of
from gcm_learn.referee.motions import Body, bodies_of
from gcm_learn.referee.tolerances import WORK, WORK_BROKEN, Complaint, Unreadable

EXACT = 4.0
"""Share of the clearance's tolerance by which the referee's own may be too large, inverted."""


class Verdict(NamedTuple):
    """Complaints, and the clearance that the referee found."""

    complaints: list[Complaint]
    clearance: float | None
    """Least distance of the arm to obstacles over the movement; None without any, or unexamined."""


def judge(
    situation: Mapping[str, Any], solution: Mapping[str, Any], models: Models | None = None
) -> list[Complaint]:
    """Return all promises of the exchange contract that a solution breaks.

    Parameters
    ----------
    situation : mapping
        Object of the format ``gcm-learn/situation@1``, ``@2`` or ``@3``.
    solution : mapping
        Its answer, of the format ``gcm-learn/solution`` of the same version.
    models : mapping, optional
        Objects of arm files, by what situations call them; others are those that ship.

    Raises
    ------
    Unreadable
        If the situation is not of its format.
    """
    return examine(situation, solution, models).complaints


def examine(
    situation: Mapping[str, Any], solution: Mapping[str, Any], models: Models | None = None
) -> Verdict:
    """Return complaints as `judge` does, and the clearance of the movement."""
    arm, version = arm_of(situation, models or {}), version_of(situation)
    name = situation.get("name", "")
    bodies = bodies_of(situation["bodies"], _end(solution, situation["horizon"]))
    verdict = _verdict(situation, solution, version, arm, bodies)
    return Verdict([replace(c, name=name) for c in verdict.complaints], verdict.clearance)


def _end(solution: Any, horizon: float) -> float:
    """Return the time until which the motion of bodies is needed."""
    given: Any = solution.get("catch_time") if isinstance(solution, Mapping) else None
    return min(float(given), horizon) if form.is_number(given) else 0.0


def _verdict(
    situation: Mapping[str, Any],
    solution: Mapping[str, Any],
    version: int,
    arm: Arm,
    bodies: list[Body],
) -> Verdict:
    complaints = form.fields(solution, situation.get("name", ""), version)
    if complaints:
        return Verdict(complaints, None)
    if solution["status"] != "caught":
        return Verdict(_start(arm, bodies, solution["status"]), None)
    columns, complaints = form.columns_of(solution["trajectory"], arm.columns)
    catches, more = form.catches_of(solution)
    complaints += more
    if columns and not complaints:
        complaints += form.times(columns["time"], version)
        complaints += form.catch_complaints(situation, catches, columns["time"])
    if complaints:
        return Verdict(complaints, None)
    complaints = arm.complaints(columns)
    for catch in catches:
        body = next(b for b in bodies if b.name == catch.body and b.role == "target")
        words = arm.missed(columns, body, catch.time)
        complaints += [Complaint("catch_body", what, catch.time) for what in words]
    work = WORK_BROKEN if complaints else WORK
    found, more = _contacts(arm, bodies, columns, solution["clearance"], work)
    return Verdict([*complaints, *more], found)


def _floor(arm: Arm) -> float:
    """Return the signed distance below which parts are in contact."""
    return -max(arm.granted.touch * arm.size, arm.granted.touch_absolute)


def _start(arm: Arm, bodies: list[Body], status: str) -> list[Complaint]:
    """Return complaints about an answer without a catch: the start is blocked or it is not."""
    motion, hair = arm.resting(), arm.granted.blocked
    outside = nearest_obstacle(motion, bodies, arm.ignored, -math.inf, 0.0)
    itself = overlap(motion, hair)
    free = min(outside.gap, itself.gap)
    if status == "start_blocked" and free > hair:
        return [Complaint("status", f"is start_blocked, {free:g} away from contact", 0.0)]
    if status != "start_blocked" and free < -hair:
        return [Complaint("status", f"is {status}, but the start is blocked, {-free:g} deep", 0.0)]
    return []


def _contacts(
    arm: Arm, bodies: list[Body], columns: Columns, reported: Any, work: int
) -> tuple[float | None, list[Complaint]]:
    """Return the clearance, and complaints about contacts and about the reported clearance."""
    complaints: list[Complaint] = []
    close = arm.granted.clearance * arm.size
    nearest = Nearest()
    for k, motion in enumerate(arm.readings(columns)):
        error = math.inf if k else close / EXACT
        found = nearest_obstacle(motion, bodies, arm.ignored, _floor(arm), error, work)
        nearest = nearest if k else found
        for each in (found, overlap(motion, _floor(arm), work)):
            if not each.settled:
                complaints.append(Complaint("trajectory", "contact cannot be decided"))
            elif each.gap < _floor(arm):
                what = f"{each.what} touch, {-each.gap:g} deep"
                complaints.append(Complaint("trajectory", what, each.at))
        if complaints:
            break
    free = None if math.isinf(nearest.gap) else nearest.gap
    most = close if arm.granted.compares_clearance else math.inf
    return free, complaints or _clearance(free, reported, most)


def _clearance(free: float | None, reported: Any, close: float) -> list[Complaint]:
    if free is None:
        return [] if reported is None else [Complaint("clearance", "is given without obstacles")]
    if not form.is_number(reported):
        return [Complaint("clearance", "is not a finite number")]
    if abs(reported - free) <= close:
        return []
    return [Complaint("clearance", f"is {reported:g}, found {free:g}")]


Place = tuple[str, dict[str, Any]]


def read(path: Path) -> list[Place]:
    """Return the objects of a file, each with the place where it stands.

    A `.json` file holds one object, a `.jsonl` file one in each line that is not blank, and files
    of other names either.
    """
    try:
        text = path.read_bytes().decode("utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise Unreadable(f"{path}: {getattr(error, 'strerror', None) or error}") from error
    lines = enumerate(text.split("\n"), start=1)  # other breaks may stand in a name
    filled = [(f"{path}:{k}", line) for k, line in lines if line.strip(" \t\r")]
    kind = path.suffix.lower()
    try:
        whole = [] if kind == ".jsonl" else [(str(path), _object(text, str(path)))]
    except Unreadable:
        if kind == ".json" or len(filled) < 2:
            raise
        whole = []
    return whole or [(place, _object(line, place)) for place, line in filled]


def _object(text: str, place: str) -> dict[str, Any]:
    try:
        given = json.loads(text, object_pairs_hook=_single, parse_int=_integer)
    except (ValueError, RecursionError) as error:
        raise Unreadable(f"{place}: is not JSON: {error}") from error
    if not isinstance(given, dict):
        raise Unreadable(f"{place}: is not an object")
    inner = given.get("situation")  # lines of suites
    return inner if isinstance(inner, dict) and "arm" not in given else given


def _integer(digits: str) -> int | float:
    """Read an integer; Python refuses to convert very long ones."""
    return int(digits) if len(digits) <= 400 else float(digits)


def _single(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Return an object whose fields are each there once."""
    made = dict(pairs)
    if len(made) < len(pairs):
        raise ValueError("a field is there twice")
    return made


def models_of(situation: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Return the arm file to which a situation gives a path, relative to a folder."""
    arm = situation.get("arm")
    name = arm.get("model") if isinstance(arm, Mapping) else None
    if not isinstance(name, str) or not name.endswith(".json"):
        return {}
    return {name: read(folder / name)[0][1]}


def judge_files(situations: Path, solutions: Path) -> tuple[int, Iterator[list[Complaint]]]:
    """Return the number of situations, and an iterator over the complaints of each.

    The last list has the complaints about answers to no situation.

    Raises
    ------
    Unreadable
        If a file cannot be judged, also while iterating.
    """
    asked, answers = read(situations), read(solutions)
    names = [str(situation.get("name", "")) for _, situation in asked]
    if len(set(names)) < len(names):
        twice = next(name for k, name in enumerate(names) if name in names[:k])
        raise Unreadable(f'{situations}: name: "{twice}" is there twice')
    by_name: dict[str, list[Any]] = {}
    for _, answer in answers:
        by_name.setdefault(str(answer.get("name", "")), []).append(answer)
    return len(asked), _verdicts(asked, by_name, situations.parent)


def _verdicts(
    asked: list[Place], answers: dict[str, list[Any]], folder: Path
) -> Iterator[list[Complaint]]:
    for place, situation in asked:
        try:
            checked(situation)
            name = str(situation.get("name", ""))
            given = answers.pop(name, [])
            if len(given) == 1:
                yield judge(situation, given[0], models_of(situation, folder))
            else:
                what = f"has {len(given)} answers" if given else "has no answer"
                yield [Complaint("name", what, name=name)]
        except Unreadable as error:
            raise Unreadable(f"{place}: {error}") from error
    yield [
        Complaint("name", "is not the name of a situation", name=name)
        for name, given in answers.items()
        for _ in given
    ]
