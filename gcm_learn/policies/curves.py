"""Learning curves: checks on validation situations, and whether they still gain."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

CHECKS = 10  # at least so many make a quarter; a plan may ask for more
GAIN = 0.01  # of the share of catches from one quarter to the next; less is none
_ROWS = 12  # of a card's table


def last_gain(shares: Sequence[float], checks: int) -> float | None:
    """Return how far the last quarter's mean is above that of the quarter before.

    None if a quarter has fewer checks than that.
    """
    size = len(shares) // 4
    if size < checks:
        return None
    return float(np.mean(shares[-size:]) - np.mean(shares[-2 * size : -size]))


def stopped_gaining(shares: Sequence[float], checks: int = CHECKS) -> bool:
    """Return whether the last quarter's mean is less than 1 point above that before."""
    gain = last_gain(shares, checks)
    return gain is not None and gain < GAIN


def in_words(rows: Sequence[Mapping[str, Any]]) -> str:
    """Say whether a run stopped gaining or was still rising, from the rows of its log."""
    gain = last_gain([row["caught"] for row in rows], CHECKS)
    if gain is None:
        return f"too few checks ({len(rows)}) to say whether it still gains"
    told = "stopped gaining" if gain < GAIN else "was still rising"
    return f"{told} (last quarter of {len(rows)} checks {gain:+.1%} against the one before)"


def table_of(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return the lines of a table of at most 12 checks, the last check included."""
    chosen = np.unique(np.linspace(0, len(rows) - 1, min(len(rows), _ROWS)).round().astype(int))
    lines = ["| steps | processor hours | caught | touched |", "|---|---|---|---|"]
    for row in (rows[k] for k in chosen):
        hours = row.get("processor", row["seconds"]) / 3600.0
        lines.append(
            f"| {row['steps']:,} | {hours:.2f} | {row['caught']:.1%} | {row['touched']:.1%} |"
        )
    return lines
