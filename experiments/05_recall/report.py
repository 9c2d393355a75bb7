"""Tables of recall, computed from outcomes."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from experiments.common import comparing
from experiments.common.comparing import STRATA, share
from experiments.common.outcomes import Outcomes, read
from experiments.common.tables import table

INDEXES = ("recall-clearance", "recall-raw", "recall-random")
CHECKS = ("", ", 1 check")
PLANAR = {"fresh": "families", "standin": "classes of arms"}


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
    """Return the tables of the suites in the plane and in space."""
    makers = {name: partial(planar, groups=groups) for name, groups in PLANAR.items()}
    makers |= dict.fromkeys(SPATIAL, spatial)
    files = {name: folder / f"outcomes-{name}.csv.gz" for name in makers}
    return {f"{n}.md": makers[n](read(file)) for n, file in files.items() if file.exists()}


def planar(found: Outcomes, groups: str) -> str:
    """Return catches by stratum, what they took, and pairs."""
    names = [index + checks for checks in CHECKS for index in ("recall", *INDEXES)]
    head = ["asked", *STRATA, "W and Q", "complaints", *comparing.COUNTS, "ms", "90 %"]
    rows = []
    for name in names:
        mine = found.where(method=name)
        shares = [share(mine.where(stratum=stratum)) for stratum in STRATA]
        rest = [comparing.complaints(mine), *comparing.counts(mine), *comparing.times(mine)]
        rows.append([f"`{name}`", *shares, share(mine), *rest])
    number = [len(found.where(method="recall", stratum=s)) for s in STRATA]
    asked = [("recall" + checks, other + checks) for checks in CHECKS for other in INDEXES]
    note = (
        f"Catches [%] of {number[0]} situations of W and {number[1]} of Q, 95 % intervals within "
        f"{groups}; of how many catches the referee complains; mean checks, looks and bends of a "
        "situation; processor time [ms], median and 90 %."
    )
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
        "with the moves of the specification; catches [%] of the others with 95 % intervals; of "
        "how many catches the referee complains; mean checks, looks and bends of a situation; "
        "processor time [ms], median and 90 %. Pairs are of W and Q as trained."
    )
    asked = [("recall", "recall-raw"), ("recall", "recall-random"), ("hybrid", "layered")]
    pairs = comparing.pairs(hard.where(split=GROUPS["as trained"]), asked)
    return "\n\n".join([table(head, rows), note, pairs]) + "\n"
