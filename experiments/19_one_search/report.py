"""Table of the searches side by side, computed from outcomes."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from experiments.common.comparing import complaints, pairs, share
from experiments.common.outcomes import Outcomes, read
from experiments.common.tables import table

TREES, OLDER = "trees", ("cells", "lattice")
LIMITS = ("", ", 20 ms", ", 100 ms")


def results(folder: Path) -> dict[str, str]:
    """Return the tables of the outcomes."""
    found, parts = read(folder / "outcomes.csv.gz"), []
    for kind in sorted(set(found["stratum"].tolist())):
        mine = found.where(stratum=kind)
        known = mine.methods()
        rivals = [f"{TREES}{words}" for words in LIMITS]
        asked = [(f"{TREES}{words}", f"{name}{words}") for name in OLDER for words in LIMITS]
        asked += [(f"hybrid{words}", rival) for words, rival in zip(LIMITS, rivals, strict=True)]
        asked = [pair for pair in asked if set(pair) <= set(known)]
        parts += [f"## In {kind}", catches(mine), pairs(mine, asked)]
    return {"table.md": "\n\n".join(parts) + "\n"}


def catches(found: Outcomes) -> str:
    """Return what each method catches, how soon, and how late its catches are."""
    earliest: dict[str, float] = {}
    caught = found.where(found["caught"])
    for name, time in zip(caught["situation"].tolist(), caught["catch_time"].tolist(), strict=True):
        earliest[name] = min(time, earliest.get(name, time))
    head = [
        "method", "situations", "caught [%]", "ms, median / 90 %",
        "catch time relative to the best known, median / 90 %", "complaints",
    ]  # fmt: skip
    rows = []
    for name in found.methods():
        mine = found.where(method=name)
        met = mine.where(mine["caught"] & (mine["catch_time"] > 0.0))
        best = np.array([earliest[one] for one in met["situation"].tolist()])
        late = met["catch_time"] / np.where(best > 0.0, best, met["catch_time"])
        rows.append(
            [name, len(mine), share(mine), _two(mine["ms"], 1), _two(late, 2), complaints(mine)]
        )
    return table(head, rows)


def _two(values: np.ndarray, digits: int) -> str:
    """Return the median and the 90 % quantile."""
    if len(values) == 0:
        return "-"
    return " / ".join(f"{np.quantile(values, q):.{digits}f}" for q in (0.5, 0.9))
