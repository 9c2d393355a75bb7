"""Tables of recall, computed from outcomes."""

from __future__ import annotations

from pathlib import Path

from experiments.common import comparing
from experiments.common.comparing import STRATA, share, table
from experiments.common.outcomes import Outcomes, read

INDEXES = ("recall-clearance", "recall-raw", "recall-random")
CHECKS = ("", ", 1 check")
PLANAR = {"fresh": "families", "standin": "classes of arms"}


def results(folder: Path) -> dict[str, str]:
    """Return the tables of the suites in the plane and in space."""
    return {
        f"{name}.md": planar(read(folder / f"outcomes-{name}.csv.gz"), groups)
        for name, groups in PLANAR.items()
        if (folder / f"outcomes-{name}.csv.gz").exists()
    }


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
