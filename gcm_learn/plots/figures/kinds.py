"""How arms of each kind are drawn: the only table of pictures by kind."""

from __future__ import annotations

from typing import Any, NamedTuple

from gcm_learn.arms import PLANAR, ByKind
from gcm_learn.plots.figures.diagram import Diagram, MissedDiagram
from gcm_learn.plots.figures.stage import JointPictures, MissedStage


class Drawn(NamedTuple):
    """Classes of pictures for one kind of arm, and the endings of its films."""

    pictures: Any
    """Class of pictures of a situation and a plan."""
    missed: Any
    """Class of pictures of a missed catch."""
    films: tuple[str, ...]
    """Endings of files that show a movement: films, and pages on which it is turned."""


DRAWN = ByKind(
    {PLANAR: Drawn(Diagram, MissedDiagram, (".gif",))},
    default=Drawn(JointPictures, MissedStage, (".gif", ".html")),
)


def pictures_of(situation: Any, plan: Any = None) -> Any:
    """Return a `Diagram` or a `JointPictures` of a situation and a plan, by the kind of arm."""
    return DRAWN.of(situation).pictures(situation, plan)
