"""The pages of both arms: tables and figures."""

from __future__ import annotations

import json
from collections.abc import Sequence
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import space_lessons
from answers import within
from experience import (
    CONTROLS,
    Found,
    differences,
    equal,
    h8,
    needed,
    outside,
    over_seeds,
    resting,
    seeds_apart,
    seeds_of,
    shipped,
)
from questions import SPLITS
from trainings import LONG, LONGER, SIZES, TURNS

from experiments.common.questions import MOST, Question
from experiments.common.tables import sections
from gcm_learn.evaluation import hierarchical
from gcm_learn.plots import style
from gcm_learn.storage import write_whole

LOOKS = {"learned": style.TARGET, "raw": style.OBSTACLE, "random": style.FAINT}
INSTEAD = {
    "memories": f"learned-{space_lessons.OF}",
    "prototypes": f"prototypes-{space_lessons.PROTOTYPES}",
    "any of them": f"prototypes-{space_lessons.PROTOTYPES}-random",
    "regressor": f"regressor-{space_lessons.OF}",
}


def write(here: Path, out: Path, suite: Path, rows: Sequence[Question], later: Path) -> None:
    """Write table.md and figure.png of all answers."""
    found = read(suite / "answers")
    all_of_them = {split: read(out / "outside" / split) for split in SPLITS}
    splits = {split: one for split, one in all_of_them.items() if set(CONTROLS) <= set(one)}
    groups = {name: read(suite / name) for name in ("W", "at rest")}
    strata = np.array([q.stratum for q in rows])
    page = {
        "Equal experience": equal(found, strata),
        "Equal experience: differences": h8(found),
        "Seeds": seeds_apart(found),
        "Is a memory needed?": needed(found),
        "The shipped memory": shipped(found, rows),
        "Not trained on": outside(splits),
    }
    page["At rest and in motion"] = resting(groups)
    more = read(later / "answers")
    turns, indexes = f"{TURNS * LONGER} turns (long), afterwards", ("long", "learned", "raw")
    page[turns] = equal(more, np.repeat(["W", "Q"], MOST), LONG, indexes)
    page[f"{turns}: differences"] = differences(more, list(combinations(indexes, 2)))
    said = judged([found, *splits.values(), *groups.values(), more])
    seeds = [one.name.removeprefix("fresh-") for one in (suite, later)]
    note = (
        f"Suite of seed {seeds[0]}, of long trainings {seeds[1]}: {MOST} situations of W and "
        f"{MOST} of Q. "
        f"The referee judged {said}."
    )
    write_page(here / "table.md", page, note)
    figure(here / "figure.png", found, splits)


def write_page(path: Path, page: dict[str, str], note: str) -> None:
    """Write the tables that have rows, and a note below."""
    filled = {title: text for title, text in page.items() if text.count("\n") > 1}
    write_whole(path, sections(filled) + f"\n{note}\n")


def read(folder: Path) -> Found:
    """All answers of a folder."""
    return {
        file.stem: json.loads(file.read_text("utf-8")) for file in sorted(folder.glob("*.json"))
    }


def judged(groups: list[Found]) -> str:
    """Numbers of catches that the referee has judged and found at fault."""
    answers = [one for group in groups for one in group.values()]
    catches = sum(sum(one["first"]) + sum(one["caught"]) for one in answers)
    broken = sum(one["broken"] for one in answers)
    return f"{catches:,} catches and found fault with {broken}"


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
                asked = "within 20 checks" if k == 20 else "first choice"
                axes.text(there[0], high[0] + 1, asked, fontsize=8, va="bottom")
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


def write_space(here: Path, suite: Path, rows: Sequence[Question]) -> None:
    """Write table-space.md and figure-space.png of all answers."""
    found = read(suite / "answers")
    strata = np.array([q.stratum for q in rows])
    page = {
        "Equal experience": equal(found, strata, space_lessons.SIZES),
        "Equal experience: differences": h8(found, space_lessons.SIZES),
        "Seeds": seeds_apart(found, space_lessons.OF),
        "Is a memory needed?": needed(found, space_lessons.OF),
        "The shipped memory": shipped(found, rows),
    }
    counts = {name: int(np.sum(strata == name)) for name in "WQ"}
    note = (
        f"Suite of seed {suite.name.removeprefix('fresh-')}: {counts['W']} situations of W and "
        f"{counts['Q']} of Q. "
        f"The referee judged {judged([found])}."
    )
    write_page(here / "table-space.md", page, note)
    figure_in_space(here / "figure-space.png", found)


def figure_in_space(path: Path, found: Found) -> None:
    """Equal experience by size, and what stands in for a memory."""
    drawn = style.new_figure(8.0, 3.0)
    left, right = drawn.subplots(1, 2)
    by_size(left, found, space_lessons.SIZES)
    there = {shown: name for shown, name in INSTEAD.items() if seeds_of(found, name)}
    for k, alpha in ((20, 0.45), (1, 1.0)):
        tall = [
            100 * over_seeds(found, name, seeds_of(found, name), k).mean()
            for name in there.values()
        ]
        right.bar(range(len(tall)), tall, 0.6, color=style.TARGET, alpha=alpha)
    right.set_xticks(range(len(there)), list(there))
    right.set_ylabel("caught, 20 checks; dark: 1 [%]")
    right.set_title(f"learned from the same {space_lessons.OF:,} catches", fontsize=9)
    drawn.savefig(path)
