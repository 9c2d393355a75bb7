"""Tables of hybrids: every front before every fallback, and all pairs of these."""

from __future__ import annotations

import json
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np

from experiments.common.tables import percent, points, table
from gcm_learn.evaluation import chance, difference, holm, mcnemar, wilson
from gcm_learn.storage import write_whole

Made = dict[tuple[str, str], dict[str, np.ndarray]]


def before_fallbacks(made: Made, path: Path) -> dict[str, str]:
    """Tables of fronts before fallbacks; all pairs are written to a file."""
    both = {what: pairs(made, what) for what in ("caught", "ready")}
    write_whole(path, json.dumps(both, indent=1) + "\n")
    return {
        "Fronts and fallbacks: 20 ms charged": fronts(made, "caught"),
        "Fronts and fallbacks: 20 ms charged, ready by then": fronts(made, "ready"),
        "What the learned front is worth: charged": chosen(both["caught"], made, "caught"),
        "What the learned front is worth: ready": chosen(both["ready"], made, "ready"),
        "Processor time of hybrids: median, 90 %": latencies(made),
    }


def fronts(made: Made, what: str) -> str:
    """Every front before every fallback."""
    behind = list(dict.fromkeys(b for _, b in made))
    head, lines = ["front", *behind], []
    for front in dict.fromkeys(f for f, _ in made):
        cells = []
        for fallback in behind:
            caught = made[front, fallback][what]
            cells.append(percent(wilson(int(caught.sum()), len(caught))))
        lines.append([front, *cells])
    return table(head, lines)


def pairs(made: Made, what: str) -> list[dict[str, Any]]:
    """All pairs of hybrids with McNemar's test, after Holm."""
    both = list(combinations(made, 2))
    tests = [mcnemar(made[a][what], made[b][what]) for a, b in both]
    chances = holm([p for *_, p in tests])
    return [
        {"first": " + ".join(a), "second": " + ".join(b), "only first": x, "only second": y, "p": p}
        for (a, b), (x, y, _), p in zip(both, tests, chances, strict=True)
    ]


def chosen(found: list[dict[str, Any]], made: Any, what: str) -> str:
    """Of all pairs those that tell what a front is worth before the same fallback."""
    head = ["fallback", "learned before it, less", "points", "only learned", "only the other"]
    head, lines = [*head, "p (Holm)"], []
    known = {(one["first"], one["second"]): one for one in found}
    for fallback in dict.fromkeys(b for _, b in made):
        for front in dict.fromkeys(front for front, _ in made if front != "learned"):
            names = [f"{name} + {fallback}" for name in ("learned", front)]
            one = known.get(tuple(names)) or known[tuple(names[::-1])]
            caught = [made[name, fallback][what] for name in ("learned", front)]
            sides = (one["only first"], one["only second"])
            mine, other = sides if one["first"] == names[0] else sides[::-1]
            gap = difference(*caught, np.zeros(len(caught[0])))
            lines.append([fallback, front, points(gap), str(mine), str(other), chance(one["p"])])
    return table(head, lines)


def latencies(made: Made) -> str:
    """Processor time of the hybrids [ms]: median and 90 %."""
    behind = list(dict.fromkeys(b for _, b in made))
    head, lines = ["front, ms", *behind], []
    for front in dict.fromkeys(f for f, _ in made):
        spent = [made[front, fallback]["ms"] for fallback in behind]
        cells = [f"{np.median(ms):.1f}, {np.quantile(ms, 0.9):.1f}" for ms in spent]
        lines.append([front, *cells])
    return table(head, lines)
