"""The tables, all pairs, and the figure."""

from __future__ import annotations

import json
from collections.abc import Sequence
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
from answers import within
from fronts import hybrids
from questions import SPLITS
from tally import points, told
from trainings import LONG, LONGER, PROTOTYPES, SEEDS, SIZES, STILL, TURNS, WHOLE

from experiments.common.questions import MOST, Question
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
from gcm_learn.plots import style
from gcm_learn.storage import write_whole

CHECKS = (1, 5, 20)
MARGIN = 0.03  # of equivalence
CONTROLS = ("shipped", "shipped-raw", "shipped-random", "shipped-family")
Found = dict[str, dict[str, Any]]
LOOKS = {"learned": style.TARGET, "raw": style.OBSTACLE, "random": style.FAINT}


def line(*cells: str) -> str:
    """A row of a table."""
    return "| " + " | ".join(cells) + " |"


def head(*cells: str) -> list[str]:
    """The first two rows of a table."""
    return [line(*cells), "|---" * len(cells) + "|"]


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
) -> list[str]:
    """The same catches by several indexes, at every size."""
    lines = head("N", "index", "seeds", *(f"k = {k}" for k in CHECKS), *(f"W, {k}" for k in CHECKS),
                 *(f"Q, {k}" for k in CHECKS))  # fmt: skip
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
                    cells.append(told(hierarchical(caught.astype(float))))
            lines.append(line(f"{size:,}", index, str(len(seeds)), *cells))
    return lines


def h8(found: Found, sizes: Sequence[int] = SIZES) -> list[str]:
    """Learned less raw, after Holm over all that is shown."""
    both = {}
    for size in sizes:
        names = [f"{index}-{size}" for index in ("learned", "raw")]
        seeds = seeds_of(found, *names)
        for k in CHECKS if seeds else ():
            both[size, k] = [over_seeds(found, name, seeds, k) for name in names]
    gaps = [hierarchical_difference(*pair) for pair in both.values()]
    chances = holm([p for _, p in gaps])
    lines = head("N", "checks", "seeds", "learned less raw", "of the seeds", "p (Holm)")
    for (size, k), (gap, _), p in zip(both, gaps, chances, strict=True):
        mine, other = both[size, k]
        each = 100 * (mine.mean(axis=1) - other.mean(axis=1))
        span = f"{each.min():+.1f} to {each.max():+.1f}"
        lines.append(line(f"{size:,}", str(k), str(len(mine)), points(gap), span, chance(p)))
    return lines


def differences(found: Found, pairs: Sequence[tuple[str, str]]) -> list[str]:
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
    lines = head("N", "which", "checks", "seeds", "points", "p (Holm)")
    for (*cells, (gap, _)), p in zip(tests, holm([p for *_, (_, p) in tests]), strict=True):
        lines.append(line(*cells, points(gap), chance(p)))
    return lines


def seeds_apart(found: Found, size: int = WHOLE) -> list[str]:
    """The encoders of memories of a size, one by one."""
    name = f"learned-{size}"
    lines = head("encoder", *(f"k = {k}" for k in CHECKS))
    for seed in seeds_of(found, name):
        caught = [within(found[_seeded(name, seed)], k) for k in CHECKS]
        cells = [told(wilson(int(one.sum()), len(one))) for one in caught]
        lines.append(line(f"seed {seed}", *cells))
    return lines


