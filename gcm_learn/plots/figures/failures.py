"""Failures of a comparison: reachable situations with a collision or without a catch, and films."""

from __future__ import annotations

import io
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from gcm_learn.evaluation import Entry, Method, Results, get_method
from gcm_learn.planners import FAULTS
from gcm_learn.plots.figures import style
from gcm_learn.plots.figures.film import pixels, write_film
from gcm_learn.plots.figures.kinds import DRAWN

MOST = 8  # failures that are drawn
FILMS = 3  # of them as films
COLUMNS = 4
FRAMES, FRAME_TIME, HOLD = 30, 70, 1200  # of a film, [ms], [ms]
FILM = 320  # [pixels]
PANEL = 480  # of a picture before a camera [pixels]
LONGEST_PLAN = 500.0  # slower methods are not asked how they catch [ms]
ORDER = ("touched", "late", "declined", "start_blocked", "broken", "error")

WORDS = {"broken": "breaks its promise", "error": "fails"}


@dataclass(frozen=True)
class Failure:
    """A situation that can be caught, and a method that did not catch."""

    name: str
    entry: Entry
    outcome: str
    part: str | None
    """Part of the limb that touched."""
    trajectory: Any
    """Movement that ends in a collision, if it is kept; None if the arm rested."""
    better: str
    """A method that catches, if there is one."""
    example: Any
    """Movement of that method, or None."""

    @property
    def duration(self) -> float:
        """Time until it is over [s]: the collision, or another method's catch.

        Without both it is the horizon or, where bodies are solid, when a target is closest.
        """
        shown = self.trajectory or self.example
        if shown is not None:
            return shown.duration
        return float(self.pictures.resting_until)

    @cached_property
    def pictures(self) -> Any:
        """Pictures of it, by the kind of arm."""
        situation, touches = self.entry.situation, self.outcome == "touched"
        return DRAWN.of(situation).missed(situation, self.trajectory, self.example, touches)

    @property
    def words(self) -> str:
        """Outcome in words."""
        if self.part:
            return f"touches with the {self.part}"
        return WORDS.get(self.outcome, self.outcome.replace("_", " "))


def failures_of(results: Results, entries: Sequence[Entry], most: int = MOST) -> list[Failure]:
    """Return failures in reachable situations, of methods in turns.

    Methods that touch come first, then methods that fail seldom, for their failures say more.  Of
    each method, touches and new families come first.
    """
    known = {(e.suite, e.index): e for e in entries}
    lost = results.where((results["outcome"] != "caught") & (results["stratum"] != "U"))
    left: dict[str, list[tuple[str, str | None, Entry]]] = {}
    for k in range(len(lost)):
        entry = known[str(lost["suite"][k]), int(lost["index"][k])]
        row = (str(lost["outcome"][k]), lost["part"][k], entry)
        left.setdefault(str(lost["entrant"][k]), []).append(row)
    turns = sorted(left, key=lambda n: (min(ORDER.index(r[0]) for r in left[n]), len(left[n])))
    found: list[Failure] = []
    while len(found) < most and any(left.values()):
        for name in [n for n in turns if left[n]][: most - len(found)]:
            shown = [f.entry.family for f in found]
            row = min(left[name], key=lambda r: (ORDER.index(r[0]), shown.count(r[2].family)))
            left[name].remove(row)
            found.append(_failure(results, name, *row))
    return found


def _failure(results: Results, name: str, outcome: str, part: str | None, entry: Entry) -> Failure:
    """Play it again, and let the method that catches most show how."""
    # Broken promises and errors have no movement, and may take all of a limit.
    again = outcome not in FAULTS
    movement = _method(results, name).run(entry.situation).trajectory if again else None
    here = (results["suite"] == entry.suite) & (results["index"] == entry.index)
    there = results.where(
        here & (results["outcome"] == "caught") & (results["latency_ms"] <= LONGEST_PLAN)
    )
    catches = Counter(results["entrant"][results["outcome"] == "caught"].tolist())
    for better in sorted(there.methods, key=lambda other: -catches[other]):
        result = _method(results, better).run(entry.situation)
        if result.outcome == "caught":
            return Failure(name, entry, outcome, part, movement, better, result.trajectory)
    return Failure(name, entry, outcome, part, movement, "", None)


def _method(results: Results, name: str) -> Method:
    """Return the method of some rows."""
    return get_method(results.given.get(name, name), name)


def failures_figure(found: Sequence[Failure]) -> Figure:
    """Draw each failure where it ended."""
    figure, panels = style.panel_grid(len(found), COLUMNS, (3.3, 3.6))
    for ax, failure in zip(panels, found, strict=True):
        failure.pictures.show_end(ax, failure.duration, PANEL)
        told = f"{failure.entry.family}, {failure.entry.stratum}"
        style.title(ax, f"{failure.name}: {failure.words}\n{told}, {failure.duration:.2f} s")
    return figure


def failure_film(found: Sequence[Failure], most: int = FILMS) -> list[tuple[str, bytes]]:
    """Return films of different methods and families: words, and bytes of a GIF."""
    chosen: list[Failure] = []
    for failure in sorted(found, key=lambda f: ORDER.index(f.outcome)):
        seen = {f.name for f in chosen} | {f.entry.family for f in chosen}
        if len(chosen) < most and not {failure.name, failure.entry.family} & seen:
            chosen.append(failure)
    return [(_caption(failure), _film(failure)) for failure in chosen]


def _caption(failure: Failure) -> str:
    slower = FRAMES * FRAME_TIME * 1e-3 / max(failure.duration, 1e-3)
    text = f"{failure.name} in {failure.entry.family} ({failure.entry.stratum}): {failure.words}"
    if failure.example is not None:
        text += f"; {failure.better} catches (grey)"
    return f"{text}. {slower:.1f} times slower."


def _film(failure: Failure) -> bytes:
    """Return an animated GIF."""
    figure = Figure(figsize=(FILM / style.DPI, FILM / style.DPI), dpi=style.DPI)
    canvas, ax = FigureCanvasAgg(figure), figure.add_axes((0.0, 0.0, 1.0, 1.0))
    frames = []
    for t in np.linspace(0.0, failure.duration, FRAMES):
        ax.clear()
        failure.pictures.show(ax, float(t), FILM, failure.duration)
        style.note_in_corner(ax, f"{failure.name}  {t:.2f} s", top=True)
        canvas.draw()
        frames.append(pixels(canvas))
    buffer = io.BytesIO()
    write_film(frames, buffer, FRAME_TIME, HOLD)
    return buffer.getvalue()
