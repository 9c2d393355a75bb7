"""Learning curves of training runs, as a table and a figure: python curves.py RUN..."""

from __future__ import annotations

import json
import sys
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np

from gcm_learn.evaluation import Table
from gcm_learn.plots import style
from gcm_learn.policies import curves

HERE = Path(__file__).parent
COLOURS = {"scratch": style.OBSTACLE, "guided": style.TARGET, "panda": style.FAINT,
           "clone": style.PATH}  # fmt: skip
HEAD = ["run", "steps", "processor hours", "steps/s", "last quarter caught", "touched",
        "steps to 95 % of it", "end"]  # fmt: skip


def rows_of(run: Path) -> list[dict[str, float]]:
    """Return the checks of a run, out of its log."""
    return [json.loads(line) for line in (run / "log.jsonl").read_text("utf-8").splitlines()]


def line_of(name: str, rows: Sequence[dict[str, float]]) -> list[str]:
    """Return a run's line of the table; its steps/s are the median from check to check."""
    last = rows[-max(len(rows) // 4, 1) :]
    caught, touched = (float(np.mean([row[key] for row in last])) for key in ("caught", "touched"))
    there = next(row["steps"] for row in rows if row["caught"] >= 0.95 * caught)
    rates = [(b["steps"] - a["steps"]) / (b["processor"] - a["processor"])
             for a, b in pairwise(rows)]  # fmt: skip
    return [
        name, f"{rows[-1]['steps']:,}", f"{rows[-1]['processor'] / 3600:.2f}",
        f"{np.median(rates):,.0f}", f"{100 * caught:.1f}", f"{100 * touched:.1f}",
        f"{there:,}", curves.in_words(rows),
    ]  # fmt: skip


def main(runs: Sequence[Path]) -> None:
    """Write curves.md and curves.png."""
    logs = {run.name: rows_of(run) for run in runs}
    lines = [line_of(name, rows) for name, rows in logs.items()]
    (HERE / "curves.md").write_text(str(Table(HEAD, lines)) + "\n", "utf-8")
    figure = style.new_figure(6.4, 3.4)
    ax = figure.subplots()
    for name, rows in logs.items():
        steps, caught = np.array([(row["steps"], row["caught"]) for row in rows]).T
        ax.plot(steps / 1e6, 100 * caught, color=COLOURS[name.partition("-")[0]], lw=1, label=name)
    ax.set_xlabel("steps [millions]", fontsize=style.SMALL)
    ax.set_ylabel("caught of the validation situations [%]", fontsize=style.SMALL)
    ax.set_ylim(0, 100)
    ax.spines[["top", "right"]].set_visible(False)
    ax.legend(fontsize=style.SMALL, frameon=False, loc="center right")
    figure.savefig(HERE / "curves.png", dpi=150)


if __name__ == "__main__":
    main([Path(argument) for argument in sys.argv[1:]])
