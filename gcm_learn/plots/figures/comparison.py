"""Figures of a comparison."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import LogLocator, NullFormatter

from gcm_learn.evaluation import (
    Interval,
    Results,
    log_of,
    measured,
    pairs,
    under_noise,
)
from gcm_learn.execution import HABITS
from gcm_learn.plots.figures import style

_PAIRED = colormaps["tab20"].colors  # type: ignore[attr-defined]
COLOURS = (*_PAIRED[::2], *_PAIRED[1::2])  # strong ones first
NAMES = {"L": "L: straight line", "W": "W: detour", "Q": "Q: waiting", "U": "U: unreachable"}
OUTCOMES = (
    ("caught", "#3d7f93"),
    ("declined or late", "#d9e0e8"),
    ("touched by forearm", style.EFFECTIVE),
    ("touched by upper arm", "#f0a36b"),
    ("broken promise", style.FAULTS["broken"]),
    ("error", style.FAULTS["error"]),
)
TOUCHES = LinearSegmentedColormap.from_list("touches", ["#fffdfc", "#f3b9a5", style.EFFECTIVE])
MOVES = (
    ("thinking", "latency [ms]"),
    ("time to catch", "over the oracle's"),
    ("path of the hand", "[forearms]"),
    ("least clearance", "[forearms]"),
    ("fastest joint", "[rad/s]"),
)
FULL_TOUCH = 50.0  # share of touches that has the darkest colour [%]
Colour = tuple[float, float, float]


def colour_of(results: Results, name: str) -> Colour:
    """The same colour for a method in all figures."""
    return COLOURS[results.methods.index(name) % len(COLOURS)]


def catchable_strata(results: Results) -> list[str]:
    """Strata in which a catch is possible."""
    return [s for s in results.strata if s != "U"]


def of_stratum(results: Results, stratum: str) -> Results:
    """The rows of a stratum."""
    return results.where(results["stratum"] == stratum)


def reachable(results: Results) -> Results:
    """The rows of situations that can be caught."""
    return results.where(results["stratum"] != "U")


def chart(ax: Axes, heading: str, label: str, grid: str = "") -> None:
    """Head a chart, name its x axis, and draw lines across the axis `grid`."""
    style.title(ax, heading)
    style.plain(ax)
    ax.set_xlabel(label, fontsize=style.SMALL)
    if grid in ("x", "y"):
        ax.grid(axis="x" if grid == "x" else "y", color=style.FAINT, lw=0.4, alpha=0.6)


def _method_rows(
    names: list[str], columns: int, width: float, height: float, *, sharex: bool = False
) -> tuple[Figure, Iterator[Axes]]:
    """Panels of a width side by side, with a row for each method, the first on top."""
    figure = style.new_figure(2.0 + width * columns, height + 0.27 * len(names))
    panels = figure.subplots(1, columns, sharex=sharex, sharey=True, squeeze=False)[0]
    panels[0].set_yticks(range(len(names))[::-1], names, fontsize=style.SMALL)
    return figure, iter(panels)


def _span(ax: Axes, row: float, share: Interval, colour: Colour) -> None:
    """A share in per cent as a dot on its interval."""
    ax.plot([100 * share.low, 100 * share.high], [row, row], color=colour, lw=2)
    ax.plot(100 * share.value, row, "o", color=colour, ms=5)


def legend_beside(figure: Figure, ax: Axes) -> None:
    """A legend of a panel's lines, right of all panels."""
    handles, labels = ax.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside right upper", fontsize=style.SMALL, frameon=False)


def rates_figure(results: Results) -> Figure:
    """Catch rates with intervals, one panel for each stratum that can be caught."""
    strata, names = catchable_strata(results), results.methods
    figure, panels = _method_rows(names, len(strata), 3.2, 0.9)
    for ax, stratum in zip(panels, strata, strict=True):
        part = of_stratum(results, stratum)
        for row, name in enumerate(reversed(names)):
            m = measured(part, name)
            _span(ax, row, m.caught, colour_of(results, name))
            if m.collisions.value > 0.0:
                ax.plot(100 * m.collisions.value, row, "x", color=style.EFFECTIVE, ms=5)
        chart(ax, f"{NAMES[stratum]} ({m.count})", "caught [%]  (× touched)", "x")
        ax.set_xlim(-2, 102)
    return figure


