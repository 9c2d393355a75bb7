"""Failures of a comparison, drawn."""

from __future__ import annotations

import io
from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure
from PIL import Image

from gcm_learn.envs.viewer import Viewer
from gcm_learn.evaluation.entrants import ActorEntrant, Result, entrant
from gcm_learn.evaluation.suites import Entry
from gcm_learn.evaluation.table import Results
from gcm_learn.plots import style
from gcm_learn.plots.workspace import draw_arm, draw_bodies, draw_courses, draw_workspace

MOST = 8  # failures that are drawn
COLUMNS = 4
FRAMES, FRAME_TIME = 30, 60  # of a film, [ms]
FILM = 320  # [pixels]


def failures_figure(results: Results, entries: Sequence[Entry]) -> Figure | None:
    """Touches of actors, each where it ended; None if there is none."""
    found = _touches(results, entries)
    if not found:
        return None
    rows = -(-len(found) // COLUMNS)
    figure = style.new_figure(3.0 * COLUMNS, 3.2 * rows)
    panels = figure.subplots(rows, COLUMNS, squeeze=False).ravel()
    for ax in panels[len(found) :]:
        ax.axis("off")
    for ax, (name, entry, result) in zip(panels, found, strict=False):
        way, situation = result.trajectory, entry.situation
        assert way is not None
        draw_workspace(ax, situation)
        for line in ax.lines:
            line.set_alpha(0.25)
        draw_courses(ax, situation, way.duration)
        draw_bodies(ax, situation, way.duration)
        draw_arm(ax, situation.arm, way.hand[-1])
        ax.plot(*way.hand.T, color=style.PATH, lw=1.4)
        ax.plot(*way.hand[-1], "o", mfc="none", mec=style.EFFECTIVE, ms=14, mew=1.6)
        style.title(ax, f"{name}: {entry.family}, {entry.stratum}, {way.duration:.2f} s")
    return figure


def failure_film(results: Results, entries: Sequence[Entry]) -> tuple[str, int, bytes] | None:
    """The first of them as a film: what it shows, its width and the bytes of a GIF."""
    found = _touches(results, entries)
    if not found:
        return None
    name, entry, result = found[0]
    way = result.trajectory
    assert way is not None
    viewer, frames = Viewer(False), []
    for t in np.linspace(0.0, way.duration, FRAMES):
        behind = way.hand[way.time <= t]
        path = np.vstack([behind, way.hand_at(t)[None]])
        picture = viewer.show(entry.situation, float(t), path)
        assert picture is not None
        frames.append(Image.fromarray(picture).resize((FILM, FILM)).quantize(64))
    buffer = io.BytesIO()
    frames[0].save(
        buffer, "GIF", save_all=True, append_images=frames[1:] + [frames[-1]] * 8,
        duration=FRAME_TIME, loop=0,
    )  # fmt: skip
    slower = FRAMES * FRAME_TIME * 1e-3 / max(way.duration, 1e-3)
    part = _part(results, name, entry)
    text = f"{name} in {entry.family}, {slower:.0f} times slower: it touches with the {part}."
    return text, FILM, buffer.getvalue()


def _part(results: Results, name: str, entry: Entry) -> str:
    here = (results["entrant"] == name) & (results["index"] == entry.index)
    here &= results["suite"] == entry.suite
    return str(results["part"][here][0])


def _touches(results: Results, entries: Sequence[Entry]) -> list[tuple[str, Entry, Result]]:
    """Touches of actors in reachable situations, evenly from all actors."""
    known = {(e.suite, e.index): e for e in entries}
    rows: dict[str, list[Entry]] = {}
    for k in np.flatnonzero((results["outcome"] == "touched") & (results["stratum"] != "U")):
        entry = known.get((str(results["suite"][k]), int(results["index"][k])))
        if entry is not None:
            rows.setdefault(str(results["entrant"][k]), []).append(entry)
    found: list[tuple[str, Entry, Result]] = []
    actors = {name: made for name in rows if isinstance(made := entrant(name), ActorEntrant)}
    for turn in range(MOST):
        for name, made in actors.items():
            if turn < len(rows[name]) and len(found) < MOST:
                entry = rows[name][turn]
                found.append((name, entry, made.run(entry.situation)))
    return found
