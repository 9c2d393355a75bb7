"""The tables, all pairs, and the figure."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
from answers import within
from questions import Question
from tally import hierarchical, holm, points, told
from trainings import FEW, PROTOTYPES, SEEDS, SIZES, STILL

from gcm_learn.evaluation import Interval, chance, difference, mcnemar, stratified, wilson
from gcm_learn.plots.figures import style
from gcm_learn.storage import write_whole

CHECKS = (1, 5, 20)
MARGIN = 0.03  # of equivalence
Found = dict[str, dict[str, Any]]


def line(*cells: str) -> str:
    """A row of a table."""
    return "| " + " | ".join(cells) + " |"


def head(*cells: str) -> list[str]:
    """The first two rows of a table."""
    return [line(*cells), "|---" * len(cells) + "|"]


def over_seeds(found: Found, name: str, seeds: Sequence[int], checks: int) -> np.ndarray:
    """What is caught (seeds, questions)."""
    return np.array([within(found[f"{name}-{seed}"], checks) for seed in seeds])


def against(first: np.ndarray, second: np.ndarray) -> tuple[Interval, float]:
    """Mean difference of (seeds, n), and the largest of McNemar's probabilities of the seeds."""
    pairs = zip(first, second, strict=True)
    worst = max(mcnemar(one, other)[2] for one, other in pairs)
    return hierarchical(first.astype(float) - second), worst


def equal(found: Found, strata: np.ndarray) -> list[str]:
    """The same catches by three indexes, at every size."""
    lines = head("N", "index", *(f"k = {k}" for k in CHECKS), *(f"W, {k}" for k in CHECKS),
                 *(f"Q, {k}" for k in CHECKS))  # fmt: skip
    for size in SIZES:
        for index in ("learned", "raw", "random"):
            cells = []
            for name in ("WQ", "W", "Q"):
                some = np.isin(strata, list(name))
                for k in CHECKS:
                    caught = over_seeds(found, f"{index}-{size}", SEEDS, k)[:, some]
                    cells.append(told(hierarchical(caught.astype(float))))
            lines.append(line(f"{size:,}", index, *cells))
    return lines


def h8(found: Found) -> list[str]:
    """Learned less raw and less random, after Holm over all that is shown."""
    tests = [(size, other, k) for size in SIZES for other in ("raw", "random") for k in CHECKS]
    gaps = []
    for size, other, k in tests:
        pair = (over_seeds(found, f"{name}-{size}", SEEDS, k) for name in ("learned", other))
        gaps.append(against(*pair))
    chances = holm([p for _, p in gaps])
    lines = head("N", "learned less", "checks", "points", "seeds", "p (Holm)")
    for (size, other, k), (gap, _), p in zip(tests, gaps, chances, strict=True):
        each = [
            100 * (within(found[f"learned-{size}-{s}"], k).mean()
                   - within(found[f"{other}-{size}-{s}"], k).mean())
            for s in SEEDS
        ]  # fmt: skip
        span = f"{min(each):+.1f} to {max(each):+.1f}"
        lines.append(line(f"{size:,}", other, str(k), points(gap), span, chance(p)))
    return lines


def seeds_apart(found: Found) -> list[str]:
    """The five encoders of the largest memories, one by one."""
    size = max(SIZES)
    lines = head("encoder", *(f"k = {k}" for k in CHECKS))
    for seed in SEEDS:
        caught = [within(found[f"learned-{size}-{seed}"], k) for k in CHECKS]
        cells = [told(wilson(int(one.sum()), len(one))) for one in caught]
        lines.append(line(f"seed {seed}", *cells))
    return lines


