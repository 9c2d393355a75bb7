"""Tables of what planners catch in space, computed from outcomes."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from experiments.common.comparing import complaints, share
from experiments.common.outcomes import Outcomes, read
from experiments.common.tables import table

STRATA = ("L", "W", "Q")
YARDSTICK, HELD = "yardstick", "yardstick, two joints held"
COSTS = ("lattice", "bystanders")
"""First words of the methods that are `layered` on other lattices and among more bodies."""


def results(folder: Path) -> dict[str, str]:
    """Return all tables of the outcomes."""
    found = read(folder / "outcomes.csv.gz")
    known = found.where(method=YARDSTICK)
    parts = (
        f"{len(known)} situations.",
        strata(known),
        catches(found),
        planes(found.where(method=HELD)),
        "`layered` on lattices of other sizes, and with bystanders added:",
        prices(found),
    )
    return {"table.md": "\n\n".join(parts) + "\n"}


def strata(known: Outcomes) -> str:
    """Return how many situations of each stratum there are, by family."""
    families = sorted(set(known["family"].tolist()))
    lines = []
    for name, some in (*((one, known.where(family=one)) for one in families), ("all", known)):
        counts = [len(some.where(stratum=s)) for s in STRATA]
        lost = some.where(stratum="U")
        out = int(np.isnan(lost["lower"]).sum())
        lines.append([name, *map(str, [*counts, out, len(lost) - out])])
    return table(["family", *STRATA, "U ruled out", "U open"], lines)


def catches(found: Outcomes) -> str:
    """Return what each planner catches of what can be caught, and its time."""
    head = [
        "planner", *STRATA, " + ".join(STRATA), "ms where it catches, median / 90 %",
        "ms where it does not", "later than the earliest known, median / 90 % [ms]", "complaints",
    ]  # fmt: skip
    names = [
        name
        for name in found.methods()
        if name not in (YARDSTICK, HELD) and not name.startswith(COSTS)
    ]
    earliest = _earliest(found.where(method=[YARDSTICK, *names]))
    rows = []
    for name in names:
        mine = found.where(method=name)
        caught = mine.where(mine["caught"])
        shares = [share(mine.where(stratum=s)) for s in (*STRATA, STRATA)]
        first = np.array([earliest[key] for key in caught["situation"].tolist()])
        late = _quantiles(1e3 * (caught["catch_time"] - first), 0)
        clock = [_quantiles(some["ms"], 1) for some in (caught, mine.where(~mine["caught"]))]
        rows.append([f"`{name}`", *shares, *clock, late, complaints(mine)])
    return table(head, rows)


def _earliest(found: Outcomes) -> dict[str, float]:
    """Return when anybody catches first [s], by situation."""
    caught, out = found.where(found["caught"]), {}
    pairs = zip(caught["situation"].tolist(), caught["catch_time"].tolist(), strict=True)
    for key, time in pairs:
        out[key] = min(time, out.get(key, time))
    return out


def _quantiles(values: np.ndarray, digits: int) -> str:
    """Return the median and the 90 % quantile of some numbers."""
    if len(values) == 0:
        return "-"
    return " / ".join(f"{np.quantile(values, q):.{digits}f}" for q in (0.5, 0.9))


def planes(held: Outcomes) -> str:
    """Return what is left when two joints are held."""
    rows = []
    for some in (*STRATA, STRATA):
        mine = held.where(stratum=some)
        rows.append([" + ".join(some), str(len(mine)), share(mine)])
    return table(["stratum in space", "situations", "caught with two joints held"], rows)


def prices(found: Outcomes) -> str:
    """Return the cost of `layered` over the lattice's size and the number of bodies."""
    rows = []
    for name in [name for name in found.methods() if name.startswith(COSTS)]:
        mine = found.where(method=name)
        caught = f"{mine['caught'].sum()} of {len(mine)}"
        rows.append([name, caught, _quantiles(mine["ms"], 1)])
    return table(["", "caught", "ms, median / 90 %"], rows)
