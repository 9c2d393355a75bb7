"""The table and the figure."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from gcm_learn.evaluation import stratified

STRATA = ("L", "W", "Q")
CHECKS = (1, 5, 20)
COLOURS = {"learned": "#0b6e4f", "raw": "#c1666b", "pca": "#d4a017", "random": "#7d8597"}
Line = dict[str, Any]


def rate(lines: list[Line], checks: int) -> tuple[float, float, float]:
    """Share caught within so many checks, and its interval [%]."""
    caught = np.array([line["caught"] and line["checks"] <= checks for line in lines])
    family = np.array([line["family"] for line in lines])
    value, low, high = stratified(caught, family)
    return 100.0 * value, 100.0 * low, 100.0 * high


def _groups(lines: list[Line]) -> dict[tuple[str, int], list[Line]]:
    groups: dict[tuple[str, int], list[Line]] = {}
    for line in lines:
        groups.setdefault((line["planner"], line["size"]), []).append(line)
    return groups


def write_table(file: Path, lines: list[Line]) -> None:
    """Catches of what some planner of the dataset catches, by stratum and checks."""
    heads = [f"{s}, {k}" for s in STRATA for k in CHECKS]
    rows = ["| found by | memories | " + " | ".join(heads) + " | ms | 95 % |",
            "|---|---|" + "---|" * (len(heads) + 2)]  # fmt: skip
    for (name, size), group in sorted(_groups(lines).items(), key=lambda x: (x[0][1], x[0][0])):
        cells = []
        for stratum in STRATA:
            some = [line for line in group if line["stratum"] == stratum]
            recalls = name in COLOURS
            for k in CHECKS:
                if not recalls and k != CHECKS[-1]:
                    cells.append("")
                    continue
                value, low, high = rate(some, k)
                cells.append(f"{value:.1f} ({low:.0f}–{high:.0f})")
        ms = [line["ms"] for line in group]
        cells += [f"{np.median(ms):.2f}", f"{np.percentile(ms, 95):.2f}"]
        rows.append(f"| {name} | {size or ''} | " + " | ".join(cells) + " |")
    count = len(next(iter(_groups(lines).values())))
    rows += ["", f"Catches [%] with at most so many checked paths, in {count} situations; "
             "95 % intervals; processor time of an answer: median and 95 % quantile."]  # fmt: skip
    file.write_text("\n".join(rows) + "\n", encoding="utf-8")


def write_figure(file: Path, lines: list[Line]) -> None:
    """Catch rate against the number of memories."""
    groups = _groups(lines)
    sizes = sorted({size for _, size in groups if size})
    figure, axes = plt.subplots(1, 3, figsize=(11.0, 3.8), sharey=True)
    styles = {1: ":", 5: "--", 20: "-"}
    for ax, stratum in zip(axes, STRATA, strict=True):
        for name, colour in COLOURS.items():
            for k, style in styles.items():
                here = [s for s in sizes if (name, s) in groups]
                rates = [
                    rate([x for x in groups[name, s] if x["stratum"] == stratum], k) for s in here
                ]
                if not rates:
                    continue
                middle, low, high = np.array(rates).T
                ax.plot(here, middle, style, color=colour, marker="o", ms=3)
                if k == CHECKS[-1]:
                    ax.fill_between(here, low, high, color=colour, alpha=0.15, lw=0)
        if ("layered", 0) in groups:
            some = [x for x in groups["layered", 0] if x["stratum"] == stratum]
            ax.axhline(rate(some, 1)[0], color="k", lw=0.8, ls=(0, (1, 3)))
        ax.set(xscale="log", title=stratum, xlabel="memories", ylim=(0, 102))
        ax.grid(alpha=0.25)
    axes[0].set_ylabel("caught [%]")
    handles = [plt.Line2D([], [], color=c, label=n) for n, c in COLOURS.items()]
    handles += [
        plt.Line2D([], [], color="k", ls=s, label=f"{k} check{'s' * (k > 1)}")
        for k, s in styles.items()
    ]
    figure.legend(handles=handles, loc="lower center", ncol=7, frameon=False, fontsize=9)
    figure.tight_layout(rect=(0, 0.08, 1, 1))
    figure.savefig(file, dpi=130)
    plt.close(figure)