def needed(found: Found) -> list[str]:
    """What stands in for a memory, beside the memory of the same seeds."""
    size = max(SIZES)
    rows = {
        f"{size:,} memories, learned": f"learned-{size}",
        f"{size:,} memories, raw": f"raw-{size}",
        "regressor, 20 paths": f"regressor-{size}",
        f"{PROTOTYPES} prototypes, learned": f"prototypes-{PROTOTYPES}",
        f"{PROTOTYPES} prototypes, random": f"prototypes-{PROTOTYPES}-random",
        "1,000 memories, learned": "learned-1000",
        "1,000 memories, more situations": "wider-1000",
    }
    named = {told_: name for told_, name in rows.items() if _there(found, name)}
    tests = [(name, k) for name in list(named.values())[1:] for k in CHECKS]
    gaps = [against(_few(found, name, k), _few(found, f"learned-{size}", k)) for name, k in tests]
    known = dict(zip(tests, zip(gaps, holm([p for _, p in gaps]), strict=True), strict=True))
    lines = head("who", *(f"k = {k}" for k in CHECKS), *(f"less the first, {k}" for k in CHECKS),
                 *(f"p (Holm), {k}" for k in CHECKS))  # fmt: skip
    for shown, name in named.items():
        cells = [told(hierarchical(_few(found, name, k).astype(float))) for k in CHECKS]
        mine = [known.get((name, k)) for k in CHECKS]
        cells += ["" if one is None else points(one[0][0]) for one in mine]
        cells += ["" if one is None else chance(one[1]) for one in mine]
        lines.append(line(shown, *cells))
    return lines


def _there(found: Found, name: str) -> bool:
    return all(_seeded(name, seed) in found for seed in FEW)


def _seeded(name: str, seed: int) -> str:
    bare, dash, end = name.partition("-random")
    return f"{bare}-{seed}{dash}{end}"


def _few(found: Found, name: str, checks: int) -> np.ndarray:
    return np.array([within(found[_seeded(name, seed)], checks) for seed in FEW])


def shipped(found: Found, rows: Sequence[Question]) -> list[str]:
    """The shipped memory and its controls, by stratum."""
    strata = np.array([q.stratum for q in rows])
    families = np.array([q.family for q in rows])
    lines = head("asked", *(f"{s}, {k}" for s in "WQ" for k in CHECKS), "broken")
    for name in [name for name in found if name.startswith(("shipped", "splines"))]:
        cells = []
        for stratum in "WQ":
            some = strata == stratum
            for k in CHECKS:
                if name == "splines" and k == CHECKS[1]:
                    cells.append("")
                    continue
                caught = within(found[name], k)[some]
                cells.append(told(stratified(caught, families[some])))
        lines.append(line(name, *cells, str(found[name]["broken"])))
    return lines


def outside(splits: dict[str, Found]) -> list[str]:
    """What training left out."""
    lines = head("split", "situations", "k", "learned", "raw", "random", "same family",
                 "less raw", "p (Holm)", "less random", "p (Holm), random")  # fmt: skip
    tests, cells = [], []
    for split, found in splits.items():
        for k in CHECKS:
            caught = {name: within(one, k) for name, one in found.items()}
            mine, count = caught["shipped"], len(caught["shipped"])
            own = caught["shipped-family"] if "family" not in split else None
            shown = [
                told(wilson(int(one.sum()), count)) if one is not None and one.any() else "none"
                for one in (mine, caught["shipped-raw"], caught["shipped-random"], own)
            ]
            row = [split, str(count), str(k), *shown]
            for other in ("shipped-raw", "shipped-random"):
                gap = difference(mine, caught[other], np.zeros(count))
                tests.append(mcnemar(mine, caught[other])[2])
                row.append(points(gap))
            cells.append(row)
    chances = iter(holm(tests))
    for row in cells:
        one, other = next(chances), next(chances)
        lines.append(line(*row[:8], chance(one), row[8], chance(other)))
    return lines


def fronts(made: dict[tuple[str, str], dict[str, np.ndarray]], what: str) -> list[str]:
    """Every front before every fallback."""
    behind = list(dict.fromkeys(b for _, b in made))
    lines = head("front", *behind)
    for front in dict.fromkeys(f for f, _ in made):
        cells = []
        for fallback in behind:
            caught = made[front, fallback][what]
            cells.append(told(wilson(int(caught.sum()), len(caught))))
        lines.append(line(front, *cells))
    return lines


def pairs(made: dict[tuple[str, str], dict[str, np.ndarray]], what: str) -> list[dict[str, Any]]:
    """All pairs of hybrids with McNemar's test, after Holm."""
    both = list(combinations(made, 2))
    tests = [mcnemar(made[a][what], made[b][what]) for a, b in both]
    chances = holm([p for *_, p in tests])
    return [
        {"first": " + ".join(a), "second": " + ".join(b), "only first": x, "only second": y, "p": p}
        for (a, b), (x, y, _), p in zip(both, tests, chances, strict=True)
    ]


