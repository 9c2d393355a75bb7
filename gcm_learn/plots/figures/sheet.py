"""Figures of a sheet of answers, of one panel each, for pages of any width."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

from gcm_learn.plots.figures import style

_PAIRED = colormaps["tab20"].colors  # type: ignore[attr-defined]
COLOURS = (*_PAIRED[::2], *_PAIRED[1::2])  # strong ones first
STRATA = {
    "L": "L: a straight line works", "W": "W: a detour is needed", "Q": "Q: waiting is needed",
    "U": "U: no catch is possible",
}  # fmt: skip
WIDTH = 4.6  # [inches], readable at 400 pixels
OUTCOMES = {
    "caught": "#3d7f93", "declined": "#d9e0e8", "late": "#b8c4d0", "start_blocked": "#a0aec0",
    "touched": style.EFFECTIVE, **style.FAULTS,
}  # fmt: skip
Span = tuple[float, float, float]
"""Value and 95 % interval, as shares."""
LEAST, MOST = 0.1, 1e4  # processor time [ms]
FEW = 3  # entrants whose intervals can be told apart as bands


def colours_of(names: Sequence[str]) -> dict[str, Any]:
    """Return a colour for each entrant, the same in all figures of a page."""
    return {name: COLOURS[k % len(COLOURS)] for k, name in enumerate(names)}


def spans_figure(
    heading: str, label: str, spans: Mapping[str, Span], colours: Mapping[str, Any]
) -> Figure:
    """Draw a row for each entrant: its share or difference with the interval, in per cent."""
    figure, ax = _rows(list(spans))
    for row, (name, span) in enumerate(spans.items()):
        value, low, high = (100.0 * one for one in span)
        ax.plot([low, high], [row, row], color=colours[name], lw=2)
        ax.plot(value, row, "o", color=colours[name], ms=5)
    if label == "caught [%]":
        ax.set_xlim(-2, 102)
    else:
        ax.axvline(0.0, color=style.INK, lw=0.8)
    return _finished(figure, ax, heading, label, "x")


def outcomes_figure(heading: str, shares: Mapping[str, Mapping[str, float]]) -> Figure:
    """Draw shares of outcomes as bars that add up to all situations, a row for each entrant."""
    figure, ax = _rows(list(shares), 0.35)
    left = np.zeros(len(shares))
    for outcome, colour in OUTCOMES.items():
        width = 100.0 * np.array([mine.get(outcome, 0.0) for mine in shares.values()])
        if width.any():
            ax.barh(range(len(shares)), width, left=left, color=colour, height=0.75,
                    label=outcome.replace("_", " "))  # fmt: skip
            left += width
    ax.set_xlim(0, 100)
    figure.legend(loc="outside lower center", ncols=4, fontsize=style.SMALL, frameon=False)
    return _finished(figure, ax, heading, "situations [%]")


def times_figure(
    heading: str,
    curves: Mapping[str, tuple[np.ndarray, np.ndarray]],
    colours: Mapping[str, Any],
    marked: Sequence[str] = (),
) -> Figure:
    """Draw shares caught within a processor time [ms], a step curve for each entrant."""
    figure = style.new_figure(WIDTH, 3.2 + 0.1 * len(curves))
    ax = figure.subplots()
    for name, (times, shares) in curves.items():
        across = np.clip([LEAST, *times, MOST], LEAST, MOST)
        up = 100.0 * np.array([0.0, *shares, shares[-1] if len(shares) else 0.0])
        thick = 3.0 if name in marked else 1.5
        ax.step(across, up, where="post", color=colours[name], label=name, lw=thick)
    ax.set_xscale("log")
    ax.set_ylim(-2, 102)
    ax.set_ylabel("caught [%]", fontsize=style.SMALL)
    _legend(figure, len(curves))
    return _finished(figure, ax, heading, "processor time [ms]", "y")


def lines_figure(
    heading: str,
    label: str,
    lines: Mapping[str, tuple[Sequence[float], Sequence[Span]]],
    colours: Mapping[str, Any],
    stars: Mapping[str, tuple[float, float]] | None = None,
) -> Figure:
    """Draw shares over a condition, of few entrants with intervals; a star for own times."""
    figure = style.new_figure(WIDTH, 3.2 + 0.1 * len(lines))
    ax = figure.subplots()
    for name, (across, spans) in lines.items():
        value, low, high = 100.0 * np.array(spans).T
        ax.plot(across, value, "o-", ms=3, color=colours[name], label=name)
        if len(lines) <= FEW:
            ax.fill_between(across, low, high, color=colours[name], alpha=0.12, lw=0)
    for name, (place, share) in (stars or {}).items():
        ax.plot(
            place, 100.0 * share, "*", color=colours[name], ms=9, mec="white", mew=0.6, zorder=5
        )
    ax.set_ylim(-2, 104)
    ax.set_ylabel("caught [%]", fontsize=style.SMALL)
    _legend(figure, len(lines))
    return _finished(figure, ax, heading, label, "y")


def shares_figure(heading: str, rows: Sequence[str], columns: Sequence[str], shares: Any) -> Figure:
    """Draw shares (rows, columns) as a table of colours."""
    figure = style.new_figure(min(2.4 + 0.5 * len(columns), WIDTH + 0.2 * len(columns)),
                              1.5 + 0.27 * len(rows))  # fmt: skip
    ax, percent = figure.subplots(), 100.0 * np.asarray(shares)
    ax.imshow(percent, vmin=0, vmax=100, cmap=style.MAP_COLOURS, aspect="auto")
    for i, j in np.ndindex(percent.shape):
        if np.isfinite(percent[i, j]):
            ink = "white" if percent[i, j] > 60 else style.INK
            ax.text(j, i, f"{percent[i, j]:.0f}", ha="center", va="center", fontsize=8, color=ink)
    ax.set_xticks(range(len(columns)), columns, rotation=40, ha="right", fontsize=style.SMALL)
    ax.set_yticks(range(len(rows)), rows, fontsize=style.SMALL)
    ax.tick_params(length=0)
    style.title(ax, heading)
    return figure


def spread_figure(
    heading: str, label: str, values: Mapping[str, np.ndarray], colours: Mapping[str, Any]
) -> Figure:
    """Draw medians, middle halves and 90 % of values on a logarithmic axis, a row an entrant."""
    figure, ax = _rows(list(values))
    for row, (name, mine) in enumerate(values.items()):
        if len(mine):
            low, early, middle, late, high = np.quantile(mine, (0.05, 0.25, 0.5, 0.75, 0.95))
            ax.plot([low, high], [row, row], color=colours[name], lw=1)
            ax.plot([early, late], [row, row], color=colours[name], lw=4, alpha=0.6)
            ax.plot(middle, row, "o", color=colours[name], ms=5)
    ax.set_xscale("log")
    ax.xaxis.set_major_locator(LogLocator(subs=(1.0, 3.0)))
    ax.xaxis.set_major_formatter(lambda value, place: f"{value:g}")
    ax.xaxis.set_minor_formatter(NullFormatter())
    return _finished(figure, ax, heading, label, "x")


def _rows(names: Sequence[str], more: float = 0.0) -> tuple[Figure, Axes]:
    """Return a panel with a row for each name, the first on top."""
    figure = style.new_figure(WIDTH, 1.0 + more + 0.27 * len(names))
    ax = figure.subplots()
    ax.set_yticks(range(len(names)), names, fontsize=style.SMALL)
    ax.set_ylim(len(names) - 0.4, -0.6)
    return figure, ax


def _legend(figure: Figure, count: int) -> None:
    figure.legend(
        loc="outside lower center", ncols=min(count, 3), fontsize=style.SMALL, frameon=False
    )


def _finished(figure: Figure, ax: Axes, heading: str, label: str, grid: str = "") -> Figure:
    """Add a heading, the label of the x axis and grid lines to a chart; return the figure."""
    style.title(ax, heading)
    style.plain(ax)
    ax.set_xlabel(label, fontsize=style.SMALL)
    if grid == "x":
        ax.grid(axis="x", color=style.FAINT, lw=0.4, alpha=0.6)
    elif grid == "y":
        ax.grid(axis="y", color=style.FAINT, lw=0.4, alpha=0.6)
    return figure
