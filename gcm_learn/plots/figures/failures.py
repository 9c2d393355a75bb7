"""What goes wrong in a comparison: reachable situations that were touched or missed, and films."""

from __future__ import annotations

import io
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from gcm_learn.evaluation import Entry, Results, collision_point, get_method
from gcm_learn.motion import Trajectory
from gcm_learn.plots.figures import style
from gcm_learn.plots.figures.film import note_in_corner, pixels, write_film
from gcm_learn.plots.figures.workspace import draw_arm, draw_bodies, draw_courses
from gcm_learn.scene import elbow_position

MOST = 8  # failures that are drawn
FILMS = 3  # of them as films
COLUMNS = 4
FRAMES, FRAME_TIME, HOLD = 30, 70, 1200  # of a film, [ms], [ms]
FILM = 320  # [pixels]
LONGEST_PLAN = 500.0  # who thinks for longer is not asked how it catches [ms]
ORDER = ("touched", "late", "declined", "start_blocked")


@dataclass(frozen=True)
class Failure:
    """A situation that can be caught, and a method that did not catch."""

    name: str
    entry: Entry
    outcome: str
    part: str | None
    """Of the limb that touched."""
    trajectory: Trajectory | None
    """What the hand did; None if it rested."""
    better: str
    """A method that catches, if there is one."""
    example: Trajectory | None
    """How that catches."""

    @property
    def duration(self) -> float:
        """Until it is over [s]: the collision, or another method's catch, or the horizon."""
        if self.trajectory is not None:
            return self.trajectory.duration
        return self.entry.situation.horizon if self.example is None else self.example.duration

    @property
    def words(self) -> str:
        """What happened."""
        return f"touches with the {self.part}" if self.part else self.outcome.replace("_", " ")


def failures_of(results: Results, entries: Sequence[Entry], most: int = MOST) -> list[Failure]:
    """Failures in reachable situations, of methods in turns.

    Who touches comes first, then who fails seldom, for its failures tell more; of each, touches and
    families that are not there yet.  Only what happens in the plane is drawn.
    """
    known = {(e.suite, e.index): e for e in entries if not e.situation.is_spatial}
    lost = results.where((results["outcome"] != "caught") & (results["stratum"] != "U"))
    left: dict[str, list[tuple[str, str | None, Entry]]] = {}
    for k in range(len(lost)):
        entry = known.get((str(lost["suite"][k]), int(lost["index"][k])))
        if entry is not None:
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
    """Play it again, and let a method that caught show how: the one that catches most."""
    movement = cast("Trajectory | None", get_method(name).run(entry.situation).trajectory)
    here = (results["suite"] == entry.suite) & (results["index"] == entry.index)
    there = results.where(
        here & (results["outcome"] == "caught") & (results["latency_ms"] <= LONGEST_PLAN)
    )
    catches = Counter(results["entrant"][results["outcome"] == "caught"].tolist())
    for better in sorted(there.methods, key=lambda other: -catches[other]):
        result = get_method(better).run(entry.situation)
        if result.outcome == "caught":
            example = cast("Trajectory | None", result.trajectory)
            return Failure(name, entry, outcome, part, movement, better, example)
    return Failure(name, entry, outcome, part, movement, "", None)


def failures_figure(found: Sequence[Failure]) -> Figure:
    """Each where it ended."""
    figure, panels = style.panel_grid(len(found), COLUMNS, (3.3, 3.6))
    for ax, failure in zip(panels, found, strict=True):
        situation, arm = failure.entry.situation, failure.entry.situation.arm
        style.frame(ax, arm.upper_arm)
        draw_bodies(ax, situation, 0.0, alpha=0.25)
        draw_courses(ax, situation, failure.duration)
        draw_bodies(ax, situation, failure.duration)
        _draw_example(ax, failure, failure.duration)
        draw_arm(ax, arm, arm.hand if failure.trajectory is None else failure.trajectory.hand[-1])
        if failure.trajectory is not None:
            ax.plot(*failure.trajectory.hand.T, color=style.PATH, lw=1.4)
        _mark_touch(ax, failure)
        told = f"{failure.entry.family}, {failure.entry.stratum}"
        style.title(ax, f"{failure.name}: {failure.words}\n{told}, {failure.duration:.2f} s")
    return figure


def failure_film(found: Sequence[Failure], most: int = FILMS) -> list[tuple[str, bytes]]:
    """Some of them as films, of methods and families that differ: words, and bytes of a GIF."""
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
    """An animated GIF."""
    figure = Figure(figsize=(FILM / style.DPI, FILM / style.DPI), dpi=style.DPI)
    canvas, ax = FigureCanvasAgg(figure), figure.add_axes((0.0, 0.0, 1.0, 1.0))
    frames = []
    for t in np.linspace(0.0, failure.duration, FRAMES):
        ax.clear()
        _draw_moment(ax, failure, float(t))
        canvas.draw()
        frames.append(pixels(canvas))
    buffer = io.BytesIO()
    write_film(frames, buffer, FRAME_TIME, HOLD)
    return buffer.getvalue()


def _draw_moment(ax: Axes, failure: Failure, t: float) -> None:
    situation, movement = failure.entry.situation, failure.trajectory
    style.frame(ax, situation.arm.upper_arm)
    draw_bodies(ax, situation, t)
    _draw_example(ax, failure, t)
    hand = np.asarray(situation.arm.hand) if movement is None else movement.hand_at(t)
    if movement is not None:
        ax.plot(*np.vstack([movement.hand[movement.time <= t], hand]).T, color=style.PATH, lw=1.4)
    draw_arm(ax, situation.arm, hand)
    if t >= failure.duration:
        _mark_touch(ax, failure)
    note_in_corner(ax, f"{failure.name}  {t:.2f} s", top=True)


def _draw_example(ax: Axes, failure: Failure, t: float) -> None:
    """The path of a method that catches, in grey, and its arm at a time up to the catch."""
    if failure.example is None:
        return
    ax.plot(*failure.example.hand.T, color=style.FAINT, lw=1.4, ls=(0, (1, 1.5)), zorder=3)
    if t <= failure.example.duration:
        arm, hand = failure.entry.situation.arm, failure.example.hand_at(t)
        limb = np.array([(0.0, 0.0), elbow_position(hand, arm.upper_arm, arm.elbow), hand])
        ax.plot(*limb.T, "o-", color=style.FAINT, lw=3.0, ms=6.0, alpha=0.7, zorder=5.5)


def _mark_touch(ax: Axes, failure: Failure) -> None:
    if failure.outcome == "touched" and failure.trajectory is not None:
        point = collision_point(failure.entry.situation, failure.trajectory)
        ax.plot(*point, "o", mfc="none", mec=style.EFFECTIVE, ms=16, mew=1.8, zorder=12)