def needed(found: Found, size: int = WHOLE) -> list[str]:
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
    lines = head("who", "seeds", *heads)
    for shown, name in rows.items():
        if not seeds[name]:
            continue
        caught = [over_seeds(found, name, seeds[name], k).astype(float) for k in CHECKS]
        mine = [known.get((name, k), ("", "")) for k in CHECKS]
        cells = [told(hierarchical(one)) for one in caught] + [gap for gap, _ in mine]
        lines.append(line(shown, str(len(seeds[name])), *cells, *(p for _, p in mine)))
    return lines


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
    """Catches among the splits that training left out."""
    lines = head("split", "situations", "k", "learned", "raw", "random", "same family",
                 "less raw", "p (Holm)", "less random", "p (Holm), random")  # fmt: skip
    tests, cells = [], []
    for split, found in splits.items():
        for k in CHECKS:
            caught = {name: within(one, k) for name, one in found.items()}
            mine, count = caught["shipped"], len(caught["shipped"])
            shown = [told(wilson(int(caught[name].sum()), count)) for name in CONTROLS]
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
        for front in dict.fromkeys(front for front, _ in made if front != "learned"):
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
    lines = head("questions", "number", "seeds", "checks", "at rest", "in motion", "points (90 %)",
                 "points (95 %)", "within the margin")  # fmt: skip
    names = [f"{kind}-{STILL}" for kind in ("still", "moving")]
    for group, found in groups.items():
        seeds = seeds_of(found, *names)
        for k in (1, 20) if seeds else ():
            still, moving = (over_seeds(found, n, seeds, k).astype(float) for n in names)
            narrow, wide = (hierarchical(still - moving, share) for share in (0.90, 0.95))
            inside = -MARGIN < narrow.low and narrow.high < MARGIN
            cells = [told(hierarchical(still)), told(hierarchical(moving)), points(narrow)]
            cells += [points(wide), "yes" if inside else "no"]
            lines.append(line(group, str(still.shape[1]), str(len(seeds)), str(k), *cells))
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


def by_size(axes: Any, found: Found, sizes: Sequence[int]) -> None:
    """Shares over what was held and learned from, by index."""
    for index, colour in LOOKS.items():
        for k, dash in ((1, ":"), (20, "-")):
            names = {n: f"{index}-{n}" for n in sizes}
            there = [n for n, name in names.items() if seeds_of(found, name)]
            shares = [
                hierarchical(
                    over_seeds(found, names[n], seeds_of(found, names[n]), k).astype(float)
                )
                for n in there
            ]
            value, low, high = 100 * np.array(shares).T
            label = index if k == 20 else None
            axes.plot(there, value, dash, color=colour, marker="o", ms=3, label=label)
            axes.fill_between(there, low, high, color=colour, alpha=0.15, lw=0)
            if index == "learned":
                told_ = "within 20 checks" if k == 20 else "first choice"
                axes.text(there[0], high[0] + 1, told_, fontsize=8, va="bottom")
    axes.set_xscale("log")
    axes.set_xticks(sizes, [f"{n:,}" for n in sizes])
    axes.minorticks_off()
    axes.set_ylim(top=100)
    axes.set_xlabel("catches that are held and learned from")
    axes.set_ylabel("caught [%]")
    axes.legend(frameon=False, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncol=3)


def figure(path: Path, found: Found, splits: dict[str, Found]) -> None:
    """Equal experience by size, and what stands in for a memory."""
    drawn = style.new_figure(8.0, 3.0)
    left, right = drawn.subplots(1, 2)
    by_size(left, found, SIZES)
    names = [split.removeprefix("test-") for split in splits]
    for shift, (name, colour) in zip((-0.25, 0.0, 0.25), LOOKS.items(), strict=True):
        key = "shipped" if name == "learned" else f"shipped-{name}"
        for k, alpha in ((20, 0.45), (1, 1.0)):
            tall = [100 * within(one[key], k).mean() for one in splits.values()]
            right.bar(np.arange(len(names)) + shift, tall, 0.23, color=colour, alpha=alpha)
    right.set_xticks(range(len(names)), names)
    right.set_ylim(top=100)
    right.set_title("outside of training; dark: first choice, light: 20 checks", fontsize=8)
    drawn.savefig(path)


