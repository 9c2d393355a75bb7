"""Tables of held catches by hybrids and the search (H17), computed from outcomes."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np
import pandas as pd

from gcm_learn.evaluation import Sheet, Table, mark_late, pairs, wilson

BUDGETS = (0.0, 0.02, 0.1)  # charged for thinking [s]
CURVE = (1, 2, 5, 10, 20, 50, 100, 200, 500)  # [ms]
COMPARED = (("stored", "search"), ("stored", "synthetic"), ("stored", "raw neighbours"),
            ("synthetic", "search"))  # fmt: skip
KEPT = ("suite", "key", "family", "entrant", "seed", "thinking", "charged", "outcome", "ms",
        "factor", "catch_time")  # fmt: skip
"""Columns of a sheet that the outcomes have."""


def results(folder: Path) -> dict[str, str]:
    """Return the text of table.md."""
    rows = pd.read_csv(folder / "outcomes.csv.gz").replace({np.nan: None}).to_dict("records")
    return {"table.md": told(Sheet.of([{"noise": 0.0, **row} for row in rows]))}


def told(sheet: Sheet) -> str:
    """Return all tables of a sheet."""
    timely = mark_late(sheet)
    tables = charged(timely), pairs(timely, COMPARED), curves(sheet)
    return "\n\n".join(map(str, tables)) + "\n"


def charged(sheet: Sheet) -> Table:
    """Return shares of catches that came in time, by what was charged."""
    rows = []
    for name, budget in itertools.product(sheet.each("entrant"), BUDGETS):
        part = sheet.where(entrant=name, charged=budget)
        broken = int((part["outcome"] == "broken").sum())
        caught = wilson(int(part.caught.sum()), len(part))
        rows.append([f"{name}, {1e3 * budget:g} ms", len(part), caught, broken])
    return Table(["entrant, charged", "answers", "caught [%]", "broken"], rows)


def curves(sheet: Sheet) -> Table:
    """Return shares caught within CURVE, and the median and nine tenths of times of catches."""
    rows = []
    for name in sheet.each("entrant"):
        part = sheet.where(entrant=name, charged=BUDGETS[0])
        ms = (part["ms"] * part["factor"])[part.caught]
        shares = [float((ms <= most).sum()) / len(part) for most in CURVE]
        rows.append([name, *shares, float(np.median(ms)), float(np.quantile(ms, 0.9))])
    return Table(
        ["entrant", *(f"{most} ms [%]" for most in CURVE), "median [ms]", "90 % [ms]"], rows
    )
