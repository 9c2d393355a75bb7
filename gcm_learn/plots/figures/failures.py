"""Failures of a comparison: reachable situations with a collision or without a catch, and films."""

from __future__ import annotations

import io
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from gcm_learn.arms import elbow_position
from gcm_learn.evaluation import Entry, Results, collision_point, get_method
from gcm_learn.motion import SpatialTrajectory, Trajectory
from gcm_learn.plots.figures import style
from gcm_learn.plots.figures.failures_in_space import MissedCatch, closest_moment
from gcm_learn.plots.figures.film import note_in_corner, pixels, write_film
from gcm_learn.plots.figures.workspace import draw_arm, draw_bodies, draw_courses
from gcm_learn.rendering import SpatialSituation
from gcm_learn.situation import Situation

MOST = 8  # failures that are drawn
FILMS = 3  # of them as films
COLUMNS = 4
FRAMES, FRAME_TIME, HOLD = 30, 70, 1200  # of a film, [ms], [ms]
FILM = 320  # [pixels]
PANEL = 480  # of a picture in space [pixels]
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
    trajectory: Trajectory | SpatialTrajectory | None
    """Movement of the hand; None if it rested, and always None in space."""
    better: str
    """A method that catches, if there is one."""
    example: Trajectory | SpatialTrajectory | None
    """How that catches."""

    @property
    def duration(self) -> float:
        """Until it is over [s]: the collision, or another method's catch, or the horizon.

        In space instead of the horizon when a target is closest.
        """
        shown = self.trajectory or self.example
        if shown is not None:
            return shown.duration
        situation = self.entry.situation
        if situation.is_spatial:
            return closest_moment(cast("SpatialSituation", situation))
        return situation.horizon

    @property
    def words(self) -> str:
        """What happened."""
        return f"touches with the {self.part}" if self.part else self.outcome.replace("_", " ")


def failures_of(results: Results, entries: Sequence[Entry], most: int = MOST) -> list[Failure]:
    """Failures in reachable situations, of methods in turns.

    Who touches comes first, then who fails seldom, for its failures tell more; of each, touches and
    families that are not there yet.
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
    """Play it again, and let a method that caught show how: the one that catches most."""
    movement = get_method(name).run(entry.situation).trajectory
    here = (results["suite"] == entry.suite) & (results["index"] == entry.index)
    there = results.where(
        here & (results["outcome"] == "caught") & (results["latency_ms"] <= LONGEST_PLAN)
    )
    catches = Counter(results["entrant"][results["outcome"] == "caught"].tolist())
    for better in sorted(there.methods, key=lambda other: -catches[other]):
        result = get_method(better).run(entry.situation)
        if result.outcome == "caught":
            return Failure(name, entry, outcome, part, movement, better, result.trajectory)
    return Failure(name, entry, outcome, part, movement, "", None)


def failures_figure(found: Sequence[Failure]) -> Figure:
    """Each where it ended."""
    figure, panels = style.panel_grid(len(found), COLUMNS, (3.3, 3.6))
    for ax, failure in zip(panels, found, strict=True):
        if failure.entry.situation.is_spatial:
            _missed(failure).show_end(ax, failure.duration, PANEL)
        else:
            _draw_end(ax, failure)
        told = f"{failure.entry.family}, {failure.entry.stratum}"
        style.title(ax, f"{failure.name}: {failure.words}\n{told}, {failure.duration:.2f} s")
    return figure


def _draw_end(ax: Axes, failure: Failure) -> None:
    situation, movement, _ = _in_the_plane(failure)
    style.frame(ax, situation.arm.upper_arm)
    draw_bodies(ax, situation, 0.0, alpha=0.25)
    draw_courses(ax, situation, failure.duration)
    draw_bodies(ax, situation, failure.duration)
    _draw_example(ax, failure, failure.duration)
    draw_arm(ax, situation.arm, situation.arm.hand if movement is None else movement.hand[-1])
    if movement is not None:
        ax.plot(*movement.hand.T, color=style.PATH, lw=1.4)
    _mark_touch(ax, failure)


def _in_the_plane(failure: Failure) -> tuple[Situation, Trajectory | None, Trajectory | None]:
    """The situation, what the hand did, and how another one catches, of a planar arm."""
    moves = (failure.trajectory, failure.example)
    movement, example = cast("tuple[Trajectory | None, Trajectory | None]", moves)
    return cast("Situation", failure.entry.situation), movement, example


def _missed(failure: Failure) -> MissedCatch:
    """A failure of a spatial arm, to be drawn."""
    example = cast("SpatialTrajectory | None", failure.example)
    return MissedCatch(cast("SpatialSituation", failure.entry.situation), example)


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
    draw, frames = _drawn(failure), []
    for t in np.linspace(0.0, failure.duration, FRAMES):
        ax.clear()
        draw(ax, float(t))
        note_in_corner(ax, f"{failure.name}  {t:.2f} s", top=True)
        canvas.draw()
        frames.append(pixels(canvas))
    buffer = io.BytesIO()
    write_film(frames, buffer, FRAME_TIME, HOLD)
    return buffer.getvalue()


def _drawn(failure: Failure) -> Callable[[Axes, float], None]:
    """Return a function that draws a failure at a time [s]."""
    if not failure.entry.situation.is_spatial:
        return lambda ax, t: _draw_moment(ax, failure, t)
    missed = _missed(failure)
    return lambda ax, t: missed.show(ax, t, FILM)


def _draw_moment(ax: Axes, failure: Failure, t: float) -> None:
    situation, movement, _ = _in_the_plane(failure)
    style.frame(ax, situation.arm.upper_arm)
    draw_bodies(ax, situation, t)
    _draw_example(ax, failure, t)
    hand = np.asarray(situation.arm.hand) if movement is None else movement.hand_at(t)
    if movement is not None:
        ax.plot(*np.vstack([movement.hand[movement.time <= t], hand]).T, color=style.PATH, lw=1.4)
    draw_arm(ax, situation.arm, hand)
    if t >= failure.duration:
        _mark_touch(ax, failure)


def _draw_example(ax: Axes, failure: Failure, t: float) -> None:
    """The path of a method that catches, in grey, and its arm at a time up to the catch."""
    situation, _, example = _in_the_plane(failure)
    if example is None:
        return
    ax.plot(*example.hand.T, color=style.FAINT, lw=1.4, ls=(0, (1, 1.5)), zorder=3)
    if t <= example.duration:
        arm, hand = situation.arm, example.hand_at(t)
        limb = np.array([(0.0, 0.0), elbow_position(hand, arm.upper_arm, arm.elbow), hand])
        ax.plot(*limb.T, "o-", color=style.FAINT, lw=3.0, ms=6.0, alpha=0.7, zorder=5.5)


def _mark_touch(ax: Axes, failure: Failure) -> None:
    situation, movement, _ = _in_the_plane(failure)
    if failure.outcome == "touched" and movement is not None:
        point = collision_point(situation, movement)
        ax.plot(*point, "o", mfc="none", mec=style.EFFECTIVE, ms=16, mew=1.8, zorder=12)
