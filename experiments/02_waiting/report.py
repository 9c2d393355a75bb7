"""The table and the figure."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from answers import Answer

from experiments.common.suite import STRATA, Case
from gcm_learn.evaluation import stratified

REACHABLE = ("L", "W", "Q")
WORDS = {
    "U": "U: out of reach",
    "L": "L: a straight line does",
    "W": "W: a way round",
    "Q": "Q: only with waiting",
}


def _columns(cases: list[Case], answers: list[Answer]) -> dict[str, np.ndarray]:
    """Arrays (m,) over the cases that a planner has answered."""
    by_index = {case.index: case for case in cases}
    mine = [by_index[answer.index] for answer in answers]
    return {
        "stratum": np.array([case.stratum for case in mine]),
        "family": np.array([case.family for case in mine]),
        "reference": np.array([min(case.upper, 1e9) for case in mine]),
        "lower": np.array([case.lower for case in mine]),
        "caught": np.array([answer.caught for answer in answers]),
        "time": np.array([answer.catch_time for answer in answers]),
        "ms": np.array([answer.planning_ms for answer in answers]),
        "broken": np.array([answer.broken for answer in answers]),
    }


def write_table(
    file: Path,
    config: dict[str, Any],
    cases: list[Case],
    seen: dict[str, int],
    answers: dict[str, list[Answer]],
) -> None:
    """Catches over reachable by stratum, times over the oracle's, latency, broken promises."""
    counts = {s: sum(c.stratum == s for c in cases) for s in STRATA}
    open_cases = sum(not c.decided for c in cases)
    families = len({case.family for case in cases})
    lines = [
        f"Situations: {counts} from {families} families, seed {config['seed']}; draws by kind: "
        f"{dict(sorted(seen.items()))}. "
        f"In {open_cases} of U the oracle neither found a catch nor ruled it out.",
        "",
        "| planner | L | W | Q | L + W + Q | time / oracle's, median (90 %) | U caught "
        "| ms, median (95 %) | broken |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    lines += [_row(name, _columns(cases, answers[name])) for name in answers]
    file.write_text("\n".join(lines) + "\n")


def _row(name: str, c: dict[str, np.ndarray]) -> str:
    cells = []
    for strata in (("L",), ("W",), ("Q",), REACHABLE):
        here = np.isin(c["stratum"], strata)
        _, low, high = stratified(c["caught"][here], c["family"][here])
        cells.append(f"{100 * c['caught'][here].mean():.1f} ({100 * low:.1f}-{100 * high:.1f})")
    both = c["caught"] & np.isin(c["stratum"], REACHABLE) & (c["reference"] > 1e-6)
    ratio = c["time"][both] / c["reference"][both]
    cells.append(f"{np.median(ratio):.3f} ({np.percentile(ratio, 90):.2f})")
    cells.append(str(int(c["caught"][c["stratum"] == "U"].sum())))
    cells.append(f"{np.median(c['ms']):.2f} ({np.percentile(c['ms'], 95):.1f})")
    cells.append(str(int(c["broken"].sum())))
    return f"| `{name}` | {' | '.join(cells)} |"


def _hard(columns: dict[str, np.ndarray]) -> float:
    """Share that is caught where a straight line does not do."""
    return float(columns["caught"][np.isin(columns["stratum"], ("W", "Q"))].mean())


def write_figure(file: Path, cases: list[Case], answers: dict[str, list[Answer]]) -> None:
    """Catch rate by stratum and planner, with intervals."""
    names = sorted(answers, key=lambda name: _hard(_columns(cases, answers[name])))
    figure, axes = plt.subplots(1, 3, figsize=(11, 0.42 * len(names) + 1.6), sharey=True)
    for ax, stratum in zip(axes, REACHABLE, strict=True):
        for row, name in enumerate(names):
            c = _columns(cases, answers[name])
            here = c["stratum"] == stratum
            share = 100 * c["caught"][here].mean()
            _, low, high = stratified(c["caught"][here], c["family"][here])
            colour = "tab:red" if name.startswith("layered") else "0.55"
            ax.barh(row, share, color=colour, alpha=0.85, height=0.7)
            ax.plot([100 * low, 100 * high], [row, row], color="black", lw=1.2)
            inside = share >= 10
            place, colour = (2, "white") if inside else (share + 2, "black")
            ax.text(place, row, f"{share:.0f}", va="center", color=colour, fontsize=8)
        ax.set(title=WORDS[stratum], xlim=(0, 101), xlabel="caught [% of reachable]")
        for side in ("top", "right"):
            ax.spines[side].set_visible(False)
    axes[0].set_yticks(range(len(names)), names)
    figure.tight_layout()
    figure.savefig(file, dpi=150)
    plt.close(figure)
