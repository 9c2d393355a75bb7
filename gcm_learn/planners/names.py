"""Names of planners, known before any planner is loaded."""

from __future__ import annotations

from pathlib import Path

from gcm_learn import artifacts
from gcm_learn.errors import UnknownNameError
from gcm_learn.planners.references import found

SUMMARIES = {
    "covered": "looks up a proven answer of a cover",
    "gcm": "cognitive map by the wave of the paper, and the descent along its arrival times",
    "hybrid": "recalls first, and searches when recall fails",
    "layered": "maps with several arrivals at a place, so that the hand may wait",
    "marching": "the same map by causal marching instead of a wave",
    "oracle": "searches space and time on fine lattices, slow: the yardstick",
    "potential": "is pulled to the target and pushed away from obstacles",
    "recall": "adapts remembered catches to the situation, and checks up to 20 of them",
    "recall-1": "adapts the catch that it remembers best",
    "recall-map": "finds memories by embeddings of their situations' maps",
    "recall-pca": "finds memories by principal components of maps",
    "recall-random": "adapts up to 20 memories drawn at random: what checking alone is worth",
    "recall-raw": "finds memories by what situations are made of, without an encoder",
    "search": "cells and free spans of time in the plane; else straight moves, then trees in time",
    "splines-random": "checks up to 20 smooth paths drawn at random: what checking alone is worth",
    "st-rrt-star": "random trees through space and time (OMPL), for a budget of time",
    "straight": "goes straight to where the target can be met first",
    "straight-wait": "goes straight, but may wait before it starts",
}
"""Each planner in one line."""


def all_planner_names() -> list[str]:
    """Names of all planners of this package."""
    return sorted(SUMMARIES)


def is_registered(name: str) -> bool:
    """Return whether a name is that of a planner of this package."""
    return name in SUMMARIES


def summary_of(name: str) -> str:
    """Return the one-line summary of a planner of this package; empty for another name."""
    return SUMMARIES.get(name, "")


def check_name(name: str, what: str = "planner") -> None:
    """Refuse a name that no planner, model, folder or reference has, before much is loaded.

    Raises
    ------
    UnknownNameError
        With the known names.
    """
    bare = name.partition("@")[0]
    if is_registered(bare) or artifacts.find("models", bare) or Path(bare).is_dir():
        return
    if found(name) is None:
        actors = {path.parent.name for path in artifacts.shipped("models").glob("*/actor*.npz")}
        raise UnknownNameError.among(what, name, [*all_planner_names(), *sorted(actors)])
