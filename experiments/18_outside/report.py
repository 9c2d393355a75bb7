"""Tables and figure of methods side by side on others' problems, computed from outcomes."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from experiments.common.outcomes import Outcomes, read
from experiments.common.tables import percent, table
from gcm_learn.evaluation import chance, holm, mcnemar, wilson
from gcm_learn.plots import style

SUITES = ("MotionBenchMaker", "MotionBenchMaker in motion", "SI-RRT", "table tennis")
OURS, VAMP, TREES = "search", "vamp, frozen", "st-rrt-star, 100 ms"
SPHERES = f"{VAMP}, by its own spheres"
"""The same movements of VAMP, judged by its own geometry instead of our capsules."""
CHARGED = (20, 100)
READY = 100.0  # [ms]
LAST = 3000  # of the figure's axis [ms]
AXIS = (1, 10, 100, 1000)
COLOURS = {
    OURS: style.TARGET,
    "straight-wait": style.INK,
    TREES: style.OBSTACLE,
    VAMP: style.FAINT,
    SPHERES: style.FAINT,
}


def results(folder: Path) -> dict[str, str]:
    """Return the tables of the outcomes."""
    found = with_spheres(read(folder / "outcomes.csv.gz"))
    parts = []
    for suite in SUITES:
        mine = found.where(stratum=suite)
        if len(mine) == 0:
            continue
        blocked = _blocked(mine)
        parts += [f"## {suite}", _sizes(mine), catches(mine.where(~blocked))]
        if blocked.any():
            parts += ["With a start or goal that our capsules block:", apart(mine.where(blocked))]
    parts += ["## VAMP by its own spheres", spheres(found.where(~_blocked(found)))]
    parts += ["## Pairs, 20 ms charged", pairs(found.where(~_blocked(found)))]
    return {"table.md": "\n\n".join(parts) + "\n"}


def with_spheres(found: Outcomes) -> Outcomes:
    """Return the outcomes with VAMP's movements once more, judged by its own spheres."""
    rows = found.where(method=VAMP)
    again = rows.columns | {
        "method": np.full(len(rows), SPHERES),
        "caught": rows["met"] > 0.0,
        "complaints": rows["own_touch"],
    }
    return Outcomes({name: np.r_[column, again[name]] for name, column in found.columns.items()})


def _blocked(rows: Outcomes) -> np.ndarray:
    return (rows["start_blocked"] + rows["goal_blocked"]) > 0.0


def kept(rows: Outcomes) -> np.ndarray:
    """Mark the catches (n,) that the referee does not complain of."""
    return rows["caught"] & ~(rows["complaints"] > 0.0)


def _sizes(mine: Outcomes) -> str:
    one = mine.where(method=OURS, charge=0)
    starts, goals = int(one["start_blocked"].sum()), int(one["goal_blocked"].sum())
    packing = f"{np.median(one['pack_ms']):.1f}"
    return (
        f"{len(one)} situations; {starts} blocked starts, {goals} blocked goals. "
        f"Packing one takes {packing} ms in the median."
    )


def catches(mine: Outcomes) -> str:
    """Return what each method catches, and when."""
    head = [
        "method", "caught", "broken", "caught, 20 ms charged", "caught, 100 ms charged",
        "ms to the first catch, median / 90 %",
        "catch time relative to the best known, median / 90 %",
    ]  # fmt: skip
    free = mine.where(charge=0)
    best, lines = _best(free), []
    for name in free.methods():
        one = free.where(method=name)
        good = kept(one)
        charged = [mine.where(method=name, charge=c) for c in CHARGED]
        clock = np.where(good, one["ms"], np.inf)
        ready = one.where(good & (one["ms"] <= READY))
        first = np.array([best[key] for key in ready["situation"].tolist()])
        lines.append(
            [
                f"`{name}`",
                _share(good),
                int((one["complaints"] > 0.0).sum()),
                *(_share(kept(c)) if len(c) else "" for c in charged),
                _quantiles(clock, 1),
                _quantiles(ready["catch_time"] / first, 2),
            ]
        )
    return table(head, lines)


def _best(free: Outcomes) -> dict[str, float]:
    """Return the earliest catch that our capsules allow [s], by situation."""
    good, out = free.where(kept(free) & (free["method"] != SPHERES)), {}
    for key, time in zip(good["situation"].tolist(), good["catch_time"].tolist(), strict=True):
        out[key] = min(time, out.get(key, time))
    return out


