"""Figures of a comparison."""

from __future__ import annotations

import json
from collections.abc import Sequence

import numpy as np
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gcm_learn.evaluation.contest import DELAYS
from gcm_learn.evaluation.measures import charged_curve, measured
from gcm_learn.evaluation.table import Results
from gcm_learn.memory.shipped import models_folder
from gcm_learn.plots import style

COLOURS = colormaps["tab20"].colors  # type: ignore[attr-defined]
NAMES = {"L": "L: straight line", "W": "W: way round", "Q": "Q: waiting", "U": "U: unreachable"}
LOG = "log.jsonl"


def colour_of(results: Results, name: str) -> tuple[float, float, float]:
    """The same colour for an entrant in all figures."""
    return COLOURS[results.entrants.index(name) % len(COLOURS)]


def _plain(ax: Axes, heading: str) -> None:
    style.title(ax, heading)
    ax.spines[["top", "right"]].set_visible(False)
    ax.tick_params(labelsize=style.SMALL, colors=style.INK)


def rates_figure(results: Results) -> Figure:
    """Catch rates with intervals, one panel for each stratum that can be caught."""
    strata = [s for s in results.strata if s != "U"]
    names = results.entrants
    figure = style.new_figure(2.0 + 3.2 * len(strata), 0.9 + 0.27 * len(names))
    panels = figure.subplots(1, len(strata), sharey=True, squeeze=False)[0]
    rows = np.arange(len(names))[::-1]
    for ax, stratum in zip(panels, strata, strict=True):
        part = results.where(results["stratum"] == stratum)
        for row, name in zip(rows, names, strict=True):
            m = measured(part, name)
            colour = colour_of(results, name)
            ax.plot([100 * m.caught.low, 100 * m.caught.high], [row, row], color=colour, lw=2)
            ax.plot(100 * m.caught.value, row, "o", color=colour, ms=5)
            if m.touched.value > 0.0:
                ax.plot(100 * m.touched.value, row, "x", color=style.EFFECTIVE, ms=5)
        _plain(ax, f"{NAMES[stratum]} ({m.count})")
        ax.set_xlim(-2, 102)
        ax.grid(axis="x", color=style.FAINT, lw=0.4, alpha=0.6)
        ax.set_xlabel("caught [%]  (× touched)", fontsize=style.SMALL)
    panels[0].set_yticks(rows, names, fontsize=style.SMALL)
    return figure


def charged_figure(results: Results) -> Figure | None:
    """Catches over charged time by stratum; None if that was not measured."""
    strata = [s for s in results.strata if s != "U"]
    figure = style.new_figure(1.6 + 3.2 * len(strata), 3.2)
    panels = figure.subplots(1, len(strata), sharey=True, squeeze=False)[0]
    drawn = False
    for ax, stratum in zip(panels, strata, strict=True):
        part = results.where(results["stratum"] == stratum)
        for name in results.entrants:
            curve = charged_curve(part, name)
            if curve:
                drawn = True
                shares = [100 * point.value for point in curve]
                colour = colour_of(results, name)
                ax.plot(
                    1e3 * np.array(DELAYS), shares, "o-", ms=3, lw=1.4, color=colour, label=name
                )
        _plain(ax, NAMES[stratum])
        ax.set_ylim(-2, 102)
        ax.set_xlabel("thinking [ms]", fontsize=style.SMALL)
    panels[0].set_ylabel("caught [%]", fontsize=style.SMALL)
    handles, labels = panels[-1].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside right upper", fontsize=style.SMALL, frameon=False)
    return figure if drawn else None


def latency_figure(results: Results) -> Figure:
    """Latency against catches of reachable situations."""
    figure = style.new_figure(6.4, 3.6)
    ax = figure.subplots()
    part = results.where(results["stratum"] != "U")
    for name in results.entrants:
        m = measured(part, name)
        ax.plot(max(m.latency, 1e-2), 100 * m.caught.value, "o", color=colour_of(results, name))
        ax.annotate(
            name, (max(m.latency, 1e-2), 100 * m.caught.value), xytext=(5, 3),
            textcoords="offset points", fontsize=style.SMALL, color=style.INK,
        )  # fmt: skip
    ax.set_xscale("log")
    _plain(ax, "thinking and catching")
    ax.margins(x=0.2)
    ax.set_ylim(0, 105)
    ax.set_xlabel("median latency [ms]", fontsize=style.SMALL)
    ax.set_ylabel("caught of reachable [%]", fontsize=style.SMALL)
    return figure


def families_figure(results: Results) -> Figure:
    """Catches by family as a table of colours."""
    part = results.where(results["stratum"] != "U")
    families, names = part.families, results.entrants
    shares = np.full((len(families), len(names)), np.nan)
    for j, name in enumerate(names):
        mine = part.of_entrant(name)
        for i, family in enumerate(families):
            here = mine["family"] == family
            if here.any():
                shares[i, j] = 100 * np.mean(mine["outcome"][here] == "caught")
    figure = style.new_figure(2.4 + 0.62 * len(names), 1.4 + 0.3 * len(families))
    ax = figure.subplots()
    ax.imshow(shares, vmin=0, vmax=100, cmap=style.MAP_COLOURS, aspect="auto")
    for i, j in np.ndindex(shares.shape):
        if np.isfinite(shares[i, j]):
            ink = "white" if shares[i, j] > 60 else style.INK
            ax.text(j, i, f"{shares[i, j]:.0f}", ha="center", va="center", fontsize=8, color=ink)
    ax.set_xticks(range(len(names)), names, rotation=40, ha="right", fontsize=style.SMALL)
    ax.set_yticks(range(len(families)), families, fontsize=style.SMALL)
    ax.tick_params(length=0)
    return figure


def learning_figure(names: Sequence[str]) -> Figure | None:
    """Learning curves of the actors that have a log of steps."""
    curves: dict[str, np.ndarray] = {}
    for bare in dict.fromkeys(name.partition("@")[0] for name in names):
        path = models_folder() / bare / LOG
        if path.exists():
            rows = [json.loads(line) for line in path.read_text("utf-8").splitlines()]
            points = [(r["steps"], r["caught"]) for r in rows if "steps" in r]
            if len(points) > 1:
                curves[bare] = np.array(points)
    if not curves:
        return None
    figure = style.new_figure(6.4, 3.2)
    ax = figure.subplots()
    for name, curve in curves.items():
        ax.plot(curve[:, 0] / 1e6, 100 * curve[:, 1], "o-", ms=3, label=name)
    _plain(ax, "learning curves")
    ax.set_ylim(0, 102)
    ax.set_xlabel("steps [millions]", fontsize=style.SMALL)
    ax.set_ylabel("caught, validation [%]", fontsize=style.SMALL)
    ax.legend(fontsize=style.SMALL, frameon=False)
    return figure
