"""Charts of catches over the time that thinking takes."""

from __future__ import annotations

from collections import Counter

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import Transform, offset_copy

from gcm_learn.evaluation import DELAYS, Interval, Results, charged_curve, measured
from gcm_learn.plots.figures import style
from gcm_learn.plots.figures.comparison import (
    NAMES,
    Colour,
    catchable_strata,
    chart,
    colour_of,
    legend_beside,
    of_stratum,
    reachable,
)

BESIDE = 1.6  # [pt] between curves that coincide
TOGETHER = 6  # methods whose curves can be told apart in one chart
PANEL = (2.9, 2.2)  # [inches] of the chart of one method among many
OTHERS = 0.7  # [pt] curves of other methods
_THINKING = 1e3 * np.array(DELAYS)  # [ms]


def charged_figures(results: Results) -> list[Figure]:
    """Return a chart of all methods, or one for each of many, as far as they were measured."""
    if len(results.methods) <= TOGETHER:
        figure = charged_figure(results)
        return [] if figure is None else [figure]
    results = reachable(results)
    curves = {name: charged_curve(results, name) for name in results.methods}
    shares = {name: _percent(curve) for name, curve in curves.items() if curve}
    return [_highlighted(results, name, shares) for name in shares]


def _percent(curve: list[Interval]) -> list[float]:
    return [100 * point.value for point in curve]


def _highlighted(results: Results, name: str, shares: dict[str, list[float]]) -> Figure:
    """Draw the curve of one method over grey curves of the others."""
    figure = style.new_figure(*PANEL)
    ax = figure.subplots()
    for other, values in shares.items():
        if other != name:
            ax.plot(_THINKING, values, lw=OTHERS, color=style.FAINT)
    colour = colour_of(results, name)
    ax.plot(_THINKING, shares[name], lw=1.5 * BESIDE, color=colour)
    _mark_own(ax, results, name, ax.transData, colour)
    _finish(ax, name)
    ax.set_ylabel("caught [%]", fontsize=style.SMALL)
    return figure


def charged_strata(results: Results) -> list[str]:
    """Situations that can be caught and in which thinking was charged."""
    names = results.methods
    return [
        s
        for s in catchable_strata(results)
        if any(charged_curve(of_stratum(results, s), n) for n in names)
    ]


def charged_figure(results: Results) -> Figure | None:
    """Catches over charged time by stratum; None if that was not measured.

    Curves that coincide are drawn side by side, a line's width apart.
    """
    strata, names = charged_strata(results), results.methods
    if not strata:
        return None
    figure = style.new_figure(1.6 + 3.2 * len(strata), max(3.2, 0.5 + 0.2 * len(names)))
    panels = figure.subplots(1, len(strata), sharey=True, squeeze=False)[0]
    for ax, stratum in zip(panels, strata, strict=True):
        part, drawn = of_stratum(results, stratum), Counter[tuple[float, ...]]()
        for name in names:
            curve = charged_curve(part, name)
            if not curve:
                continue
            shares = _percent(curve)
            colour = colour_of(results, name)
            beside = BESIDE * drawn[tuple(shares)] * (-1 if np.mean(shares) > 50 else 1)
            drawn[tuple(shares)] += 1
            aside = offset_copy(ax.transData, figure, 0.0, beside, "points")
            ax.plot(_THINKING, shares, lw=BESIDE, color=colour, label=name, transform=aside)
            _mark_own(ax, part, name, aside, colour)
        _finish(ax, NAMES[stratum])
    panels[0].set_ylabel("caught [%]", fontsize=style.SMALL)
    legend_beside(figure, panels[-1])
    return figure


def _mark_own(ax: Axes, part: Results, name: str, place: Transform, colour: Colour) -> None:
    """Put a star where a method is charged its own latency, if that was measured."""
    m = measured(part, name)
    if m.own is not None:
        ax.plot(
            min(m.latency, 1e3 * DELAYS[-1]), 100 * m.own.value, "*", color=colour, ms=8,
            mec="white", mew=0.6, zorder=5, transform=place,
        )  # fmt: skip


def _finish(ax: Axes, heading: str) -> None:
    """Head a chart, and let it show all thinking times and shares."""
    chart(ax, heading, "thinking [ms]", "y")
    ax.set_xlim(-50 * DELAYS[-1], 1050 * DELAYS[-1])  # shifted curves count for no limits
    ax.set_ylim(-2, 104)
