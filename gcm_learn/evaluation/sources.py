"""Cases: situations that entrants are asked about, from suites, families and files."""

from __future__ import annotations

import json
import math
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from gcm_learn import families
from gcm_learn.errors import FileFormatError, SuiteError, UnknownNameError
from gcm_learn.evaluation import suites
from gcm_learn.referee import models_of
from gcm_learn.situation import (
    AnySituation,
    read_situations,
    situation_from_json,
    situation_to_json,
)
from gcm_learn.storage import content_hash

WARM_UP = "warm-up"
"""Stratum of a situation that is asked before all others and does not count."""
COUNT = 50  # situations of a family or of a drawn suite, by default
FILES = (".json", ".jsonl")


@dataclass(frozen=True)
class Case:
    """A situation with its suite, family, stratum and earliest known catch time."""

    situation: AnySituation
    suite: str = "mine"
    """Name of the suite, of the family, or of the file."""
    family: str = ""
    stratum: str = ""
    """L, W or Q; U if no catch is possible for certain; "open" or empty if nothing is known."""
    earliest: float = math.nan
    """Catch time of the yardstick [s], if it is known."""
    given: Mapping[str, Any] | None = field(default=None, repr=False, compare=False)
    """The situation as its file has it, with the models that it names."""

    @cached_property
    def text(self) -> str:
        """The situation as compact JSON, for the referee."""
        values = situation_to_json(self.situation) if self.given is None else self.given
        return json.dumps(values, separators=(",", ":"), allow_nan=False)

    @cached_property
    def key(self) -> str:
        """Hash of the situation: cases with the same key are paired."""
        return content_hash(json.dumps(situation_to_json(self.situation)))[:16]


def case_names() -> list[str]:
    """Return all names that `cases` takes: suites that ship, drawn suites, families, presets."""
    known = [*suites.SHIPPED, *suites.drawn_names(), *families.family_names(), *families.PRESETS]
    return list(dict.fromkeys(known))


def cases(
    *sources: str | Path | AnySituation,
    count: int | None = None,
    seed: int | None = None,
    workers: int | None = 1,
    cluster: str | None = None,
    progress: Callable[[int], None] = lambda new: None,
) -> list[Case]:
    """Return situations to ask about.

    Parameters
    ----------
    *sources : str, Path or Situation
        A suite that ships (``plane``), a drawn suite (``W``), a family or preset (``gate``), a
        ``.json`` or ``.jsonl`` file of situations, or a situation.
    count : int, optional
        At most so many of each source. Default: all of a suite that ships or of a file, else 50.
    seed : int, optional
        Of draws from families, by default 0. With it drawn suites are drawn anew, and a name that
        a preset shares with a suite means the preset.
    workers, cluster
        Of drawing, see `processes.crew_of`.
    progress : callable
        Called with the number of new situations of a drawn suite.

    Raises
    ------
    UnknownNameError, SuiteError, FileFormatError
        If there is no such suite, its file has another hash, or a file cannot be read.
    """
    found: list[Case] = []
    for source in sources:
        if not isinstance(source, (str, Path)):
            found.append(Case(source))
        elif str(source).lower().endswith(FILES):
            found += _counted(_of_file(Path(source), Path(source).name), count)
        elif source in suites.SHIPPED and (seed is None or source not in families.PRESETS):
            found += _counted(_shipped(suites.SHIPPED[str(source)]), count)
        elif source in suites.drawn_names():
            lines = suites.draw_suite(
                str(source), count or COUNT, None, workers, seed=seed, cluster=cluster,
                progress=progress,
            )  # fmt: skip
            found += [_of_line(line, str(source)) for line in lines]
        else:
            found += _of_family(str(source), count or COUNT, seed or 0)
    return found


def check_sources(sources: Iterable[str]) -> None:
    """Raise UnknownNameError, SuiteError or FileFormatError for a source that is not there."""
    for source in sources:
        if source.lower().endswith(FILES):
            if not Path(source).is_file():
                raise FileFormatError(f"{source}: cannot be read (No such file or directory)")
        elif source in suites.OUTSIDE:
            raise SuiteError(
                f"suite {source!r}: its problems are not shipped; make a file with "
                f"'{suites.OUTSIDE[source]}' and give its name"
            )
        elif source not in case_names():
            raise UnknownNameError.among("suite or family", source, case_names())


def cases_of(given: Any) -> list[Case]:
    """Return the cases that `ask` is given: cases, situations, names, or a single one of these."""
    if isinstance(given, (str, Path)) or not isinstance(given, Sequence):
        given = [given]
    found: list[Case] = []
    for one in given:
        found += [one] if isinstance(one, Case) else cases(one)
    return found


def suite_lines(suite: suites.Suite, made: Iterable[Case]) -> bytes:
    """Return the content of a suite's file: a line for each case, the warm-up first."""
    lines = [
        {
            "suite": f"{suite.name}-{suite.version}",
            "family": case.family,
            "stratum": case.stratum,
            "situation": situation_to_json(case.situation),
        }
        for case in made
    ]
    return "".join(json.dumps(line, separators=(",", ":")) + "\n" for line in lines).encode()


def _counted(found: list[Case], count: int | None) -> list[Case]:
    """Return the warm-up and the first `count` cases."""
    warm = [case for case in found if case.stratum == WARM_UP]
    return [*warm, *[case for case in found if case.stratum != WARM_UP][:count]]


def _shipped(suite: suites.Suite) -> list[Case]:
    content = suite.content()
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder, f"{suite.name}.jsonl")
        place.write_bytes(content)
        found = _of_file(place, suite.name)
    warm_up, *others = found
    return [Case(warm_up.situation, suite.name, "", WARM_UP, given=warm_up.given), *others]


def _of_file(path: Path, suite: str) -> list[Case]:
    """Return the cases of a file, with the family, stratum and catch time that its lines state."""
    situations = read_situations(path)
    text = path.read_text("utf-8-sig")
    lines = [line for line in text.split("\n") if line.strip(" \t\r")]
    values = [json.loads(text)] if len(lines) != len(situations) else map(json.loads, lines)
    return [
        _known(situation, value, suite, path.parent)
        for situation, value in zip(situations, values, strict=True)
    ]


def _known(situation: AnySituation, line: dict[str, Any], suite: str, folder: Path) -> Case:
    """Return the case of a line, which is a situation alone or a suite's record of a situation."""
    known = line if "suite" in line else {"situation": line}
    given: dict[str, Any] = known["situation"]
    earliest: Any = known.get("earliest")
    models = models_of(given, folder)
    if models:  # the arm's file is told with the situation
        given = given | {"arm": given["arm"] | {"model": models[given["arm"]["model"]]}}
    return Case(
        situation, suite, str(known.get("family", "")), str(known.get("stratum", "")),
        math.nan if earliest is None else float(earliest), given,
    )  # fmt: skip


def _of_line(line: dict[str, Any], suite: str) -> Case:
    """Return the case of a line of a drawn suite."""
    earliest = math.inf if line["earliest"] is None else line["earliest"]
    situation = situation_from_json(line["situation"])
    return Case(situation, suite, line["family"], line["stratum"], earliest, line["situation"])


def _of_family(name: str, count: int, seed: int) -> list[Case]:
    check_sources([name])
    return [Case(families.draw(name, seed, k), name, name) for k in range(count)]
