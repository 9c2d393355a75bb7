"""The table and the figure, computed from outcomes."""

from __future__ import annotations

from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from experiments.common.comparing import complaints, share, times
from experiments.common.outcomes import Outcomes, read
from experiments.common.tables import table
from gcm_learn.evaluation import stratified

REACHABLE = ("L", "W", "Q")
WORDS = {
    "U": "U: out of reach",
    "L": "L: a straight line does",
    "W": "W: a way round",
    "Q": "Q: only with waiting",
}
SHARES = (0.5, 0.95)  # of processor times
SOON = 1e-6  # the oracle's catches at once have no ratio [s]


def results(folder: Path) -> dict[str, str]:
    """Return the table of the outcomes."""
    return {"table.md": tabled(read(folder / "outcomes.csv.gz"))}


def tabled(found: Outcomes) -> str:
    """Return catches over reachable by stratum, times over the oracle's, latency, complaints."""
    one = found.where(method="layered")
    counts = {s: len(one.where(stratum=s)) for s in WORDS}
    still_open = int(np.sum((one["decided"] == 0) & (one["stratum"] == "U")))
    note = (
        f"Situations: {counts} from {len(set(one['family'].tolist()))} families. "
        f"In {still_open} of U the oracle neither found a catch nor ruled it out. "
        "Some planners answered fewer: the first of each stratum."
    )
    head = [
        "planner", "number", *REACHABLE, " + ".join(REACHABLE), "time / oracle's, median (90 %)",
        "U caught", "ms", "95 %", "complaints",
    ]  # fmt: skip
    names = _order(found)
    caught = table(head, [_row(found, name) for name in names])
    clock = "Processor time by stratum [ms], median / 95 %:"
    spent = table(
        ["planner", *(f"{s}, ms" for s in WORDS)], [_spent(found, name) for name in _order(found)]
    )
    return "\n\n".join([note, caught, clock, spent]) + "\n"


def _spent(found: Outcomes, name: str) -> list[str]:
    mine = found.where(method=name)
    return [f"`{name}`", *(" / ".join(times(mine.where(stratum=s), SHARES)) for s in WORDS)]


def _row(found: Outcomes, name: str) -> list[str]:
    mine = found.where(method=name)
    shares = [share(mine.where(stratum=s), 1) for s in (*REACHABLE, REACHABLE)]
    both = mine.where(mine["caught"] & (mine["oracle"] > SOON), stratum=REACHABLE)
    ratio = both["catch_time"] / both["oracle"]
    late = f"{np.median(ratio):.3f} ({np.percentile(ratio, 90):.2f})"
    lost = str(int(mine.where(stratum="U")["caught"].sum()))
    clock = times(mine, SHARES)
    return [f"`{name}`", str(len(mine)), *shares, late, lost, *clock, complaints(mine)]


def _hard(rows: Outcomes) -> float:
    """Return the share that is caught where a straight line does not do."""
    return float(rows.where(stratum=("W", "Q"))["caught"].mean())


def _order(found: Outcomes) -> list[str]:
    """Return the planners by what they catch of W and Q."""
    return sorted(found.methods(), key=lambda name: _hard(found.where(method=name)))


def write_figure(file: Path, found: Outcomes) -> None:
    """Draw catch rates by stratum and planner, with intervals."""
    names = _order(found)
    figure, axes = plt.subplots(1, 3, figsize=(11, 0.42 * len(names) + 1.6), sharey=True)
    for ax, stratum in zip(axes, REACHABLE, strict=True):
        for row, name in enumerate(names):
            mine = found.where(method=name, stratum=stratum)
            value, low, high = (100 * one for one in stratified(mine["caught"], mine["family"]))
            colour = "tab:red" if name.startswith("layered") else "0.55"
            ax.barh(row, value, color=colour, alpha=0.85, height=0.7)
            ax.plot([low, high], [row, row], color="black", lw=1.2)
            inside = value >= 10
            place, colour = (2, "white") if inside else (value + 2, "black")
            ax.text(place, row, f"{value:.0f}", va="center", color=colour, fontsize=8)
        ax.set(title=WORDS[stratum], xlim=(0, 101), xlabel="caught [% of reachable]")
        for side in ("top", "right"):
            ax.spines[side].set_visible(False)
    axes[0].set_yticks(range(len(names)), names)
    figure.tight_layout()
    figure.savefig(file, dpi=150)
    plt.close(figure)