def outcomes_figure(results: Results) -> Figure:
    """Outcomes in every stratum, as bars that add up to all situations."""
    strata, names = results.strata, results.methods
    figure, panels = _method_rows(names, len(strata), 2.6, 1.3)
    for ax, stratum in zip(panels, strata, strict=True):
        part = of_stratum(results, stratum)
        for row, name in enumerate(reversed(names)):
            m, left = measured(part, name), 0.0
            shares = [m.caught.value, 0.0, m.forearm, m.upper_arm, m.broken, m.errors]
            shares[1] = 1.0 - sum(shares)
            for share, (_, colour) in zip(shares, OUTCOMES, strict=True):
                ax.barh(row, 100 * share, left=left, color=colour, height=0.75, lw=0)
                left += 100 * share
        chart(ax, f"{NAMES[stratum]} ({m.count})", "situations [%]")
        ax.set_xlim(0, 100)
    faulty = np.isin(results["outcome"].astype(str), tuple(style.FAULTS)).any()
    listed = OUTCOMES if faulty else OUTCOMES[: -len(style.FAULTS)]
    patches = [Patch(color=colour, label=name) for name, colour in listed]
    figure.legend(
        handles=patches, loc="outside upper center", ncols=len(patches), fontsize=style.SMALL,
        frameon=False,
    )  # fmt: skip
    return figure


def moves_figure(results: Results) -> Figure:
    """How catches are thought out and made: latency, time, path, clearance and joint speed."""
    names = results.methods
    figure, rows = _method_rows(names, len(MOVES), 2.32, 1.1)
    panels = list(rows)
    for row, name in enumerate(reversed(names)):
        colour = colour_of(results, name)
        for ax, values in zip(panels, _movements(results.of_method(name)), strict=True):
            if len(values):
                low, early, middle, late, high = np.quantile(values, (0.05, 0.25, 0.5, 0.75, 0.95))
                ax.plot([low, high], [row, row], color=colour, lw=1)
                ax.plot([early, late], [row, row], color=colour, lw=4, alpha=0.6)
                ax.plot(middle, row, "o", color=colour, ms=5)
    for ax, (heading, unit) in zip(panels, MOVES, strict=True):
        chart(ax, heading, unit, "x")
    for ax in (panels[0], panels[4]):
        ax.set_xscale("log")
        ax.xaxis.set_major_locator(LogLocator(subs=(1.0, 3.0)))
        ax.xaxis.set_major_formatter(lambda value, place: f"{value:g}")
        ax.xaxis.set_minor_formatter(NullFormatter())
    panels[0].set_ylim(-0.6, len(names) - 0.4)
    return figure


def _movements(mine: Results) -> list[np.ndarray]:
    """Latencies of a method, and measures of its catches, each as far as it is a number."""
    caught = mine.where(mine["outcome"] == "caught")
    earliest = np.maximum(caught["earliest"].astype(float), 1e-3)
    joints = np.fmax(caught["peak_shoulder"].astype(float), caught["peak_elbow"].astype(float))
    columns = [
        mine["latency_ms"].astype(float), caught["end"].astype(float) / earliest,
        caught["length"].astype(float), caught["clearance"].astype(float), joints,
    ]  # fmt: skip
    return [column[np.isfinite(column)] for column in columns]


def pairs_figure(results: Results, reference: str) -> Figure:
    """Differences to one method with their intervals, one panel for each stratum."""
    strata = catchable_strata(results)
    names = [name for name in results.methods if name != reference]
    figure, panels = _method_rows(names, len(strata), 3.2, 0.9, sharex=True)
    for ax, stratum in zip(panels, strata, strict=True):
        ax.axvline(0.0, color=style.INK, lw=0.8)
        for row, pair in enumerate(reversed(pairs(of_stratum(results, stratum), reference))):
            _span(ax, row, pair.difference, colour_of(results, pair.first))
        chart(ax, NAMES[stratum], f"points against {reference}", "x")
    return figure


