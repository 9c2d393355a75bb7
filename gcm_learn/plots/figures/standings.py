"""Figure of a leaderboard: catches over the time to think."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from gcm_learn.benchmark import Standing
from gcm_learn.plots.figures import style
from gcm_learn.plots.figures.comparison import COLOURS, chart

PANEL = (3.6, 2.6)  # [inches]
COLUMNS = 3
THIN, LINE, THICK = 1.0, 1.6, 3.2  # widths of curves [points]
LONGEST, SHORTEST = 1e4, 0.1  # thinking [ms]


def standings_figure(
    found: Mapping[str, Sequence[Standing]], marked: Collection[str] = ()
) -> Figure:
    """Draw a panel for each suite, and a curve for each method.

    Parameters
    ----------
    found : mapping of str to sequence of Standing
        Methods by suite.
    marked : collection of str
        Methods whose curves are thick; the others are thin then.
    """
    names = sorted({one.method for methods in found.values() for one in methods})
    colours = {name: COLOURS[k % len(COLOURS)] for k, name in enumerate(names)}
    widths = {name: (THICK if name in marked else THIN) if marked else LINE for name in names}
    columns = min(COLUMNS, len(found))
    figure, panels = style.panel_grid(len(found), columns, PANEL, (1.6, 0.3))
    for ax, (suite, methods) in zip(panels, found.items(), strict=True):
        for one in methods:
            times, shares = _curve(one)
            front = 3 if one.method in marked else 2
            (line,) = ax.step(times, shares, where="post", color=colours[one.method], zorder=front)
            line.set_linewidth(widths[one.method])
        chart(ax, suite, "time to think [ms]", "y")
        ax.set_ylabel("caught [%]", fontsize=style.SMALL)
        ax.set_xscale("log")
        ax.set_xlim(SHORTEST, LONGEST)
        ax.set_ylim(-2, 102)
    lines = [panels[0].plot([], [], color=colours[n], lw=widths[n], label=n)[0] for n in names]
    figure.legend(handles=lines, loc="outside right upper", fontsize=style.SMALL, frameon=False)
    return figure


def _curve(one: Standing) -> tuple[np.ndarray, np.ndarray]:
    """Return times [ms] and shares caught until then [%]."""
    times = np.array([SHORTEST, *one.times_ms, LONGEST])
    counts = np.arange(len(times), dtype=float)
    counts[-1] = max(len(times) - 2, 0)
    return np.maximum(times, SHORTEST), 100 * one.caught.value * counts / max(counts[-1], 1.0)
