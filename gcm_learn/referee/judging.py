"""Verdicts on one solution, and on files of solutions."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

from gcm_learn.referee import form
from gcm_learn.referee.catching import catch_complaints, catches_of
from gcm_learn.referee.contact import Watched, nearest_obstacle, overlap
from gcm_learn.referee.joint_arms import Models
from gcm_learn.referee.kinds import Arm, arm_of, checked, ended, version_of
from gcm_learn.referee.motions import Body, bodies_of
from gcm_learn.referee.surface_files import inlined
from gcm_learn.referee.tolerances import AFTERWARDS, WORK, WORK_BROKEN, Complaint, Unreadable

EXACT = 4.0
"""Share of the clearance's tolerance by which the referee's own may be too large, inverted."""
MARGIN = "are nearer than the margin"


class Verdict(NamedTuple):
    """Complaints, and the clearance that the referee found."""

    complaints: list[Complaint]
    clearance: float | None
    """Least distance of the arm to obstacles over the movement; None without any, or unexamined."""


def judge(
    situation: Mapping[str, Any],
    solution: Mapping[str, Any],
    models: Models | None = None,
    end: str | None = None,
) -> list[Complaint]:
    """Return all promises of the exchange contract that a solution breaks.

    Parameters
    ----------
    situation : mapping
        Object of the format ``gcm-learn/situation@1`` to ``@4``.
    solution : mapping
        Its answer, of the format ``gcm-learn/solution`` of the same version.
    models : mapping, optional
        Objects of arm files, by what situations call them; others are those that ship.
    end : {"rest"}, optional
        Judge as if the situation, of version 2 to 4, were one of version 4 that ends so.

    Raises
    ------
    Unreadable
        If the situation is not of its format.
    """
    return examine(situation, solution, models, end).complaints


def examine(
    situation: Mapping[str, Any],
    solution: Mapping[str, Any],
    models: Models | None = None,
    end: str | None = None,
) -> Verdict:
    """Return complaints as `judge` does, and the clearance of the movement."""
    situation = ended(situation, end)
    arm, version = arm_of(situation, models or {}), version_of(situation)
    name = situation.get("name", "")
    bodies = bodies_of(situation["bodies"], _end(solution, situation["horizon"], version))
    verdict = _verdict(situation, solution, version, arm, bodies)
    return Verdict([replace(c, name=name) for c in verdict.complaints], verdict.clearance)


def _end(solution: Any, horizon: float, version: int) -> float:
    """Return the time until which the motion of bodies is needed."""
    given: Any = solution.get("catch_time") if isinstance(solution, Mapping) else None
    if version > 3 and isinstance(solution, Mapping):
        path, horizon = solution.get("trajectory"), horizon + AFTERWARDS
        times = path.get("time") if isinstance(path, Mapping) else None
        given = times[-1] if isinstance(times, list) and times else None
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
    catches, more = catches_of(solution, situation)
    complaints += more
    if columns and not complaints:
        complaints += form.times(columns["time"], version)
        catches, more = catch_complaints(situation, catches, columns["time"], version)
        complaints += more
    if complaints:
        return Verdict(complaints, None)
    complaints = arm.complaints(columns)
    watched = [Watched(motion, arm.ignored) for motion in arm.readings(columns)]
    for catch in catches:
        body = next(b for b in bodies if b.name == catch.body and b.role == "target")
        complaints += arm.missed(columns, body, catch)
        watched += arm.carried(columns, body, catch)
    work = WORK_BROKEN if complaints else WORK
    found, more = _contacts(arm, bodies, watched, solution["clearance"], work)
    return Verdict([*complaints, *more], found)


def _floor(arm: Arm) -> float:
    """Return the signed distance below which parts are in contact."""
    return -max(arm.granted.touch * arm.size, arm.granted.touch_absolute)


def _start(arm: Arm, bodies: list[Body], status: str) -> list[Complaint]:
    """Return complaints about an answer without a catch that is wrong about a blocked start."""
    motion, hair = arm.resting(), arm.granted.blocked
    outside = nearest_obstacle(motion, bodies, arm.ignored, -math.inf, 0.0, margins=True)
    itself = overlap(motion, hair)
    free = min(outside.gap, itself.gap)
    if status == "start_blocked" and free > hair:
        return [Complaint("status", f"is start_blocked, {free:g} away from contact", 0.0)]
    if status != "start_blocked" and free < -hair:
        return [Complaint("status", f"is {status}, but the start is blocked, {-free:g} deep", 0.0)]
    return []


def _contacts(
    arm: Arm, bodies: list[Body], watched: list[Watched], reported: Any, work: int
) -> tuple[float | None, list[Complaint]]:
    """Return the clearance, and complaints about contacts and about the reported clearance."""
    complaints: list[Complaint] = []
    close, floor = arm.granted.clearance * arm.size, _floor(arm)
    kept = [body for body in bodies if any(body.margin)]
    least = math.inf
    for k, (motion, ignored, carried) in enumerate(watched):
        error = close / EXACT if carried or not k else math.inf
        found = nearest_obstacle(motion, bodies, ignored, floor, error, work)
        least = min(least, found.gap) if carried or not k else least
        near = nearest_obstacle(motion, kept, ignored, floor, math.inf, work, margins=True)
        tests = ((found, "touch"), (overlap(motion, floor, work), "touch"), (near, MARGIN))
        for each, words in tests:
            if not each.settled:
                complaints.append(Complaint("trajectory", "contact cannot be decided"))
            elif each.gap < floor:
                named = each.what.replace("link 0", carried, 1) if carried else each.what
                what = f"{named} {words}, {-each.gap:g} deep"
                complaints.append(Complaint("trajectory", what, each.at))
        if complaints:
            break
    free = None if math.isinf(least) else least
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
    """Return the JSON objects of a file, each with its place: the path, or path and line.

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
    """Read an integer; very long ones become floats, as Python refuses to convert them."""
    return int(digits) if len(digits) <= 400 else float(digits)


def _single(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Return a JSON object from its pairs; refuse repeated fields."""
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


def judge_files(
    situations: Path, solutions: Path, end: str | None = None
) -> tuple[int, Iterator[list[Complaint]]]:
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
    return len(asked), _verdicts(asked, by_name, situations.parent, end)


def _verdicts(
    asked: list[Place], answers: dict[str, list[Any]], folder: Path, end: str | None
) -> Iterator[list[Complaint]]:
    for place, read_from in asked:
        try:
            situation = inlined(read_from, folder)
            name = str(situation.get("name", ""))
            given = answers.pop(name, [])
            if len(given) == 1:
                yield judge(situation, given[0], models_of(situation, folder), end)
            else:
                checked(situation)
                what = f"has {len(given)} answers" if given else "has no answer"
                yield [Complaint("name", what, name=name)]
        except Unreadable as error:
            raise Unreadable(f"{place}: {error}") from error
    yield [
        Complaint("name", "is not the name of a situation", name=name)
        for name, given in answers.items()
        for _ in given
    ]
