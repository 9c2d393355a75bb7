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

    With --into, the sources are scenes of MoveIt, meshes or clouds, without a suite before them.
    They become obstacles at rest in each of your situations.
    Standard error says how many starts and goals are blocked, and what was left out and why.
    """

    suite: Annotated[Positional[str], arg(metavar="SUITE")]
    """motionbenchmaker, si-rrt or table-tennis; none with --into"""

    sources: Annotated[Positional[tuple[Path, ...]], arg(metavar="SOURCE")]
    """files, folders or tar archives"""

    into: Annotated[Path | None, given("FILE", "problems of a suite")] = None
    """situations that take the sources (.scene .yaml .stl .obj .off .ply .pcd .npy) as obstacles"""

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

    radius: Annotated[float | None, given("METRES", "none; clouds need one")] = None
    """radius of the balls about the points of a cloud; with --into"""

    simplify: Annotated[float | None, given("METRES", "all points and triangles")] = None
    """edge of cubes in which points are joined; the radius, or a mesh's margin, makes up for it"""

    scale: Annotated[float | None, given("FACTOR", "1")] = None
    """of the coordinates of clouds and meshes, e.g. 0.001 for millimetres"""

    at: Annotated[tuple[float, float, float] | None, given("X Y Z", "0 0 0")] = None
    """place of the sources' frame in the world [metres]"""

    turn: Annotated[tuple[float, float, float, float] | None, given("W X Y Z", "1 0 0 0")] = None
    """its turn, a unit quaternion"""

    def run(self) -> int:
        """Convert and write."""
        from gcm_learn.situation import situation_to_json

        converter = self._converter()
        sources = self.sources if self.into is None else (Path(self.suite), *self.sources)
        if not sources:
            raise CommandFailure("SOURCE is missing: a file, a folder or a tar archive")
        for source in sources:
            refuse_same({"SOURCE": source, "--into": self.into, "--out": self.out})
        with output(self.out) as stream:
            converted = converter.convert(sources)
            for situation in converted.situations:
                stream.write(json.dumps(situation_to_json(situation)) + "\n")
        print(f"situations: {len(converted.situations)}", file=sys.stderr)
        for note in converted.notes():
            print(note, file=sys.stderr)
        return 0

    def _converter(self) -> Converter:
        """Return the converter of the suite, or of obstacles, with the settings that are given."""
        from gcm_learn.outside import CONVERTERS, World

        if self.into is None and self.suite not in CONVERTERS:
            if Path(self.suite).suffix:
                raise CommandFailure(f"{self.suite}: needs a suite before it, or --into FILE")
            raise UnknownNameError.among("suite", self.suite, CONVERTERS)
        suite: Any = CONVERTERS[self.suite] if self.into is None else World
        known = {field.name for field in dataclasses.fields(suite)}
        given = {}
        for field in dataclasses.fields(self):
            value = getattr(self, field.name)
            if field.name in ("suite", "sources", "out") or value is None:
                continue
            if value == "":
                raise CommandFailure(f"--{field.name}: must not be empty")
            if field.name not in known:
                called = self.suite if self.into is None else "--into"
                raise CommandFailure(f"--{field.name}: is no option of {called}")
            given[field.name] = value
        converter: Converter = suite(**given)
        return converter
