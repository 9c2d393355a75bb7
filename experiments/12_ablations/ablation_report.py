"""Table and figure."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from gcm_learn.evaluation import difference, stratified

STRATA = ("L", "W", "Q")
CHECKS = (1, 5, 20)
SHADES = {1: "#a7d3c4", 5: "#4fa08a", 20: "#0b6e4f"}
Line = dict[str, Any]


def caught(lines: list[Line], name: str, stratum: str, checks: int) -> tuple:
    """Whether each situation was caught within so many checks; their families."""
    some = [x for x in lines if x["name"] == name and x["stratum"] == stratum]
    hits = np.array([x["caught"] and x["checks"] <= checks for x in some])
    return hits, np.array([x["family"] for x in some])


def names(lines: list[Line], part: str) -> list[str]:
    """What was tried, the whole first."""
    return list(dict.fromkeys(x["name"] for x in lines if x["part"] == part))


def write_table(file: Path, lines: list[Line], told: str) -> None:
    """Catches, and on W and Q the difference to the whole."""
    heads = [f"{s}, {k}" for s in STRATA for k in CHECKS] + [
        "W, 1 less",
        "W, 20 less",
        "Q, 20 less",
    ]
    out = []
    for part, title in (("recall", "recall"), ("encoder", "encoder")):
        every = names(lines, part)
        out += [f"| {title} | " + " | ".join(heads) + " |", "|---" * (len(heads) + 1) + "|"]
        for name in every:
            cells = []
            for s in STRATA:
                for k in CHECKS:
                    value, low, high = stratified(*caught(lines, name, s, k))
                    cells.append(f"{100 * value:.1f} ({100 * low:.0f}–{100 * high:.0f})")
            for s, k in (("W", 1), ("W", 20), ("Q", 20)):
                mine, groups = caught(lines, name, s, k)
                value, low, high = difference(mine, caught(lines, every[0], s, k)[0], groups)
                shown = f"{100 * value:+.1f} ({100 * low:+.0f}…{100 * high:+.0f})"
                cells.append("" if name == every[0] else shown)
            out.append(f"| {name} | " + " | ".join(cells) + " |")
        out.append("")
    count = len(caught(lines, names(lines, "recall")[0], "W", 1)[0])
    out.append(f"Caught [%] of {count} situations of each stratum of the split `validation`, with "
               f"at most 1, 5, 20 checked paths. {told}. 95 % intervals, bootstrapped within "
               "families; differences to the first row over the same situations.")  # fmt: skip
    file.write_text("\n".join(out) + "\n", encoding="utf-8")


def write_figure(file: Path, lines: list[Line]) -> None:
    """Catches on W and Q, a row for each thing left out."""
    figure, axes = plt.subplots(2, 2, figsize=(11.0, 6.6), sharex=True, layout="constrained",
                                height_ratios=[len(names(lines, p)) for p in ("recall", "encoder")]
                                )  # fmt: skip
    for row, part in zip(axes, ("recall", "encoder"), strict=True):
        every = names(lines, part)
        at = np.arange(len(every))[::-1]
        for ax, stratum in zip(row, ("W", "Q"), strict=True):
            for k in CHECKS:
                rates = np.array([stratified(*caught(lines, name, stratum, k)) for name in every])
                ax.hlines(at, 100 * rates[:, 1], 100 * rates[:, 2], color=SHADES[k], lw=2)
                ax.plot(100 * rates[:, 0], at, "o", color=SHADES[k], ms=5,
                        label=f"{k} check{'s' * (k > 1)}")  # fmt: skip
            ax.set(title=f"{part}: {stratum}", xlim=(0, 101))
            ax.set_yticks(at, every if ax is row[0] else [""] * len(every))
            ax.grid(alpha=0.25)
    for ax in axes[1]:
        ax.set_xlabel("caught [%]")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, frameon=False)
    figure.savefig(file, dpi=110)
    plt.close(figure)
