"""The demo's last part: what is shipped, compared on a small suite."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from gcm_learn.evaluation import compare, draw_suite
from gcm_learn.evaluation.suites import suite_file
from gcm_learn.plots.comparison import write_report
from gcm_learn.policies.planner import actor_names
from gcm_learn.recall.shipped import has_memory

PLANNERS = ("straight", "gcm", "marching", "layered")
RECALLING = ("recall", "hybrid")
TRIED = "@20"  # actors are shown as they act, and tried out
CHARGED = 3  # situations of each stratum for which thinking is charged


def shipped_entrants() -> list[str]:
    """Planners, those with a memory if one is there, and all trained actors."""
    names = list(PLANNERS)
    if has_memory():
        names += RECALLING
    for actor in actor_names():
        names += [actor, actor + TRIED]
    return names


def build_comparison(
    out: Path, count: int, progress: Callable[[str], None], workers: int | None = None
) -> Path | None:
    """Compare what is shipped; returns the page, or None if no suite is shipped either."""
    if suite_file("demo") is None:
        return None
    entries = draw_suite("demo", count)
    names = shipped_entrants()
    progress(f"Comparing {', '.join(names)} on {count} situations")
    results = compare(names, entries, charge=CHARGED, workers=workers)
    out.mkdir(parents=True, exist_ok=True)
    progress("Drawing the comparison")
    return write_report(results, entries, out)
