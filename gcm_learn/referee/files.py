"""Situations and solutions in files."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from gcm_learn.referee.complaints import Complaint, Unreadable
from gcm_learn.referee.judging import judge
from gcm_learn.referee.kinds import checked

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
