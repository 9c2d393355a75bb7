"""Tables of what was measured."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from gcm_learn import seeding

STRATA = "LWQ"
DRAWS = 2000  # of the bootstrap

Rows = list[dict[str, Any]]


def share(hits: list[bool]) -> str:
    """A share in % with its 95 % bootstrap interval."""
    if not hits:
        return "-"
    values = np.array(hits, dtype=float)
    drawn = seeding.rng(0).choice(values, (DRAWS, len(values))).mean(axis=1)
    low, high = 100.0 * np.quantile(drawn, (0.025, 0.975))
    return f"{100.0 * values.mean():.0f} ({low:.0f}-{high:.0f})"


def _times(answers: list[list[Any]]) -> str:
    ms = [answer[1] for answer in answers]
    return f"{np.median(ms):.1f} / {np.quantile(ms, 0.9):.1f}" if ms else "-"


def strata(rows: Rows) -> str:
    """How many situations of each stratum there are, by family."""
    names = sorted({row["family"] for row in rows})
    lines = ["| family | L | W | Q | U ruled out | U open |", "|---|---|---|---|---|---|"]
    for name in [*names, "all"]:
        of = [row for row in rows if name in (row["family"], "all")]
        counts = [sum(row["stratum"] == s for row in of) for s in STRATA]
        out = sum(row["stratum"] == "U" and row["lower"] is None for row in of)
        still = sum(row["stratum"] == "U" and row["lower"] is not None for row in of)
        lines.append(f"| {name} | {' | '.join(map(str, [*counts, out, still]))} |")
    return "\n".join(lines)


def catches(rows: Rows) -> str:
    """What each planner catches of what can be caught, and its time."""
    lines = [
        "| planner | L | W | Q | L + W + Q | ms where it catches, median / 90 % | ms where it does"
        " not | later than the earliest known, median / 90 % [ms] | broken |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for name in rows[0]["answers"]:
        told = [(row, row["answers"][name]) for row in rows if name in row["answers"]]
        cells = [share([a[0] is not None for r, a in told if r["stratum"] == s]) for s in STRATA]
        cells.append(share([a[0] is not None for r, a in told if r["stratum"] in STRATA]))
        caught, not_caught = [
            [a for _, a in told if (a[0] is not None) == good] for good in (True, False)
        ]
        late = [1e3 * (a[0] - _earliest(r)) for r, a in told if a[0] is not None]
        cells += [_times(caught), _times(not_caught)]
        cells.append(f"{np.median(late):.0f} / {np.quantile(late, 0.9):.0f}" if late else "-")
        cells.append(str(sum(bool(a[2]) for _, a in told)))
        lines.append(f"| `{name}` | {' | '.join(cells)} |")
    return "\n".join(lines)


def _earliest(row: dict[str, Any]) -> float:
    """The earliest catch that anybody found [s]."""
    times = [*row["yardstick"].values(), *(answer[0] for answer in row["answers"].values())]
    return min(t for t in times if t is not None)


def planes(rows: Rows) -> str:
    """What is left when two joints are held."""
    lines = ["| stratum in space | situations | caught with two joints held |", "|---|---|---|"]
    for s in [*STRATA, STRATA]:
        of = [row for row in rows if row["stratum"] in s]
        left = share([row["plane, yardstick"] != "U" for row in of])
        lines.append(f"| {' + '.join(s)} | {len(of)} | {left} |")
    return "\n".join(lines)


def prices(rows: Rows) -> str:
    """Cost of `layered` over the lattice's size and the number of bodies."""
    of = [row for row in rows if row["costs"]]
    if not of:
        return "Not measured yet."
    lines = ["| | caught | ms, median / 90 % |", "|---|---|---|"]
    for name in of[0]["costs"]:
        told = [row["costs"][name] for row in of]
        hits = sum(a[0] is not None for a in told)
        lines.append(f"| {name} | {hits} of {len(told)} | {_times(told)} |")
    return "\n".join(lines)


def write_table(path: Path, rows: Rows) -> None:
    """Write all tables."""
    parts = (
        f"{len(rows)} situations.",
        strata(rows),
        catches(rows),
        planes(rows),
        "`layered` on lattices of other sizes, and with bystanders added:",
        prices(rows),
    )
    path.write_text("\n\n".join(parts) + "\n")