def write(here: Path, out: Path, suite: Path, rows: Sequence[Question], later: Path) -> None:
    """Write table.md, pairs.json and figure.png of what has been asked."""
    found = read(suite / "answers")
    all_of_them = {split: read(out / "outside" / split) for split in SPLITS}
    splits = {split: one for split, one in all_of_them.items() if set(CONTROLS) <= set(one)}
    groups = {name: read(suite / name) for name in ("W", "at rest")}
    told_ = lines_of(suite / "fronts.jsonl")
    strata = np.array([q.stratum for q in rows])
    page = {
        "Equal experience": equal(found, strata),
        "Equal experience: differences": h8(found),
        "Seeds": seeds_apart(found),
        "Is a memory needed?": needed(found),
        "The shipped memory": shipped(found, rows),
        "Not trained on": outside(splits),
    }
    if told_:
        page |= before_fallbacks(hybrids(told_), here / "pairs.json")
    page["At rest and in motion"] = resting(groups)
    more = read(later / "answers")
    turns, indexes = f"{TURNS * LONGER} turns (long), afterwards", ("long", "learned", "raw")
    page[turns] = equal(more, np.repeat(["W", "Q"], MOST), LONG, indexes)
    page[f"{turns}: differences"] = differences(more, list(combinations(indexes, 2)))
    said = judged([found, *splits.values(), *groups.values(), more], told_)
    seeds = [one.name.removeprefix("fresh-") for one in (suite, later)]
    note = (
        f"Suite of seed {seeds[0]}, of long trainings {seeds[1]}: {MOST} situations of W and "
        f"{MOST} of Q are asked of all, {len(told_) // 2} of each of fronts and fallbacks. "
        f"The referee judged {said}."
    )
    write_page(here / "table.md", page, note)
    figure(here / "figure.png", found, splits)


def write_page(path: Path, page: dict[str, list[str]], note: str) -> None:
    """Write the tables that have rows, and a note below."""
    filled = {title: lines for title, lines in page.items() if len(lines) > 2}
    write_whole(path, sections(filled) + f"\n{note}\n")


def before_fallbacks(
    made: dict[tuple[str, str], dict[str, np.ndarray]], path: Path
) -> dict[str, list[str]]:
    """Tables of fronts before fallbacks; all pairs are written to a file."""
    both = {what: pairs(made, what) for what in ("caught", "ready")}
    write_json(path, both)
    return {
        "Fronts and fallbacks: 20 ms charged": fronts(made, "caught"),
        "Fronts and fallbacks: 20 ms charged, ready by then": fronts(made, "ready"),
        "What the learned front is worth: charged": chosen(both["caught"], made, "caught"),
        "What the learned front is worth: ready": chosen(both["ready"], made, "ready"),
        "Processor time of hybrids: median, 90 %": latencies(made),
    }


def lines_of(path: Path) -> list[dict[str, Any]]:
    """Rows of a file of JSON lines, an empty list without the file."""
    return [json.loads(x) for x in path.read_text("utf-8").splitlines()] if path.exists() else []


def read(folder: Path) -> Found:
    """All answers of a folder."""
    return {
        file.stem: json.loads(file.read_text("utf-8")) for file in sorted(folder.glob("*.json"))
    }


def judged(groups: list[Found], told_: list[dict[str, Any]]) -> str:
    """Numbers of catches that the referee has judged and found at fault."""
    answers = [one for group in groups for one in group.values()]
    catches = sum(sum(one["first"]) + sum(one["caught"]) for one in answers)
    broken = sum(one["broken"] for one in answers)
    parts = [part for one in told_ for part in one.values() if isinstance(part, list)]
    catches += sum(part[0] for part in parts)
    broken += sum(part[2] for part in parts)
    return f"{catches:,} catches and found fault with {broken}"


def sections(parts: dict[str, list[str]]) -> str:
    """All tables on one page."""
    return "\n\n".join(f"## {t}\n\n" + "\n".join(lines) for t, lines in parts.items()) + "\n"


def write_json(path: Path, values: Any) -> None:
    """A file of JSON."""
    write_whole(path, json.dumps(values, indent=1) + "\n")
