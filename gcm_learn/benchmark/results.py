"""Result files: a method's answers, so that others can judge them again."""

from __future__ import annotations

import gzip
import json
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

from gcm_learn import artifacts
from gcm_learn.errors import FileFormatError, SuiteError
from gcm_learn.planners import FAULTS, LIMIT
from gcm_learn.storage import write_whole

FORMAT = "gcm-learn/benchmark-result@1"
PROTOCOL = 1
"""Version of the protocol in docs/benchmark.md."""
PACKED = ".gz"
LARGEST_FACTOR = 1e6
MOST = {"ms": 1e9, "nodes": 2**53}
"""Largest numbers of an answer."""
OURS = "benchmark-results"  # folder among the data
FIELDS: Mapping[str, type | tuple[type, ...]] = {
    "method": str,
    "protocol": int,
    "package": str,
    "machine": dict,
    "calibration": dict,
    "limit_s": (int, float),
    "runs": list,
}
OF_RUN: Mapping[str, type | tuple[type, ...]] = {
    "suite": str,
    "version": int,
    "sha256": str,
    "answers": list,
}
OF_ANSWER: Mapping[str, type | tuple[type, ...]] = {
    "name": str,
    "ms": (int, float),
    "nodes": int,
    "fault": str,
    "solution": dict,
}


def write_result(path: str | Path, result: Mapping[str, Any]) -> None:
    """Write a result file whole; one whose name ends in .gz is packed."""
    text = json.dumps(result, allow_nan=False, separators=(",", ":")) + "\n"
    packed = str(path).endswith(PACKED)
    write_whole(path, gzip.compress(text.encode(), mtime=0) if packed else text)


def read_result(path: str | Path) -> dict[str, Any]:
    """Read a result file.

    Raises
    ------
    FileFormatError
        One line: the file, the field and the reason.
    """
    try:
        raw = Path(path).read_bytes()
        text = gzip.decompress(raw) if str(path).endswith(PACKED) else raw
        values = json.loads(text)
    except (OSError, EOFError, ValueError, RecursionError) as error:
        reason = getattr(error, "strerror", None) or error
        raise FileFormatError(f"{path}: is no result file ({reason})") from None
    if not isinstance(values, dict) or values.get("format") != FORMAT:
        raise FileFormatError(f"{path}: format: is not {FORMAT!r}")
    try:
        _check(values)
    except ValueError as error:
        raise FileFormatError(f"{path}: {error}") from None
    return values


def our_results(suites: Collection[str] = ()) -> list[dict[str, Any]]:
    """Return the results of this package's methods, with their runs on some suites, or on all.

    Raises
    ------
    SuiteError
        If their folder is missing, as in a wheel.
    """
    folder = artifacts.find("data", OURS)
    if folder is None:
        raise SuiteError(artifacts.missing("data", f"folder {OURS!r}"))
    found = [read_result(path) for path in sorted(folder.glob("*.json.gz"))]
    for result in found:
        result["runs"] = [run for run in result["runs"] if not suites or run["suite"] in suites]
    return [result for result in found if result["runs"]]


def _check(values: dict[str, Any]) -> None:
    """Refuse a result with wrong fields, by a ValueError that names the field."""
    _typed(values, FIELDS, "")
    if values["protocol"] != PROTOCOL:
        raise ValueError(f"protocol: must be {PROTOCOL} (got {values['protocol']})")
    if not 0.0 < values["limit_s"] <= LIMIT:
        raise ValueError(f"limit_s: must be at most {LIMIT:g} (got {values['limit_s']})")
    factor = values["calibration"].get("factor")
    if type(factor) not in (int, float) or not 0.0 < factor <= LARGEST_FACTOR:
        raise ValueError(f"calibration.factor: must be above 0, at most {LARGEST_FACTOR:g}")
    if not values["runs"]:
        raise ValueError("runs: must have at least one")
    for k, run in enumerate(values["runs"]):
        _typed(run, OF_RUN, f"runs[{k}].")
        for number, answer in enumerate(run["answers"]):
            check_answer(answer, f"runs[{k}].answers[{number}].")


def check_answer(answer: Any, place: str = "") -> None:
    """Refuse an answer with wrong fields, by a ValueError that names the field."""
    _typed(answer, OF_ANSWER, place)
    for name, most in MOST.items():
        if not 0 <= answer[name] <= most:
            raise ValueError(f"{place}{name}: must be from 0 to {most:g}")
    if answer["fault"] not in ("", *FAULTS):
        raise ValueError(f"{place}fault: must be one of {', '.join(FAULTS)}, or empty")


def _typed(values: Any, fields: Mapping[str, type | tuple[type, ...]], place: str) -> None:
    if not isinstance(values, dict):
        raise ValueError(f"{place.rstrip('.')}: is no object")
    for name, kind in fields.items():
        if name not in values:
            raise ValueError(f"{place}{name}: is missing")
        if not isinstance(values[name], kind) or isinstance(values[name], bool):
            raise ValueError(f"{place}{name}: is a {type(values[name]).__name__}")
