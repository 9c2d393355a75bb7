"""The tables of space, all pairs, and the figure."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from fronts import hybrids
from report import (
    Found,
    before_fallbacks,
    by_size,
    equal,
    h8,
    judged,
    lines_of,
    needed,
    over_seeds,
    read,
    seeds_apart,
    seeds_of,
    shipped,
    write_page,
)
from space_asked import FRONTS, fallbacks
from space_lessons import OF, PROTOTYPES, SIZES

from experiments.common.questions import Question
from gcm_learn.plots import style

INSTEAD = {
    "memories": f"learned-{OF}",
    "prototypes": f"prototypes-{PROTOTYPES}",
    "any of them": f"prototypes-{PROTOTYPES}-random",
    "regressor": f"regressor-{OF}",
}


def figure(path: Path, found: Found) -> None:
    """Equal experience by size, and what stands in for a memory."""
    drawn = style.new_figure(8.0, 3.0)
    left, right = drawn.subplots(1, 2)
    by_size(left, found, SIZES)
    there = {shown: name for shown, name in INSTEAD.items() if seeds_of(found, name)}
    for k, alpha in ((20, 0.45), (1, 1.0)):
        tall = [
            100 * over_seeds(found, name, seeds_of(found, name), k).mean()
            for name in there.values()
        ]
        right.bar(range(len(tall)), tall, 0.6, color=style.TARGET, alpha=alpha)
    right.set_xticks(range(len(there)), list(there))
    right.set_ylabel("caught, 20 checks; dark: 1 [%]")
    right.set_title(f"learned from the same {OF:,} catches", fontsize=9)
    drawn.savefig(path)


def write(here: Path, suite: Path, rows: Sequence[Question]) -> None:
    """Write table-space.md, pairs-space.json and figure-space.png of what has been asked."""
    found, told = read(suite / "answers"), lines_of(suite / "fronts.jsonl")
    strata = np.array([q.stratum for q in rows])
    page = {
        "Equal experience": equal(found, strata, SIZES),
        "Equal experience: differences": h8(found, SIZES),
        "Seeds": seeds_apart(found, OF),
        "Is a memory needed?": needed(found, OF),
        "The shipped memory": shipped(found, rows),
    }
    if told:
        made = hybrids(told, FRONTS, fallbacks())
        page |= before_fallbacks(made, here / "pairs-space.json")
    counts = {name: int(np.sum(strata == name)) for name in "WQ"}
    note = (
        f"Suite of seed {suite.name.removeprefix('fresh-')}: {counts['W']} situations of W and "
        f"{counts['Q']} of Q are asked of all, {len(told)} of them of fronts and fallbacks. "
        f"The referee judged {judged([found], told)}."
    )
    write_page(here / "table-space.md", page, note)
    figure(here / "figure-space.png", found)
