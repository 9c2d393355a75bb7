"""Tables of recall, computed from outcomes."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import NamedTuple

from experiments.common import comparing
from experiments.common.comparing import STRATA, share
from experiments.common.outcomes import Outcomes, read
from experiments.common.tables import table

CHECKS = ("", ", 1 check")
COSTS = ("complaints", *comparing.COUNTS, "ms", "90 %")
COSTS_NOTE = (
    "; of how many catches the referee complains; mean checks, looks and bends "
    "of a situation; processor time [ms], median and 90 %."
)


class Suite(NamedTuple):
    """A memory under several indexes, and the strata in which it answers."""

    indexes: tuple[str, ...]
    """Beside its own."""
    groups: str
    """What intervals are within."""
    strata: tuple[str, ...] = STRATA
    costs: bool = True
    """False if catches were neither judged nor counted."""


BY_INDEX = {
    "fresh": Suite(("recall-clearance", "recall-raw", "recall-random"), "families"),
    "standin": Suite(("recall-clearance", "recall-raw", "recall-random"), "classes of arms"),
    "recall-panda": Suite(
        ("recall-change", "recall-raw", "recall-random"),
        "families",
        ("L", "W", "Q"),
        costs=False,
    ),
}

SPATIAL = ("space", "space-accelerated")
PLANNERS = ("recall", "recall-1", "recall-raw", "recall-random", "hybrid", "layered")
GROUPS = {
    "as trained": ("train", "validation", "test"),
    "families": ("test-family",),
    "arms": ("test-arms",),
    "faster": ("test-fast",),
    "crowded": ("test-crowded",),
}
"""Splits of the specification: whatever the seed draws, no memory has seen."""


def results(folder: Path) -> dict[str, str]:
    """Return the tables of all suites."""
    makers = {name: partial(by_index, suite=suite) for name, suite in BY_INDEX.items()}
    makers |= dict.fromkeys(SPATIAL, spatial)
    files = {name: folder / f"outcomes-{name}.csv.gz" for name in makers}
    return {f"{n}.md": makers[n](read(file)) for n, file in files.items() if file.exists()}


def by_index(found: Outcomes, suite: Suite) -> str:
    """Return catches by stratum, what they took, and pairs."""
    if "split" in found.columns:
        found = found.where(split=GROUPS["as trained"], stratum=suite.strata)
    names = [index + checks for checks in CHECKS for index in ("recall", *suite.indexes)]
    own = {s: found.where(method="recall", stratum=s) for s in suite.strata}
    strata = [stratum for stratum in suite.strata if len(own[stratum])]
    whole = f"{', '.join(strata[:-1])} and {strata[-1]}"
    head = ["asked", *strata, whole, *(COSTS if suite.costs else ())]
    rows = []
    for name in names:
        mine = found.where(method=name)
        shares = [share(mine.where(stratum=stratum)) for stratum in strata]
        rest = [comparing.complaints(mine), *comparing.counts(mine), *comparing.times(mine)]
        rows.append([f"`{name}`", *shares, share(mine), *(rest if suite.costs else ())])
    asked = [("recall" + checks, other + checks) for checks in CHECKS for other in suite.indexes]
    counts = [f"{len(own[stratum])} of {stratum}" for stratum in strata]
    counts[0] = counts[0].replace(" of", " situations of")
    number = f"{', '.join(counts[:-1])} and {counts[-1]}"
    note = f"Catches [%] of {number}, 95 % intervals within {suite.groups}"
    note += COSTS_NOTE if suite.costs else "."
    parts = [table(head, rows), note, comparing.pairs(found, asked)]
    return "\n\n".join(parts) + "\n"


def spatial(found: Outcomes) -> str:
    """Return catches by stratum where all is as in training, then by what is not, and pairs."""
    caught = found.where(stratum=("L", "W", "Q"))
    trained = {s: caught.where(split=GROUPS["as trained"], stratum=s) for s in ("L", "W", "Q")}
    hard = caught.where(stratum=STRATA)
    columns = trained | {
        f"W and Q, {group}": hard.where(split=splits) for group, splits in GROUPS.items()
    }
    columns = {name: rows for name, rows in columns.items() if len(rows)}
    head = ["asked", *columns, "complaints", *comparing.COUNTS, "ms", "90 %"]
    numbers = [str(len(rows.where(method="layered"))) for rows in columns.values()]
    rows = [["situations", *numbers, *[""] * (len(head) - 1 - len(numbers))]]
    for name in PLANNERS:
        mine = caught.where(method=name)
        shares = [share(rows.where(method=name)) for rows in columns.values()]
        rest = [comparing.complaints(mine), *comparing.counts(mine), *comparing.times(mine)]
        rows.append([f"`{name}`", *shares, *rest])
    drawn = len(found.where(method="layered"))
    note = (
        f"{drawn} situations, {len(found.where(stratum='U'))} of which `layered` does not catch "
        "with the moves of the specification. Catches [%] of the others have 95 % intervals. Then "
        "come catches that the referee complains of, mean checks, looks and bends of a situation, "
        "and processor time [ms], median and 90 %. Pairs are of W and Q as trained."
    )
    asked = [("recall", "recall-raw"), ("recall", "recall-random"), ("hybrid", "layered")]
    pairs = comparing.pairs(hard.where(split=GROUPS["as trained"]), asked)
    return "\n\n".join([table(head, rows), note, pairs]) + "\n"
