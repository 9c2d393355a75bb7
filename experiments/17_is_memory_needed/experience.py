"""Tables of memories with the same experience, of stand-ins, and of questions off its ranges."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from answers import within
from trainings import LONG, PROTOTYPES, SEEDS, SIZES, STILL, WHOLE

from experiments.common.questions import Question
from experiments.common.tables import percent, points, table
from gcm_learn.evaluation import (
    chance,
    difference,
    hierarchical,
    hierarchical_difference,
    holm,
    mcnemar,
    stratified,
    wilson,
)

CHECKS = (1, 5, 20)
MARGIN = 0.03  # of equivalence
CONTROLS = ("shipped", "shipped-raw", "shipped-random", "shipped-family")
Found = dict[str, dict[str, Any]]


def seeds_of(found: Found, *names: str) -> list[int]:
    """Training seeds with which all of these were asked."""
    return [seed for seed in SEEDS if all(_seeded(name, seed) in found for name in names)]


def _seeded(name: str, seed: int) -> str:
    bare, dash, end = name.partition("-random")
    return f"{bare}-{seed}{dash}{end}"


def over_seeds(found: Found, name: str, seeds: Sequence[int], checks: int) -> np.ndarray:
    """Catches (seeds, questions)."""
    return np.array([within(found[_seeded(name, seed)], checks) for seed in seeds])


def equal(
    found: Found,
    strata: np.ndarray,
    sizes: Sequence[int] = SIZES,
    indexes: Sequence[str] = ("learned", "raw", "random"),
) -> str:
    """The same catches by several indexes, at every size."""
    asked = [f"{what}{k}" for what in ("k = ", "W, ", "Q, ") for k in CHECKS]
    head, lines = ["N", "index", "seeds", *asked], []
    for size in sizes:
        for index in indexes:
            seeds = seeds_of(found, f"{index}-{size}")
            if not seeds:
                continue
            cells = []
            for name in ("WQ", "W", "Q"):
                some = np.isin(strata, list(name))
                for k in CHECKS:
                    caught = over_seeds(found, f"{index}-{size}", seeds, k)[:, some]
                    cells.append(percent(hierarchical(caught.astype(float))))
            lines.append([f"{size:,}", index, str(len(seeds)), *cells])
    return table(head, lines)


def h8(found: Found, sizes: Sequence[int] = SIZES) -> str:
    """Learned less raw, after Holm over all that is shown."""
    both = {}
    for size in sizes:
        names = [f"{index}-{size}" for index in ("learned", "raw")]
        seeds = seeds_of(found, *names)
        for k in CHECKS if seeds else ():
            both[size, k] = [over_seeds(found, name, seeds, k) for name in names]
    gaps = [hierarchical_difference(*pair) for pair in both.values()]
    chances = holm([p for _, p in gaps])
    head, lines = ["N", "checks", "seeds", "learned less raw", "of the seeds", "p (Holm)"], []
    for (size, k), (gap, _), p in zip(both, gaps, chances, strict=True):
        mine, other = both[size, k]
        each = 100 * (mine.mean(axis=1) - other.mean(axis=1))
        span = f"{each.min():+.1f} to {each.max():+.1f}"
        lines.append([f"{size:,}", str(k), str(len(mine)), points(gap), span, chance(p)])
    return table(head, lines)


def differences(found: Found, pairs: Sequence[tuple[str, str]]) -> str:
    """Difference of the catches of each pair, after Holm over all that is shown."""
    tests = []
    for size in LONG:
        for pair in pairs:
            names = [f"{index}-{size}" for index in pair]
            seeds = seeds_of(found, *names)
            for k in CHECKS if seeds else ():
                gap = hierarchical_difference(
                    *(over_seeds(found, name, seeds, k) for name in names)
                )
                tests.append((f"{size:,}", " less ".join(pair), str(k), str(len(seeds)), gap))
    head, lines = ["N", "which", "checks", "seeds", "points", "p (Holm)"], []
    for (*cells, (gap, _)), p in zip(tests, holm([p for *_, (_, p) in tests]), strict=True):
        lines.append([*cells, points(gap), chance(p)])
    return table(head, lines)


def seeds_apart(found: Found, size: int = WHOLE) -> str:
    """The encoders of memories of a size, one by one."""
    name = f"learned-{size}"
    head, lines = ["encoder", *(f"k = {k}" for k in CHECKS)], []
    for seed in seeds_of(found, name):
        caught = [within(found[_seeded(name, seed)], k) for k in CHECKS]
        cells = [percent(wilson(int(one.sum()), len(one))) for one in caught]
        lines.append([f"seed {seed}", *cells])
    return table(head, lines)


def needed(found: Found, size: int = WHOLE) -> str:
    """Stand-ins for a memory, beside the memory of the same seeds."""
    first, few = f"learned-{size}", f"prototypes-{PROTOTYPES}"
    rows = {
        f"{size:,} memories, learned": first,
        f"{size:,} memories, raw": f"raw-{size}",
        "regressor, 20 paths": f"regressor-{size}",
        f"{PROTOTYPES} prototypes, learned": few,
        f"{PROTOTYPES} prototypes, random": f"{few}-random",
        "1,000 memories, learned": "learned-1000",
    }
    seeds = {name: seeds_of(found, name, first) for name in rows.values()}
    others = [(name, k) for name in list(rows.values())[1:] if seeds[name] for k in CHECKS]
    gaps = [
        hierarchical_difference(*(over_seeds(found, one, seeds[name], k) for one in (name, first)))
        for name, k in others
    ]
    chances = holm([p for _, p in gaps])
    known = {
        test: (points(gap), chance(p))
        for test, (gap, _), p in zip(others, gaps, chances, strict=True)
    }
    heads = [f"{what}{k}" for what in ("k = ", "less the first, ", "p (Holm), ") for k in CHECKS]
    head, lines = ["who", "seeds", *heads], []
    for shown, name in rows.items():
        if not seeds[name]:
            continue
        caught = [over_seeds(found, name, seeds[name], k).astype(float) for k in CHECKS]
        mine = [known.get((name, k), ("", "")) for k in CHECKS]
        cells = [percent(hierarchical(one)) for one in caught] + [gap for gap, _ in mine]
        lines.append([shown, str(len(seeds[name])), *cells, *(p for _, p in mine)])
    return table(head, lines)


def shipped(found: Found, rows: Sequence[Question]) -> str:
    """The shipped memory and its controls, by stratum."""
    strata = np.array([q.stratum for q in rows])
    families = np.array([q.family for q in rows])
    head, lines = ["asked", *(f"{s}, {k}" for s in "WQ" for k in CHECKS), "broken"], []
    for name in [name for name in found if name.startswith(("shipped", "splines"))]:
        cells = []
        for stratum in "WQ":
            some = strata == stratum
            for k in CHECKS:
                if name == "splines" and k == CHECKS[1]:
                    cells.append("")
                    continue
                caught = within(found[name], k)[some]
                cells.append(percent(stratified(caught, families[some])))
        lines.append([name, *cells, str(found[name]["broken"])])
    return table(head, lines)


def outside(splits: dict[str, Found]) -> str:
    """Catches among the splits that training left out."""
    head = ["split", "situations", "k", "learned", "raw", "random", "same family"]
    head += ["less raw", "p (Holm)", "less random", "p (Holm), random"]
    lines = []
    tests, cells = [], []
    for split, found in splits.items():
        for k in CHECKS:
            caught = {name: within(one, k) for name, one in found.items()}
            mine, count = caught["shipped"], len(caught["shipped"])
            shown = [percent(wilson(int(caught[name].sum()), count)) for name in CONTROLS]
            row = [split, str(count), str(k), *shown]
            for other in ("shipped-raw", "shipped-random"):
                gap = difference(mine, caught[other], np.zeros(count))
                tests.append(mcnemar(mine, caught[other])[2])
                row.append(points(gap))
            cells.append(row)
    chances = iter(holm(tests))
    for row in cells:
        one, other = next(chances), next(chances)
        lines.append([*row[:8], chance(one), row[8], chance(other)])
    return table(head, lines)


def resting(groups: dict[str, Found]) -> str:
    """Learned at rest less learned in motion; equivalent if the interval lies in the margin."""
    head, lines = ["questions", "number", "seeds", "checks", "at rest", "in motion"], []
    head += ["points (90 %)", "points (95 %)", "within the margin"]
    names = [f"{kind}-{STILL}" for kind in ("still", "moving")]
    for group, found in groups.items():
        seeds = seeds_of(found, *names)
        for k in (1, 20) if seeds else ():
            still, moving = (over_seeds(found, n, seeds, k).astype(float) for n in names)
            narrow, wide = (hierarchical(still - moving, share) for share in (0.90, 0.95))
            inside = -MARGIN < narrow.low and narrow.high < MARGIN
            cells = [percent(hierarchical(still)), percent(hierarchical(moving)), points(narrow)]
            cells += [points(wide), "yes" if inside else "no"]
            lines.append([group, str(still.shape[1]), str(len(seeds)), str(k), *cells])
    return table(head, lines)
