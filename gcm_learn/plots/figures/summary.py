"""Results of several planners over many situations, in numbers and as a figure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from gcm_learn.plots.figures import style

if TYPE_CHECKING:
    from gcm_learn.planners import Plan

SHADES = {
    "caught": "#8fd3ae", "unreachable": "#cbd5e0", "start_blocked": "#a0aec0", **style.FAULTS,
}  # fmt: skip
STATUSES = tuple(SHADES)
LINES = ("#2c7a7b", "#c05621", "#4a5568", "#6b46c1")  # of the planners, in their order


@dataclass(frozen=True)
class Tally:
    """What one planner achieved over a set of situations.

    Parameters
    ----------
    planner : str
    counts : dict of str to int
        Number of plans by status.
    catch_times, clearances : (k,) ndarray
        Of the catches [s] and [forearms].
    latencies : (n,) ndarray
        Planning times of all plans [ms].
    """

    planner: str
    counts: dict[str, int]
    catch_times: np.ndarray
    clearances: np.ndarray
    latencies: np.ndarray


def tally(planner: str, plans: Sequence[Plan]) -> Tally:
    """Summarise the plans of one planner."""
    caught = [plan for plan in plans if plan.status == "caught"]
    return Tally(
        planner,
        {status: sum(plan.status == status for plan in plans) for status in STATUSES},
        np.array([plan.catch_time for plan in caught], dtype=float),
        np.array([plan.clearance for plan in caught if plan.clearance is not None], dtype=float),
        np.array([plan.planning_ms for plan in plans], dtype=float),
    )


def summary_figure(tallies: Sequence[Tally]) -> Figure:
    """Draw counts by status, and how catch times, clearances and latencies are distributed.

    Parameters
    ----------
    tallies : sequence of Tally
        One per planner, at most four.

    Returns
    -------
    Figure
    """
    figure = style.new_figure(12.4, 3.3)
    counts, times, room, latency = figure.subplots(1, 4)
    _draw_counts(counts, tallies)
    _draw_spread(times, [t.catch_times for t in tallies], tallies, "catch time [s]")
    finite = [t.clearances[np.isfinite(t.clearances)] for t in tallies]
    _draw_spread(room, finite, tallies, "clearance [forearms]")
    _draw_spread(latency, [t.latencies for t in tallies], tallies, "planning time [ms]", log=True)
    if any(summary.catch_times.size for summary in tallies):
        times.legend(fontsize=style.SMALL, frameon=False, loc="lower right")
    return figure


def _draw_counts(ax: Axes, tallies: Sequence[Tally]) -> None:
    names = [t.planner for t in tallies]
    left, total = np.zeros(len(names)), sum(tallies[0].counts.values())
    for status in STATUSES:
        width = np.array([t.counts[status] for t in tallies])
        bars = ax.barh(names, width, left=left, color=SHADES[status], height=0.6)
        text = [str(w) if w > 0.06 * total else "" for w in width]
        ax.bar_label(bars, text, label_type="center", fontsize=style.SMALL, color=style.INK)
        left = left + width
    ax.invert_yaxis()
    _plain(ax, "number of situations")
    shown = [s for s in STATUSES if s not in style.FAULTS or any(t.counts[s] for t in tallies)]
    handles = [ax.patches[STATUSES.index(s) * len(names)] for s in shown]
    ax.legend(
        handles, [s.replace("_", " ") for s in shown], fontsize=style.SMALL, frameon=False,
        loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3, handlelength=1.0,
        columnspacing=0.9,
    )  # fmt: skip


def _draw_spread(
    ax: Axes, samples: Sequence[np.ndarray], tallies: Sequence[Tally], name: str, log: bool = False
) -> None:
    """Draw for every planner which share of its values lies below x."""
    _plain(ax, name)
    for sample, summary, colour in zip(samples, tallies, LINES, strict=False):
        if sample.size:
            ax.ecdf(sample, color=colour, lw=1.8, label=summary.planner)
    ax.set_ylim(0, 1.02)
    ax.set_yticks([0, 0.5, 1], ["0", "half", "all"])
    if log and any(sample.size for sample in samples):
        ax.set_xscale("log")


def _plain(ax: Axes, name: str) -> None:
    ax.set_xlabel(name, fontsize=style.LABEL, color=style.INK)
    style.plain(ax)
