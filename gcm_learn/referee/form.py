"""The form of solutions: fields, types, names and times."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from typing import Any

import numpy as np

from gcm_learn.referee.rotations import Array
from gcm_learn.referee.tolerances import Complaint

FIELDS = (
    "format", "name", "planner", "status", "catch_time", "catch_body", "clearance", "planning_ms",
    "message",
)  # fmt: skip
STATUSES = ("caught", "unreachable", "start_blocked")
NULL = ("catch_time", "catch_body", "clearance")
"""Fields that are null without a catch."""


def is_number(value: Any) -> bool:
    """Tell if a value of JSON is a finite number."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return False
    return abs(value) <= sys.float_info.max  # False for NaN, and exact for large integers


def fields(solution: Any, name: str, version: int) -> list[Complaint]:
    """Return complaints about the fields of any solution."""
    if not isinstance(solution, Mapping):
        return [Complaint("solution", "is not an object")]
    caught = solution.get("status") == "caught"
    listed = ("catches",) if version >= 3 else ()
    wanted = {*FIELDS, *listed, *(("trajectory",) if caught else ())}
    complaints = [Complaint(str(field), "is missing") for field in sorted(wanted - set(solution))]
    complaints += [
        Complaint(str(field), "is no field of this answer") for field in set(solution) - wanted
    ]
    if complaints:
        return complaints
    form, cost = f"gcm-learn/solution@{version}", solution["planning_ms"]
    tests = (
        ("format", solution["format"] == form, f"is not {form}"),
        ("name", solution["name"] == name, "is not the situation's"),
        ("status", solution["status"] in STATUSES, f"is none of {', '.join(STATUSES)}"),
        ("planner", isinstance(solution["planner"], str), "is not a string"),
        ("message", _sentence(solution["message"], caught), "is not a sentence on one line"),
        ("planning_ms", is_number(cost) and cost >= 0, "is not a number from 0 on"),
    )
    complaints += [Complaint(field, what) for field, kept, what in tests if not kept]
    return complaints or ([] if caught else _without_catch(solution))


def _sentence(message: Any, may_be_empty: bool) -> bool:
    return isinstance(message, str) and "\n" not in message and (bool(message) or may_be_empty)


def _without_catch(solution: Mapping[str, Any]) -> list[Complaint]:
    odd = [field for field in NULL if solution[field] is not None]
    odd += ["catches"] if solution.get("catches", []) != [] else []
    return [Complaint(field, "is given without a catch") for field in odd]


def columns_of(
    trajectory: Any, widths: Mapping[str, int]
) -> tuple[dict[str, Array], list[Complaint]]:
    """Return the columns of a trajectory as arrays, and complaints about their form."""
    if not isinstance(trajectory, Mapping):
        return {}, [Complaint("trajectory", "is not an object")]
    wanted = {"time", *widths}
    odd = [(name, "is missing") for name in sorted(wanted - set(trajectory))]
    odd += [(name, "is no column here") for name in set(trajectory) - wanted]
    columns: dict[str, Array] = {}
    for name in () if odd else sorted(wanted):
        width, given = widths.get(name), trajectory[name]
        if _is_table(given, width):
            columns[name] = np.array(given, dtype=float)
        else:
            shape = "numbers" if width is None else f"rows of {width} numbers"
            odd.append((name, f"is not a list of {shape}, all of them finite"))
    if not odd:
        n = len(columns["time"])
        counts = ((name, len(column)) for name, column in columns.items())
        odd = [(name, f"has {count} samples") for name, count in counts if count != n or not n]
    return columns, [Complaint(f"trajectory.{name}", what) for name, what in odd]


def _is_table(given: Any, width: int | None) -> bool:
    """Tell if a value is a list of finite numbers, or of rows of so many."""
    if not isinstance(given, list):
        return False
    if width is None:
        return all(map(is_number, given))
    rows = all(isinstance(row, list) and len(row) == width for row in given)
    return rows and all(is_number(value) for row in given for value in row)


def times(time: Array, version: int) -> list[Complaint]:
    """Return complaints about the times of samples."""
    complaints, steps = [], np.diff(time)
    if time[0] != 0.0:
        complaints.append(Complaint("trajectory.time", "does not start at t = 0", float(time[0])))
    wrong = steps < 0.0 if version == 1 else steps <= 0.0
    if wrong.any():
        at = float(time[wrong.argmax() + 1])
        complaints.append(Complaint("trajectory.time", "does not increase", at))
    return complaints
