"""Sentences about the compared methods on the page of a comparison."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from gcm_learn.evaluation.costs import configuration_of
from gcm_learn.evaluation.measures import measured
from gcm_learn.evaluation.table import Results

QUICK = 20.0  # median thinking that counts as quick [ms]

WHO = {
    "straight": "goes straight to where the target can be met first",
    "straight-wait": "goes straight, but may wait before it starts",
    "potential": "is pulled to the target and pushed away from obstacles",
    "search": "plans as layered does; for arms in joints straight moves, then trees from both ends",
    "gcm": "cognitive map by the wave of the paper, and the descent along its arrival times",
    "marching": "the same map by causal marching instead of a wave",
    "layered": "maps with several arrivals at a place, so that the hand may wait",
    "oracle": "searches space and time on fine lattices, slow: the yardstick",
    "st-rrt-star": "random trees through space and time (OMPL), for a budget of time",
    "recall": "adapts remembered catches to the situation, and checks up to 20 of them",
    "recall-1": "adapts the one catch that it remembers best",
    "hybrid": "recalls first, and plans as layered does when recall fails",
    "recall-raw": "finds memories by what situations are made of, not by what an encoder learned",
    "recall-pca": "finds memories by principal components of maps",
    "recall-random": "adapts up to 20 memories drawn at random: what checking alone is worth",
    "splines-random": "checks up to 20 smooth paths drawn at random: what checking alone is worth",
    "clone": "network that imitates planned catches step by step",
    "ppo": "network that learned in the arena from nothing (PPO)",
    "sac": "network of velocities that learned in the arena from nothing (SAC)",
    "ppo-clone": "the imitating network after it went on learning in the arena (PPO)",
}


def who(names: Sequence[str]) -> list[tuple[str, str]]:
    """Methods and what they do, as far as it is known."""
    rows = []
    for name in names:
        bare, _, tries = name.partition("@")
        words = WHO.get(bare, "") or _of_model(bare)
        if tries and words:
            words = f"{words}; tried out {tries} times and verified before the hand moves"
        if words:
            rows.append((name, words))
    return rows


def _of_model(bare: str) -> str:
    """Describe a trained network by its configuration; empty without one."""
    config = configuration_of(bare)
    if "algo" not in config:
        return ""
    words = f"network trained in the arena ({config['algo'].upper()})"
    start = Path(config.get("start", "")).name
    return f"{words}, begun as {start}" if start else words


def verdict(results: Results) -> str:
    """Name the method that catches most, of all and of the methods that think quickly."""
    reachable = results.where(results["stratum"] != "U")
    if not len(reachable):
        return "None of these situations can be caught."
    all_of_them = [measured(reachable, name) for name in results.methods]
    best = max(all_of_them, key=lambda m: m.caught.value)
    text = (
        f"Of what can be caught, {best.method} catches most: {100 * best.caught.value:.0f} %, "
        f"thinking for {_ms(best.latency)} (median)."
    )
    equals = [m.method for m in all_of_them if m.caught.value == best.caught.value and m != best]
    if equals:
        text += f" As much catch {', '.join(equals)}."
    quick = [m for m in all_of_them if np.isfinite(m.latency) and m.latency <= QUICK]
    if quick and best not in quick:
        first = max(quick, key=lambda m: m.caught.value)
        text += (
            f" Of those that think for at most {QUICK:.0f} ms, {first.method} does: "
            f"{100 * first.caught.value:.0f} % after {_ms(first.latency)}."
        )
    careless = max(all_of_them, key=lambda m: m.collisions.value)
    if careless.collisions.value > 0.0:
        text += (
            f" {careless.method} touches an obstacle most often, in "
            f"{100 * careless.collisions.value:.0f} %."
        )
    return text


def _ms(value: float) -> str:
    return f"{value:.1f} ms" if value < 10.0 else f"{value:.0f} ms"
