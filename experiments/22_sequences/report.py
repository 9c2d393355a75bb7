"""Tables and the figure of sequences, from the outcomes."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np

from experiments.common.outcomes import Outcomes, read
from experiments.common.tables import percent, points, sections, table
from gcm_learn.evaluation.statistics import Interval

DRAWS = 4000  # of the bootstrap
PERIOD = 20  # of perception [ms]
NOISY = "outcomes-noisy.csv.gz"
MEMORY = "stored"  # in the name of methods that have one
GREEDY = ("found", "distance", "time")
GROUPS = ("greedy", "without memory", "with memory")
DRAWN = (*(f"{order}, search" for order in (*GREEDY, "bound")), "bound, synthetic after search",
         "bound, stored after search")  # fmt: skip
TITLES = {"space": "arms of four joints", "panda": "Panda"}
COLOURS = {"found": "#bbbbbb", "distance": "#888888", "time": "#555555", "bound": "#20639b",
           "synthetic": "#e08e2b", "stored": "#3caea3"}  # fmt: skip


def best_without(rows: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return for each budget the best greedy method, without memory, and with one."""
    made: dict[str, Any] = {}
    for periods in sorted({row["periods"] for row in rows}):
        shares: dict[str, float] = {}
        for name in sorted({row["method"] for row in rows}):
            mine = [r for r in rows if r["method"] == name and r["periods"] == periods]
            shares[name] = sum(r["got"] for r in mine) / sum(r["targets"] for r in mine)
        kinds = (
            [name for name in shares if name.split(", ")[0] in GREEDY],
            [name for name in shares if MEMORY not in name],
            [name for name in shares if MEMORY in name],
        )
        made[str(periods)] = {
            group: max(names, key=lambda name: shares[name])
            for group, names in zip(GROUPS, kinds, strict=True)
        } | {"shares": {name: round(share, 3) for name, share in shares.items()}}
    return made


def asked_of(choice: Mapping[str, Any]) -> set[str]:
    """Return the methods that are asked: the chosen ones, their controls, and those drawn."""
    chosen = {best[group] for best in choice.values() for group in GROUPS}
    return {*chosen, *(name.replace(MEMORY, "synthetic") for name in chosen), *DRAWN}


def results(folder: Path) -> dict[str, str]:
    """Return the tables of the outcomes."""
    found = read(folder / "outcomes.csv.gz")
    choice = json.loads((folder / "choice.json").read_text("utf-8"))
    tables = {}
    for world in choice:
        mine = found.where(world=world)
        count = len(np.unique(mine["situation"]))
        if count:
            tables[f"{world}: share of all targets, {count} sequences [%]"] = caught(mine)
            tables[f"{world}: differences of the methods chosen on validation"] = differences(
                mine, choice[world]
            )
    pages = {"table.md": sections(tables)}
    if (folder / NOISY).exists():
        pages["noisy.md"] = noisy(read(folder / NOISY))
    return pages


def noisy(found: Outcomes) -> str:
    """Return how much is caught if percepts are inexact, and how often something is touched."""
    deviations = np.unique(found["deviation"])
    head = ["method", "plans"]
    head += [f"{what}, {d:g}" for what in ("caught [%]", "touched [%]") for d in deviations]
    lines = []
    for name in found.methods():
        for habit in ("once", "broken"):
            some = found.where(method=name, habit=habit)
            each = [some.where(some["deviation"] == d) for d in deviations]
            shares = [percent(share(one["got"], one["targets"]), 1) for one in each]
            touched = [f"{100 * one['touched'].mean():.0f}" for one in each]
            lines.append([name, habit, *shares, *touched])
    count = len(np.unique(found["situation"]))
    title = f"Share of all targets of {count} sequences, by the deviation of places [forearms]"
    return sections({title: table(head, lines)})


def caught(mine: Outcomes) -> str:
    """Return how many of the targets each method catches, by periods of thinking."""
    periods = np.unique(mine["periods"])
    head = ["method", *(f"{PERIOD * p:.0f} ms" for p in periods), "complaints"]
    lines = []
    for name in mine.methods():
        some = mine.where(method=name)
        cells = [percent(share(*counts(some, p)), 1) for p in periods]
        faults = int(np.nansum(some["complaints"]))
        lines.append([name, *cells, f"{faults} of {int(some['caught'].sum())}"])
    return table(head, lines)


def counts(some: Outcomes, periods: float) -> tuple[np.ndarray, np.ndarray]:
    """Return targets caught (n,) and targets (n,) of a method's situations, in their order."""
    some = some.where(some["periods"] == periods)
    order = np.argsort(some["situation"].astype(int))
    return some["got"][order], some["targets"][order]


def share(got: np.ndarray, targets: np.ndarray) -> Interval:
    """Return the share of all targets with its interval; situations are drawn again.

    Parameters
    ----------
    got : (n,) ndarray
        Targets caught, or how many more than by another method.
    targets : (n,) ndarray
    """
    rng, n = np.random.default_rng(0), len(got)
    rows = rng.integers(n, size=(DRAWS, n))
    again = got[rows].sum(axis=1) / targets[rows].sum(axis=1)
    low, high = np.quantile(again, [0.025, 0.975])
    return Interval(float(got.sum() / targets.sum()), float(low), float(high))


def differences(mine: Outcomes, choice: Mapping[str, Any]) -> str:
    """Return differences between methods chosen on validation draws, all targets and four."""
    head = ["charged [ms]", "first", "second", "points", "points with four targets"]
    lines = []
    for periods, chosen in choice.items():
        greedy, alone, memory = (chosen[group] for group in GROUPS)
        pairs = [(memory, alone), (alone, greedy)]
        pairs += [(memory, memory.replace(MEMORY, "synthetic"))]
        for first, second in dict.fromkeys(pairs):
            cells = [gap(mine, first, second, float(periods), four) for four in (False, True)]
            lines.append([f"{PERIOD * float(periods):.0f}", first, second, *cells])
    return table(head, lines)


def gap(mine: Outcomes, first: str, second: str, periods: float, four: bool) -> str:
    """Return by how much of all targets one method catches more [points]."""
    (one, targets), (other, _) = (
        counts(mine.where(method=name), periods) for name in (first, second)
    )
    kept = targets == 4 if four else np.ones(len(targets), bool)
    return points(share((one - other)[kept], targets[kept])) if kept.any() else ""


def write_figure(file: Path, found: Outcomes) -> None:
    """Draw the share of targets against the time to think."""
    worlds = sorted(set(found["world"].tolist()), reverse=True)
    figure, axes = plt.subplots(
        1, len(worlds), figsize=(5.4 * len(worlds), 4.2), layout="constrained", squeeze=False
    )
    for ax, world in zip(axes[0], worlds, strict=True):
        mine = found.where(world=world)
        periods = np.unique(mine["periods"])
        for name in DRAWN:
            shares = [100 * share(*counts(mine.where(method=name), p)).value for p in periods]
            colour = next(
                COLOURS[word] for word in reversed(name.replace(",", "").split()) if word in COLOURS
            )
            ax.plot(PERIOD * periods, shares, "o-", ms=4, color=colour, label=name)
        ax.set(xscale="log", xlabel="time to think, charged [ms]", ylim=(0, 100))
        ax.set_title(TITLES[world])
        ax.set_xticks(PERIOD * periods, [f"{PERIOD * p:.0f}" for p in periods])
        ax.minorticks_off()
        ax.grid(alpha=0.25)
    axes[0, 0].set_ylabel("targets caught [%]")
    axes[0, -1].legend(fontsize=8, loc="lower right")
    figure.savefig(file, dpi=110)
    plt.close(figure)
