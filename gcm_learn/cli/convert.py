"""``gcm-learn convert``: problems that others made, as situations."""

from __future__ import annotations

import dataclasses
import json
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from tyro.conf import Positional, arg

from gcm_learn.cli.failures import CommandFailure
from gcm_learn.cli.files import output, refuse_same
from gcm_learn.cli.options import TIME, Output, given
from gcm_learn.errors import UnknownNameError

if TYPE_CHECKING:
    from gcm_learn.outside import Converter

OF_SUITE = "of the suite"


@dataclass(frozen=True)
class Convert:
    """Convert problems that others made; write one situation a line, in the format of `solve`.

    Standard error says how many starts and goals are blocked, and what was left out and why.
    """

    suite: Annotated[Positional[str], arg(metavar="SUITE")]
    """motionbenchmaker, si-rrt or table-tennis"""

    sources: Annotated[Positional[tuple[Path, ...]], arg(metavar="SOURCE")]
    """files, folders or tar archives"""

    out: Output = None
    """where the situations go"""

    arm: Annotated[str | None, given("NAME", OF_SUITE)] = None
    """an arm that ships or an arm file"""

    horizon: Annotated[float | None, TIME, given("TIME", OF_SUITE)] = None
    """last moment at which a catch counts"""

    grasp: Annotated[float | None, given("METRES", OF_SUITE)] = None
    """distance of hand and target at which it is caught"""

    within: Annotated[float | None, given("RAD", OF_SUITE)] = None
    """angle between the hand's axis and that of the goal posture; not of table-tennis"""

    moving: Annotated[int | None, given("SEED", "at rest")] = None
    """set scenes in motion; of motionbenchmaker only"""

    base: Annotated[tuple[float, float, float] | None, given("X Y Z", OF_SUITE)] = None
    """place of the arm's base [metres]; of table-tennis only"""

    def run(self) -> int:
        """Convert and write."""
        from gcm_learn.situation import situation_to_json

        converter = self._converter()
        if not self.sources:
            raise CommandFailure("SOURCE is missing: a file, a folder or a tar archive")
        for source in self.sources:
            refuse_same({"SOURCE": source, "--out": self.out})
        with output(self.out) as stream:
            converted = converter.convert(self.sources)
            for situation in converted.situations:
                stream.write(json.dumps(situation_to_json(situation)) + "\n")
        print(f"situations: {len(converted.situations)}", file=sys.stderr)
        for note in converted.notes():
            print(note, file=sys.stderr)
        return 0

    def _converter(self) -> Converter:
        """Return the converter of the suite with the settings that are given."""
        from gcm_learn.outside import CONVERTERS

        if self.suite not in CONVERTERS:
            raise UnknownNameError.among("suite", self.suite, CONVERTERS)
        suite: Any = CONVERTERS[self.suite]
        known = {field.name for field in dataclasses.fields(suite)}
        given = {}
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            if field.name in ("suite", "sources", "out") or value is None:
                continue
            if value == "":
                raise CommandFailure(f"--{field.name}: must not be empty")
            if field.name not in known:
                raise CommandFailure(f"--{field.name}: is no option of {self.suite}")
            given[field.name] = value
        converter: Converter = suite(**given)
        return converter
