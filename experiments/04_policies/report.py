"""The table and the figure of what learners catch."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gcm_learn.evaluation import Table
from gcm_learn.plots import style

if TYPE_CHECKING:
    from run import Arm

HELP = {"scratch": "from scratch", "guide": "guided by maps", "catches": "from planned catches"}
COLOURS = {"scratch": style.FAINT, "guide": style.OBSTACLE, "catches": style.TARGET}
NAMES = {"clone": "clone, choices", "velocity": "clone, velocities", "ppo": "PPO", "sac": "SAC",
         "tqc": "TQC"}  # fmt: skip
Row = tuple["Arm", Path, Mapping[str, float]]


def write_report(folder: Path, rows: Sequence[Row]) -> None:
    """Write table.md and figure.png."""
    head = ["learner", "how", "told", "validation", *"LWQ", "touched", "best after steps"]
    lines = []
    for arm, place, scores in rows:
        told = "state, embedding" if arm.embedding else "state"
        state = json.loads((place / "state.json").read_text("utf-8"))
        names = [f"caught {stratum}" for stratum in "LWQ"] + ["touched"]
        shares = [state["scores"]["caught"], *(scores[name] for name in names)]
        cells = [f"{100 * share:.1f}" for share in shares]
        learner = [NAMES[arm.learner], HELP[arm.help], told]
        lines.append([*learner, *cells, f"{state['best']:,}"])
    (folder / "table.md").write_text(str(Table(head, lines)) + "\n", "utf-8")
    _draw(rows, folder / "figure.png")


def _draw(rows: Sequence[Row], path: Path) -> None:
    """Learning curves: a panel for each learner, broken lines where the embedding is observed."""
    learners = [name for name in ("ppo", "sac", "tqc") if any(r[0].learner == name for r in rows)]
    figure = style.new_figure(3.2 * len(learners), 3.4)
    axes = np.atleast_1d(figure.subplots(1, len(learners), sharey=True))
    for ax, learner in zip(axes, learners, strict=True):
        for arm, place, _ in rows:
            if arm.learner != learner:
                continue
            log = (place / "log.jsonl").read_text("utf-8").splitlines()
            curve = np.array([(r["steps"], r["caught"]) for r in map(json.loads, log)])
            ax.plot(
                curve[:, 0] / 1e3, 100 * curve[:, 1], color=COLOURS[arm.help], lw=1.4,
                ls="--" if arm.embedding else "-",
                label=HELP[arm.help] + (", with embedding" if arm.embedding else ""),
            )  # fmt: skip
        ax.set_title(NAMES[learner], fontsize=style.SMALL + 1)
        ax.set_xlabel("steps [thousands]", fontsize=style.SMALL)
        ax.set_ylim(0, 100)
        ax.spines[["top", "right"]].set_visible(False)
    axes[0].set_ylabel("caught, validation [%]", fontsize=style.SMALL)
    handles, labels = axes[0].get_legend_handles_labels()
    figure.legend(
        handles, labels, ncols=3, fontsize=style.SMALL, frameon=False, loc="outside lower center"
    )
    figure.savefig(path, dpi=130)
