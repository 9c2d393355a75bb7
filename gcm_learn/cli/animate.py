"""``gcm-learn animate``: a catch as a film."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from tyro.conf import Positional, arg

from gcm_learn.cli.failures import CommandFailure
from gcm_learn.cli.figure import require_suffix
from gcm_learn.cli.files import FileNames, staged
from gcm_learn.cli.solve import plan_one, read

if TYPE_CHECKING:
    from gcm_learn.situation import AnySituation


@dataclass(frozen=True)
class Animate:
    """Plan for one situation of a file and show the movement: as an animated GIF, or on a page.

    The page, on which the picture can be turned, is for spatial arms and chains.
    """

    file: Annotated[Positional[str], arg(metavar="FILE")]
    """situations: a .json or .jsonl file, or - for standard input"""

    planner: Annotated[str, arg(metavar="NAME")] = "gcm"
    """who plans: a name, an actor as clone@20, or your own: module:name, path.py:name, model.zip;
    an unknown name lists all"""

    out: Annotated[
        Path | None, arg(metavar="FILE", help_behavior_hint="(default: the situation's name.gif)")
    ] = None
    """a .gif file; of a spatial arm or a chain also an .html page (plotly, extra `plots`)"""

    index: int = 0
    """which situation of the file, counted from 0"""

    def run(self) -> int:
        """Plan, draw and save the film."""
        from gcm_learn.planners import get_planner, taken

        planner = get_planner(self.planner)
        situation = taken(planner, self._chosen(read(self.file)))
        target = self.out or Path(f"{FileNames().unused(situation.name)}.gif")
        from gcm_learn.plots import DRAWN, animate, write_film_page

        require_suffix(target, DRAWN.of(situation).films)
        with staged(target) as place:
            show: Any = animate if target.suffix.lower() == ".gif" else write_film_page
            show(situation, plan_one(planner, situation, self.file), place)
        print(target)
        return 0

    def _chosen(self, situations: list[AnySituation]) -> AnySituation:
        if not 0 <= self.index < len(situations):
            held = f"{self.file} holds {len(situations)} situations"
            raise CommandFailure(f"--index {self.index}: {held}, counted from 0")
        return situations[self.index]
