"""Which tests may be skipped where everything is installed; any other skip is a failure there."""

from __future__ import annotations

import pytest

ALLOWED = {
    "nothing to reach": "a random situation whose target stays out of reach has no earliest catch",
    "blocked from the start": "a random situation may begin with a collision: no front spreads",
    "no device that is always full": "only Linux has /dev/full",
    "no groups of processes": "Windows has none",
    "no Chromium": "a browser is no Python package; the page is tested where one is installed",
}
"""Reason of a skip: why nobody can do anything about it."""


def judge(report: pytest.TestReport | pytest.CollectReport) -> None:
    """Make a failure of a skip that is not allowed, e.g. of a library that is missing."""
    if not report.skipped or hasattr(report, "wasxfail"):
        return
    why = report.longrepr[2] if isinstance(report.longrepr, tuple) else str(report.longrepr)
    why = why.removeprefix("Skipped: ")
    if why not in ALLOWED:
        report.outcome = "failed"
        report.longrepr = f"skipped, which is not allowed here (tests/skips.py): {why}"
