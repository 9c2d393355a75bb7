"""Situations of a suite, read from its file and checked against its hash."""

from __future__ import annotations

import gzip
import json
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from gcm_learn.benchmark.suites import OUTSIDE, SUITES, Suite, suite_file, suite_hash
from gcm_learn.errors import FileFormatError, SuiteError, UnknownNameError
from gcm_learn.referee import models_of
from gcm_learn.situation import AnySituation, read_situations, situation_to_json

WARM_UP = "warm-up"  # stratum of the situation that does not count
SUFFIX = ".jsonl"


class Item(NamedTuple):
    """A situation of a suite, and what is known about it."""

    situation: AnySituation
    family: str = ""
    stratum: str = ""
    """L, W, Q; U if no catch is possible for certain; "open" or empty if nothing is known."""


@dataclass(frozen=True)
class Case:
    """A situation that methods are asked about."""

    item: Item
    given: dict[str, Any]
    """The situation as its file has it, for the referee."""
    models: dict[str, Any]
    """Arm files that the situation names by a path, for the referee."""

    @property
    def name(self) -> str:
        """Name of the situation."""
        return self.item.situation.name


@dataclass(frozen=True)
class Loaded:
    """A suite with its situations."""

    name: str
    version: int
    """0 for a file of situations that is no suite of the package."""
    sha256: str
    warm_up: Case
    cases: tuple[Case, ...]


def load_suite(name: str) -> Loaded:
    """Return a suite by name, or any `.jsonl` file of situations.

    Raises
    ------
    UnknownNameError, SuiteError, FileFormatError
        If there is no such suite, its file has another hash, or a file cannot be read.
    """
    if name.endswith(SUFFIX):
        return _of_file(Path(name))
    if name in OUTSIDE:
        raise SuiteError(
            f"suite {name!r}: its problems are not shipped; make a file with "
            f"'{OUTSIDE[name]}' and give its name"
        )
    if name not in SUITES:
        raise UnknownNameError.among("suite", name, [*SUITES, *OUTSIDE])
    return _shipped(SUITES[name])


def suite_lines(suite: Suite, items: Iterable[Item]) -> bytes:
    """Return the content of a suite's file: a line for each situation, the warm-up first."""
    lines = [
        {
            "suite": f"{suite.name}-{suite.version}",
            "family": item.family,
            "stratum": item.stratum,
            "situation": situation_to_json(item.situation),
        }
        for item in items
    ]
    return "".join(json.dumps(line, separators=(",", ":")) + "\n" for line in lines).encode()


def _shipped(suite: Suite) -> Loaded:
    content = gzip.decompress(suite_file(suite).read_bytes())
    found = suite_hash(content)
    if found != suite.sha256:
        raise SuiteError(
            f"suite {suite.name!r}: version {suite.version} has hash {found[:16]}, "
            f"and was frozen as {suite.sha256[:16]}"
        )
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder, f"{suite.name}{SUFFIX}")
        place.write_bytes(content)
        cases = _cases(place)
    return Loaded(suite.name, suite.version, found, cases[0], tuple(cases[1:]))


def _of_file(path: Path) -> Loaded:
    """Return a file as a suite; the warm-up is its first situation unless a line is marked."""
    cases = _cases(path)
    marked = [case for case in cases if case.item.stratum == WARM_UP]
    asked = tuple(case for case in cases if case.item.stratum != WARM_UP)
    if not asked:
        raise FileFormatError(f"{path}: holds the warm-up only")
    return Loaded(path.name, 0, suite_hash(path.read_bytes()), [*marked, *asked][0], asked)


def _cases(path: Path) -> list[Case]:
    """Return the situations of a file with what their lines say of them."""
    situations = read_situations(path)
    lines = [line for line in path.read_text("utf-8-sig").split("\n") if line.strip(" \t\r")]
    return [
        _case(situation, json.loads(line), path.parent)
        for situation, line in zip(situations, lines, strict=True)
    ]


def _case(situation: AnySituation, line: dict[str, Any], folder: Path) -> Case:
    known = line if "suite" in line else {"situation": line}
    given = known["situation"]
    item = Item(situation, str(known.get("family", "")), str(known.get("stratum", "")))
    return Case(item, given, models_of(given, folder))