def families_figure(results: Results, outcome: str = "caught") -> Figure:
    """Shares of an outcome by family as a table of colours; reachable situations."""
    results = reachable(results)
    families, names = results.families, results.methods
    shares, counts = np.full((len(families), len(names)), np.nan), [0] * len(families)
    for j, name in enumerate(names):
        mine = results.of_method(name)
        for i, family in enumerate(families):
            here = mine["family"] == family
            counts[i] = int(here.sum())
            shares[i, j] = 100 * np.mean(mine["outcome"][here] == outcome)
    touches = outcome == "touched"
    colours, most = (TOUCHES, FULL_TOUCH) if touches else (style.MAP_COLOURS, 100.0)
    figure = style.new_figure(2.6 + 0.55 * len(names), 1.4 + 0.3 * len(families))
    ax = figure.subplots()
    ax.imshow(shares, vmin=0, vmax=most, cmap=colours, aspect="auto")
    for i, j in np.ndindex(shares.shape):
        ink = "white" if shares[i, j] > 0.6 * most else style.INK
        text = "" if touches and shares[i, j] == 0.0 else f"{shares[i, j]:.0f}"
        ax.text(j, i, text, ha="center", va="center", fontsize=8, color=ink)
    ax.set_xticks(range(len(names)), names, rotation=40, ha="right", fontsize=style.SMALL)
    labels = [f"{family} ({count})" for family, count in zip(families, counts, strict=True)]
    ax.set_yticks(range(len(families)), labels, fontsize=style.SMALL)
    ax.tick_params(length=0)
    style.title(ax, f"{outcome} [%]")
    return figure


def noise_figure(noise: Results) -> Figure:
    """Catches over errors of perception by how they are dealt with, a panel for each planner."""
    names, found = noise.methods, under_noise(noise)
    figure, panels = style.panel_grid(
        len(names), min(len(names), 4), (2.7, 2.5), (2.4, 0.5), shared=True
    )
    for ax, name in zip(panels, names, strict=True):
        mine = [b for b in found if b.method == name]
        exact = next(b for b in mine if b.noise == 0.0)
        for habit, colour in zip(HABITS, COLOURS, strict=False):
            points = [exact, *(b for b in mine if b.way == habit and b.noise > 0.0)]
            across = [b.noise for b in points]
            ax.plot(across, [100 * b.caught.value for b in points], "o-", ms=3, color=colour,
                    label=habit)  # fmt: skip
            ax.plot(across, [100 * b.collisions for b in points], "--", lw=1, color=colour)
        chart(ax, name, "error [forearms]", "y")
        ax.set_ylim(-2, 104)
    panels[0].set_ylabel("caught, touched (dashed) [%]", fontsize=style.SMALL)
    legend_beside(figure, panels[0])
    return figure


def learning_figure(results: Results) -> Figure | None:
    """How the trained actors that take part learned, as far as their logs tell."""
    logs: dict[str, tuple[str, list[dict[str, Any]]]] = {}
    for name in results.methods:
        logs.setdefault(name.partition("@")[0], (name, log_of(name.partition("@")[0])))
    panels = []
    for heading, across, up, down, unit in (
        ("learning in the arena", "steps", "caught", "touched", "validation [%]"),
        ("learning to imitate", "epoch", "accuracy", "", "choices as shown, held out [%]"),
    ):
        curves = {}
        for name, rows in logs.values():
            points = [
                (r[across], r[up], r.get(down, np.nan)) for r in rows if {across, up} <= set(r)
            ]
            if len(points) > 1:
                curves[name] = np.array(points, dtype=float)
        if curves:
            panels.append((heading, across, unit, curves))
    if not panels:
        return None
    figure = style.new_figure(0.6 + 5.2 * len(panels), 3.2)
    for ax, drawn in zip(figure.subplots(1, len(panels), squeeze=False)[0], panels, strict=True):
        _draw_course(ax, results, *drawn)
    return figure


def _draw_course(
    ax: Axes, results: Results, heading: str, across: str, unit: str, curves: dict[str, np.ndarray]
) -> None:
    """Curves (n, 3) of what is learned and, dashed, touched; each named at its end."""
    for name, curve in curves.items():
        colour = colour_of(results, name)
        ax.plot(curve[:, 0], 100 * curve[:, 1], "o-", ms=3, color=colour)
        ax.plot(curve[:, 0], 100 * curve[:, 2], "--", lw=1, color=colour)
        ax.annotate(
            name.partition("@")[0], (curve[-1, 0], 100 * curve[-1, 1]), xytext=(5, 0),
            textcoords="offset points", fontsize=style.SMALL, color=colour, va="center",
        )  # fmt: skip
    chart(ax, heading, across)
    ax.set_ylim(0, 102)
    ax.margins(x=0.14)
    ax.set_ylabel(unit, fontsize=style.SMALL)
    ax.xaxis.set_major_formatter(lambda value, place: _thousands(value))


def _thousands(value: float) -> str:
    """1,500 as 1.5k, 2,000,000 as 2M."""
    for size, letter in ((1e6, "M"), (1e3, "k")):
        if abs(value) >= size:
            return f"{value / size:g}{letter}"
    return f"{value:g}"