def chosen(found: list[dict[str, Any]], made: Any, what: str) -> list[str]:
    """Of all pairs those that tell what a front is worth before the same fallback."""
    lines = head("fallback", "learned before it, less", "points", "only learned", "only the other",
                 "p (Holm)")  # fmt: skip
    known = {(one["first"], one["second"]): one for one in found}
    for fallback in dict.fromkeys(b for _, b in made):
        for front in ("none", "raw", "random", "splines"):
            names = [f"{name} + {fallback}" for name in ("learned", front)]
            one = known.get(tuple(names)) or known[tuple(names[::-1])]
            caught = [made[name, fallback][what] for name in ("learned", front)]
            sides = (one["only first"], one["only second"])
            mine, other = sides if one["first"] == names[0] else sides[::-1]
            gap = difference(*caught, np.zeros(len(caught[0])))
            lines.append(
                line(fallback, front, points(gap), str(mine), str(other), chance(one["p"]))
            )
    return lines


def resting(groups: dict[str, Found]) -> list[str]:
    """Learned at rest less learned in motion; equivalent if the interval lies in the margin."""
    lines = head("questions", "number", "checks", "at rest", "in motion", "points (90 %)",
                 "points (95 %)", "within the margin")  # fmt: skip
    for group, found in groups.items():
        for k in (1, 20):
            still = over_seeds(found, f"still-{STILL}", FEW, k).astype(float)
            moving = over_seeds(found, f"moving-{STILL}", FEW, k).astype(float)
            narrow = hierarchical(still - moving, 0.90)
            inside = -MARGIN < narrow.low and narrow.high < MARGIN
            lines.append(line(
                group, str(still.shape[1]), str(k), told(hierarchical(still)),
                told(hierarchical(moving)), points(narrow), points(hierarchical(still - moving)),
                "yes" if inside else "no",
            ))  # fmt: skip
    return lines


def latencies(made: dict[tuple[str, str], dict[str, np.ndarray]]) -> list[str]:
    """Processor time of the hybrids [ms]: median and 90 %."""
    behind = list(dict.fromkeys(b for _, b in made))
    lines = head("front, ms", *behind)
    for front in dict.fromkeys(f for f, _ in made):
        spent = [made[front, fallback]["ms"] for fallback in behind]
        cells = [f"{np.median(ms):.1f}, {np.quantile(ms, 0.9):.1f}" for ms in spent]
        lines.append(line(front, *cells))
    return lines


def figure(path: Path, found: Found, splits: dict[str, Found]) -> None:
    """Equal experience by size, and what stands in for a memory."""
    drawn = style.new_figure(8.0, 3.0)
    left, right = drawn.subplots(1, 2)
    looks = {"learned": style.TARGET, "raw": style.OBSTACLE, "random": style.FAINT}
    for index, colour in looks.items():
        for k, dash in ((1, ":"), (20, "-")):
            shares = [
                hierarchical(over_seeds(found, f"{index}-{n}", SEEDS, k).astype(float))
                for n in SIZES
            ]
            value, low, high = 100 * np.array(shares).T
            label = index if k == 20 else None
            left.plot(SIZES, value, dash, color=colour, marker="o", ms=3, label=label)
            left.fill_between(SIZES, low, high, color=colour, alpha=0.15, lw=0)
    left.set_xscale("log")
    left.set_xlabel("catches, held and learned from")
    left.set_ylabel("caught of W and Q [%]")
    left.legend(frameon=False, title="20 checks; dotted: 1")
    names = [split.removeprefix("test-") for split in splits]
    for shift, (name, colour) in zip((-0.25, 0.0, 0.25), looks.items(), strict=True):
        key = "shipped" if name == "learned" else f"shipped-{name}"
        for k, alpha in ((20, 0.45), (1, 1.0)):
            tall = [100 * within(one[key], k).mean() for one in splits.values()]
            right.bar(np.arange(len(names)) + shift, tall, 0.23, color=colour, alpha=alpha)
    right.set_xticks(range(len(names)), names)
    right.set_title("not trained on; dark: 1 check", fontsize=9)
    drawn.savefig(path)


def sections(parts: Iterator[tuple[str, list[str]]]) -> str:
    """All tables on one page."""
    return "\n\n".join(f"## {title}\n\n" + "\n".join(lines) for title, lines in parts) + "\n"


def write_json(path: Path, values: Any) -> None:
    """A file of JSON."""
    write_whole(path, json.dumps(values, indent=1) + "\n")
