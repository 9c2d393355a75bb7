"""Tables and figures of memories with the same experience, computed from outcomes."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from experiments.common.outcomes import Outcomes, read
from experiments.common.tables import percent, points, sections, table
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

CHECKS = (1, 5, 20)
WHOLE = "10000"  # catches of memories that others stand in for
MARGIN = 0.03  # of equivalence
WORLDS = ("at rest", "in motion")
SPLITS = ("test-pendulum", "test-long-arm", "test-fast", "test-crowded")
CONTROLS = ("shipped", "shipped-raw", "shipped-random", "shipped-family")
LOOKS = {"learned": style.TARGET, "raw": style.OBSTACLE, "random": style.FAINT}
INSTEAD = {
    f"{int(WHOLE):,} memories, learned": f"learned-{WHOLE}",
    f"{int(WHOLE):,} memories, raw": f"raw-{WHOLE}",
    "regressor, 20 paths": "regressor",
    "100 prototypes, learned": "prototypes",
    "100 prototypes, random": "prototypes, random",
    "1,000 memories, learned": "learned-1000",
}
BARS = ("memories", "prototypes", "any of them", "regressor")
SUITES = {name: f"frozen{name}.json" for name in ("", "-space", "-longer")}
"""Files with the seeds of the suites, by the end of the names of their results."""


def results(folder: Path) -> dict[str, str]:
    """Return the tables of the suites whose outcomes are kept."""
    pages = {}
    for end, frozen in SUITES.items():
        file = folder / f"outcomes{end}.csv.gz"
        if file.exists():
            seed = json.loads((folder / frozen).read_text("utf-8"))["seed"]
            pages[f"table{end}.md"] = page(read(file), seed)
    return pages


def page(found: Outcomes, seed: int) -> str:
    """Return all tables that have rows, and a note below."""
    fresh = found.where(split="fresh")
    tables = {
        "Equal experience": equal(fresh),
        "Equal experience: differences": h8(fresh),
        "Five times the turns": longer(fresh),
        "Seeds": seeds_apart(fresh),
        "Is a memory needed?": needed(fresh),
        "Fewer memories, shipped order": fewer(fresh),
        "The shipped memory": shipped(fresh),
        "Not trained on": outside(found),
        "At rest and in motion": resting(found),
    }
    filled = {title: text for title, text in tables.items() if text.count("\n") > 1}
    first = fresh.where(method=fresh.methods()[:1])
    first = first.where(seed=int(first["seed"][0]))
    counts = [int(np.sum(first["stratum"] == name)) for name in "WQ"]
    judged = found.where(np.isfinite(found["complaints"]))
    return (
        f"{sections(filled)}\n"
        f"Suite of seed {seed}: {counts[0]} situations of W and {counts[1]} of Q. The referee "
        f"judged {catches_of(judged):,} of {catches_of(found):,} catches and found fault with "
        f"{judged['complaints'].sum():.0f}.\n"
    )


def catches_of(rows: Outcomes) -> int:
    """Return the number of catches, with one check and within twenty."""
    return int(rows["caught"].sum() + rows["first"].sum())


def within(rows: Outcomes, checks: int) -> np.ndarray:
    """Mark the rows (n,) that are caught with so many checks; with one there is no other try."""
    return rows["first"] == 1 if checks == 1 else rows["caught"] & (rows["checks"] <= checks)


def seeds_of(found: Outcomes, *methods: str) -> list[int]:
    """Return the training seeds with which all of these were asked."""
    each = [set(found.where(method=name)["seed"].tolist()) for name in methods]
    return sorted(int(seed) for seed in set.intersection(*each))


def over_seeds(found: Outcomes, method: str, seeds: Sequence[int], checks: int) -> np.ndarray:
    """Return the catches (seeds, situations) of a method."""
    rows = found.where(method=method)
    caught = within(rows, checks)
    return np.array([caught[rows["seed"] == seed] for seed in seeds])


def sizes_of(found: Outcomes) -> list[int]:
    """Return the numbers of catches that encoders have learned from."""
    names = [name.split("-") for name in found.methods()]
    return sorted(int(name[1]) for name in names if name[0] == "learned")


def equal(found: Outcomes) -> str:
    """Return catches with the same experience by several indexes, at every size."""
    asked = [f"{what}{k}" for what in ("k = ", "W, ", "Q, ") for k in CHECKS]
    lines = []
    for size in sizes_of(found):
        for index in LOOKS:
            method = f"{index}-{size}"
            seeds = seeds_of(found, method)
            cells = [
                percent(hierarchical(over_seeds(some, method, seeds, k).astype(float)))
                for some in (found, *(found.where(stratum=name) for name in "WQ"))
                for k in CHECKS
            ]
            lines.append([f"{size:,}", index, str(len(seeds)), *cells])
    return table(["N", "index", "seeds", *asked], lines)


def h8(found: Outcomes) -> str:
    """Return learned less raw, after Holm over all that is shown."""
    lines, chances = [], []
    for size in sizes_of(found):
        names = [f"{index}-{size}" for index in ("learned", "raw")]
        seeds = seeds_of(found, *names)
        for k in CHECKS:
            mine, other = (over_seeds(found, name, seeds, k) for name in names)
            gap, p = hierarchical_difference(mine, other)
            each = 100 * (mine.mean(axis=1) - other.mean(axis=1))
            span = f"{each.min():+.1f} to {each.max():+.1f}"
            lines.append([f"{size:,}", str(k), str(len(seeds)), points(gap), span])
            chances.append(p)
    head = ["N", "checks", "seeds", "learned less raw", "of the seeds", "p (Holm)"]
    corrected = zip(lines, holm(chances), strict=True)
    return table(head, [[*line, chance(p)] for line, p in corrected])


def longer(found: Outcomes) -> str:
    """Return what more turns of training gain, after Holm over all that is shown."""
    lines, chances = [], []
    for size in sizes_of(found) if any("brief" in name for name in found.methods()) else ():
        names = [f"{turns}-{size}" for turns in ("learned", "brief")]
        seeds = seeds_of(found, *names)
        for k in CHECKS:
            caught = [over_seeds(found, name, seeds, k) for name in names]
            gap, p = hierarchical_difference(*caught)
            shares = [percent(hierarchical(one.astype(float))) for one in caught]
            lines.append([f"{size:,}", str(k), str(len(seeds)), *shares, points(gap)])
            chances.append(p)
    head = ["N", "checks", "seeds", "many turns", "few turns", "difference", "p (Holm)"]
    corrected = zip(lines, holm(chances), strict=True)
    return table(head, [[*line, chance(p)] for line, p in corrected])


def fewer(found: Outcomes) -> str:
    """Return some of the shipped memories less all of them, after Holm over all that is shown."""
    names = [n for n in found.methods() if n.split("-")[0] in ("medoids", "drawn")]
    whole = found.where(method="shipped")
    lines, chances = [], []
    for name in sorted(names, key=lambda n: (n.split("-")[0], int(n.split("-")[1]))):
        seeds, (kind, count) = seeds_of(found, name), name.split("-")
        gaps, cells = [], []
        for k in CHECKS:
            caught = over_seeds(found, name, seeds, k)
            everything = np.broadcast_to(within(whole, k), caught.shape)
            cells.append(percent(hierarchical(caught.astype(float))))
            gaps.append(hierarchical_difference(caught, everything))
        lines.append(
            [kind, f"{int(count):,}", str(len(seeds)), *cells, *(points(g) for g, _ in gaps)]
        )
        chances += [p for _, p in gaps]
    head = ["chosen", "memories", "seeds", *(f"k = {k}" for k in CHECKS)]
    head += [f"{what}{k}" for what in ("less all, ", "p (Holm), ") for k in CHECKS]
    each = [chance(p) for p in holm(chances)]
    rows = [[*line, *each[3 * n : 3 * n + 3]] for n, line in enumerate(lines)]
    return table(head, rows)


def seeds_apart(found: Outcomes) -> str:
    """Return the encoders of memories of one size, one by one."""
    lines, method = [], f"learned-{WHOLE}"
    for seed in seeds_of(found, method):
        caught = [over_seeds(found, method, [seed], k)[0] for k in CHECKS]
        cells = [percent(wilson(int(one.sum()), len(one))) for one in caught]
        lines.append([f"seed {seed}", *cells])
    return table(["encoder", *(f"k = {k}" for k in CHECKS)], lines)


def needed(found: Outcomes) -> str:
    """Return substitutes for a memory, beside the memory of the same seeds."""
    first, *others = INSTEAD.values()
    seeds = {name: seeds_of(found, name, first) for name in INSTEAD.values()}
    gaps = {
        (name, k): hierarchical_difference(
            *(over_seeds(found, one, seeds[name], k) for one in (name, first))
        )
        for name in others
        for k in CHECKS
        if seeds[name]
    }
    chances = dict(zip(gaps, holm([p for _, p in gaps.values()]), strict=True))
    lines = []
    for shown, name in INSTEAD.items():
        caught = [over_seeds(found, name, seeds[name], k).astype(float) for k in CHECKS]
        asked = [(name, k) for k in CHECKS]
        less = [points(gaps[one][0]) if one in gaps else "" for one in asked]
        p = [chance(chances[one]) if one in gaps else "" for one in asked]
        if seeds[name]:
            shares = [percent(hierarchical(one)) for one in caught]
            lines.append([shown, str(len(seeds[name])), *shares, *less, *p])
    heads = [f"{what}{k}" for what in ("k = ", "less the first, ", "p (Holm), ") for k in CHECKS]
    return table(["method", "seeds", *heads], lines)


def shipped(found: Outcomes) -> str:
    """Return the shipped memory and its controls, by stratum."""
    lines = []
    for name in found.methods():
        if not name.startswith(("shipped", "splines")):
            continue
        mine, cells = found.where(method=name), []
        for stratum in "WQ":
            some = mine.where(stratum=stratum)
            for k in CHECKS:
                unknown = name == "splines" and k == CHECKS[1]  # it says not how many it took
                shown = percent(stratified(within(some, k), some["family"]))
                cells.append("" if unknown else shown)
        lines.append([name, *cells])
    return table(["asked", *(f"{s}, {k}" for s in "WQ" for k in CHECKS)], lines)


def outside(found: Outcomes) -> str:
    """Return catches among the splits that training left out."""
    head = ["split", "situations", "k", "learned", "raw", "random", "same family"]
    head += ["less raw", "p (Holm)", "less random", "p (Holm), random"]
    chances, cells = [], []
    for split in SPLITS:
        some = found.where(split=split)
        for k in CHECKS if len(some) else ():
            caught = {name: within(some.where(method=name), k) for name in CONTROLS}
            mine, count = caught["shipped"], len(caught["shipped"])
            row = [split, str(count), str(k)]
            row += [percent(wilson(int(one.sum()), count)) for one in caught.values()]
            for other in ("shipped-raw", "shipped-random"):
                row.append(points(difference(mine, caught[other], np.zeros(count))))
                chances.append(mcnemar(mine, caught[other])[2])
            cells.append(row)
    p = [chance(one) for one in holm(chances)]
    lines = [
        [*row[:8], one, row[8], other]
        for row, one, other in zip(cells, p[::2], p[1::2], strict=True)
    ]
    return table(head, lines)


def resting(found: Outcomes) -> str:
    """Return learned at rest less learned in motion; equivalent if 90 % lie in the margin."""
    head = ["questions", "number", "seeds", "checks", *WORLDS]
    head += ["points (90 %)", "points (95 %)", "within the margin"]
    lines = []
    for group in ("W", "at rest"):
        some = found.where(split=group)
        seeds = seeds_of(some, *WORLDS)
        for k in (1, 20) if seeds else ():
            still, moving = (over_seeds(some, n, seeds, k).astype(float) for n in WORLDS)
            narrow, wide = (hierarchical(still - moving, share) for share in (0.90, 0.95))
            inside = -MARGIN < narrow.low and narrow.high < MARGIN
            cells = [percent(hierarchical(still)), percent(hierarchical(moving)), points(narrow)]
            cells += [points(wide), "yes" if inside else "no"]
            lines.append([group, str(still.shape[1]), str(len(seeds)), str(k), *cells])
    return table(head, lines)


def write_figure(path: Path, found: Outcomes) -> None:
    """Draw equal experience by size, and what is outside of training or stands in for a memory."""
    drawn = style.new_figure(8.0, 3.0)
    left, right = drawn.subplots(1, 2)
    fresh = found.where(split="fresh")
    by_size(left, fresh)
    if np.isin(SPLITS, found["split"]).any():
        off_the_ranges(right, found)
    else:
        in_its_place(right, fresh)
    drawn.savefig(path)


def by_size(axes: Any, found: Outcomes) -> None:
    """Draw shares over the catches that were held and learned from, by index."""
    sizes = sizes_of(found)
    for index, colour in LOOKS.items():
        names = [f"{index}-{n}" for n in sizes]
        for k, dash in ((1, ":"), (20, "-")):
            caught = [over_seeds(found, name, seeds_of(found, name), k) for name in names]
            value, low, high = 100 * np.array([hierarchical(one.astype(float)) for one in caught]).T
            label = index if k == 20 else None
            axes.plot(sizes, value, dash, color=colour, marker="o", ms=3, label=label)
            axes.fill_between(sizes, low, high, color=colour, alpha=0.15, lw=0)
            if index == "learned":
                asked = "within 20 checks" if k == 20 else "first choice"
                axes.text(sizes[0], high[0] + 1, asked, fontsize=8, va="bottom")
    axes.set_xscale("log")
    axes.set_xticks(sizes, [f"{n:,}" for n in sizes])
    axes.minorticks_off()
    axes.set_ylim(top=100)
    axes.set_xlabel("catches that are held and learned from")
    axes.set_ylabel("caught [%]")
    axes.legend(frameon=False, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncol=3)


def off_the_ranges(axes: Any, found: Outcomes) -> None:
    """Draw catches of the shipped memory outside of its training."""
    for shift, (name, colour) in zip((-0.25, 0.0, 0.25), LOOKS.items(), strict=True):
        method = "shipped" if name == "learned" else f"shipped-{name}"
        for k, alpha in ((20, 0.45), (1, 1.0)):
            some = [found.where(split=split, method=method) for split in SPLITS]
            tall = [100 * within(rows, k).mean() for rows in some]
            axes.bar(np.arange(len(SPLITS)) + shift, tall, 0.23, color=colour, alpha=alpha)
    axes.set_xticks(range(len(SPLITS)), [split.removeprefix("test-") for split in SPLITS])
    axes.set_ylim(top=100)
    axes.set_title("outside of training; dark: first choice, light: 20 checks", fontsize=8)


def in_its_place(axes: Any, found: Outcomes) -> None:
    """Draw what stands in for a memory."""
    names = (f"learned-{WHOLE}", "prototypes", "prototypes, random", "regressor")
    for k, alpha in ((20, 0.45), (1, 1.0)):
        caught = [over_seeds(found, name, seeds_of(found, name), k) for name in names]
        tall = [100 * one.mean() for one in caught]
        axes.bar(BARS, tall, 0.6, color=style.TARGET, alpha=alpha)
    axes.set_ylabel("caught, 20 checks; dark: 1 [%]")
    axes.set_title(f"learned from the same {int(WHOLE):,} catches", fontsize=9)
