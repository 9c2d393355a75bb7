"""Situations that can be caught and were not, drawn where they ended."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

from matplotlib.figure import Figure

from gcm_learn.plots.figures import style
from gcm_learn.plots.figures.kinds import DRAWN

PANEL = 480  # of a picture before a camera [pixels]
SIZE = (3.6, 3.8)  # [inches]
WORDS = {"broken": "breaks its promise", "error": "fails"}


@dataclass(frozen=True)
class Failure:
    """A situation, and an entrant that did not catch in it."""

    name: str
    """Of the entrant."""
    about: str
    """Family and stratum."""
    situation: Any
    outcome: str
    trajectory: Any
    """Movement that ends in a collision; None if the arm rested."""
    example: Any = None
    """Movement of an entrant that catches, or None."""

    @cached_property
    def pictures(self) -> Any:
        """Pictures of it, by the kind of arm."""
        touches = self.outcome == "touched"
        return DRAWN.of(self.situation).missed(
            self.situation, self.trajectory, self.example, touches
        )

    @property
    def duration(self) -> float:
        """Time until it is over [s]: the collision, or the example's catch.

        Without both it is the horizon or, where bodies are solid, when a target is closest.
        """
        shown = self.trajectory or self.example
        return float(self.pictures.resting_until if shown is None else shown.duration)


def failure_figure(failure: Failure) -> Figure:
    """Draw a failure where it ended."""
    figure = style.new_figure(*SIZE)
    ax = figure.subplots()
    failure.pictures.show_end(ax, failure.duration, PANEL)
    words = WORDS.get(failure.outcome, failure.outcome.replace("_", " "))
    style.title(ax, f"{failure.name}: {words}\n{failure.about} {failure.duration:.2f} s")
    return figure