def _share(hits: np.ndarray) -> str:
    return percent(wilson(int(hits.sum()), len(hits)))


def _quantiles(values: np.ndarray, digits: int) -> str:
    """Return median and 90 % quantile; a dash where the quantile is a failure."""
    if len(values) == 0:
        return "-"
    found = np.quantile(values, (0.5, 0.9), method="higher")
    return " / ".join(f"{v:.{digits}f}" if np.isfinite(v) else "-" for v in found)


def apart(mine: Outcomes) -> str:
    """Return what methods catch where a start or goal is blocked, in numbers."""
    free, lines = mine.where(charge=0), []
    for name in free.methods():
        one = free.where(method=name)
        starts, goals = one["start_blocked"] > 0.0, one["goal_blocked"] > 0.0
        cells = [
            f"{(kept(one) & mask).sum()} of {mask.sum()}" for mask in (starts, goals & ~starts)
        ]
        lines.append([f"`{name}`", *cells])
    return table(["method", "start blocked", "goal blocked"], lines)


def spheres(found: Outcomes) -> str:
    """Return how VAMP's movements fare by our capsules and by its own spheres."""
    head = [
        "suite", "situations", "target met", "touch our capsules", "touch its own spheres",
        "ms of the first plan, median", "of these VAMP's", "slowest period [ms], median / 90 %",
    ]  # fmt: skip
    lines = []
    for suite in SUITES:
        one = found.where(stratum=suite, method=VAMP, charge=0)
        if len(one):
            met = one["caught"]
            lines.append(
                [
                    suite,
                    len(one),
                    int(met.sum()),
                    int((one["complaints"] > 0.0).sum()),
                    int((one["own_touch"] > 0.0).sum()),
                    f"{np.median(one['ms']):.1f}",
                    f"{np.median(one['inner_ms']):.1f}",
                    _quantiles(one["slowest_ms"], 1),
                ]
            )
    return table(head, lines)


def pairs(found: Outcomes) -> str:
    """Compare ours with the others by the exact test, after Holm over all rows."""
    lines, chances = [], []
    for suite in SUITES:
        some = found.where(stratum=suite, charge=CHARGED[0])
        for other in [name for name in some.methods() if name != OURS]:
            one, two = some.by_situation((OURS, other))
            more, less, p = mcnemar(kept(one), kept(two))
            lines.append([suite, f"`{OURS}` and `{other}`", len(one), more, less])
            chances.append(p)
    rows = zip(lines, chances, holm(chances), strict=True)
    head = ["suite", "pair", "situations", "only the first", "only the second", "p", "p (Holm)"]
    return table(head, [[*line, chance(p), chance(q)] for line, p, q in rows])


def figure(found: Outcomes, path: Path) -> None:
    """Draw catches over processor time, a panel for each suite."""
    found = with_spheres(found)
    free = found.where(~_blocked(found) & (found["charge"] == 0.0))
    shown = [suite for suite in SUITES if len(free.where(stratum=suite))]
    drawn = style.new_figure(2.7 * len(shown), 3.4)
    for ax, suite in zip(np.atleast_1d(drawn.subplots(1, len(shown))), shown, strict=True):
        mine = free.where(stratum=suite)
        for name in [name for name in COLOURS if name in mine.methods()]:
            one = mine.where(method=name)
            when = np.sort(one["ms"][kept(one)])
            share = 100.0 * np.arange(1, len(when) + 1) / len(one)
            x = np.r_[0.5 * AXIS[0], when, LAST]
            y = np.r_[0.0, share, share[-1] if len(share) else 0.0]
            dashes = ":" if name == SPHERES else "-"
            ax.step(x, y, where="post", color=COLOURS[name], label=name, ls=dashes)
        ax.set_xscale("log")
        ax.set_xticks(AXIS, [str(ms) for ms in AXIS])
        ax.minorticks_off()
        ax.set(xlim=(AXIS[0], LAST), ylim=(0, 102), xlabel="processor time [ms]")
        style.title(ax, f"{suite}, {len(mine.where(method=OURS))}")
    drawn.axes[0].set_ylabel("caught, promise kept [%]")
    lines, names = drawn.axes[0].get_legend_handles_labels()
    drawn.legend(
        lines,
        names,
        loc="outside lower center",
        ncols=len(names),
        frameon=False,
        fontsize=style.SMALL,
    )
    drawn.savefig(path)
