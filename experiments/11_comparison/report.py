"""The tables of the comparison."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from experiments.common.tables import percent, points, table
from gcm_learn.evaluation import (
    DELAYS,
    Results,
    chance,
    difference,
    mcnemar,
    measured,
    stratified,
    under_noise,
)

ALLOWED = 20.0  # thinking that H1 grants [ms]


def in_time(results: Results, name: str) -> np.ndarray:
    """Return which catches after 20 ms were found by then (n,) bool."""
    mine = results.of_method(name)
    return (mine["charged_20"] == "caught") & (mine["latency_ms"] <= ALLOWED)


def thinking(charged: Results) -> str:
    """Return catches of W over charged time."""
    delays = [f"charged_{round(1e3 * delay)}" for delay in DELAYS]
    head = [
        "method", *(f"{name.removeprefix('charged_')} ms" for name in delays), "own latency",
        "20 ms, if ready by then", "touched", "ms", "95 %",
    ]  # fmt: skip
    rows = []
    for name in charged.methods:
        mine, costs = charged.of_method(name), measured(charged, name)
        groups = mine["family"].astype(str)
        hits = [mine[delay] == "caught" for delay in (*delays, "charged_own")]
        cells = [percent(stratified(hit, groups)) for hit in (*hits, in_time(charged, name))]
        cells.append(f"{100 * costs.collisions.value:.1f}")
        rows.append([f"`{name}`", *cells, f"{costs.latency:.1f}", f"{costs.latency_95:.1f}"])
    return table(head, rows)


def pairs(charged: Results) -> str:
    """Return the hybrid beside the wave's maps (H1), and beside its own fallback."""
    head = ["on W", "points (95 %)", "only the first", "only the second", "p (McNemar)"]
    rows = []
    for other in ("gcm", "layered"):
        both = [charged.of_method(name) for name in ("hybrid", other)]
        hits = {
            "20 ms charged": [mine["charged_20"] == "caught" for mine in both],
            "20 ms charged, ready by then": [in_time(charged, n) for n in ("hybrid", other)],
            "own latency charged": [mine["charged_own"] == "caught" for mine in both],
        }
        for words, (first, second) in hits.items():
            gap = difference(first, second, both[0]["family"].astype(str))
            only, other_only, p = mcnemar(first, second)
            name = f"`hybrid` less `{other}`, {words}"
            rows.append([name, points(gap), only, other_only, chance(p)])
    return table(head, rows)


def inexact(noise: Results) -> str:
    """Return catches under inexact perception."""
    head = ["method", "deviation [forearms]", "plans", "caught", "touched", "lost [points]"]
    return table(
        head,
        [
            [f"`{one.method}`", f"{one.noise:g}", one.way if one.noise else "exact",
             percent(one.caught), f"{100 * one.collisions:.1f}", f"{100 * one.lost:.1f}"]
            for one in under_noise(noise)
        ],
    )  # fmt: skip


def write_charged(file: Path, charged: Results, about: str, cost: dict[str, float]) -> None:
    """Write the tables of charged thinking into a file."""
    parts = [
        _made_of(about, cost),
        "## Thinking is charged\n\nCatches of W [%] if the world goes on during thought, with 95 % "
        "intervals, resampled within families.",
        thinking(charged),
        pairs(charged),
    ]
    file.write_text("\n\n".join(parts) + "\n", "utf-8")


def write_inexact(file: Path, noise: Results, about: str, cost: dict[str, float]) -> None:
    """Write the table of inexact perception into a file."""
    n = len(noise.where((noise["noise"] == 0.0) & (noise["entrant"] == noise.methods[0])))
    title = f"## Perception is not exact\n\nCatches [%] of {n} situations of W and Q."
    parts = [_made_of(about, cost), title, inexact(noise)]
    file.write_text("\n\n".join(parts) + "\n", "utf-8")


def _made_of(about: str, cost: dict[str, float]) -> str:
    took = f"{cost['cpu']:.0f} min of a core ({cost['minutes']:.0f} by the clock)"
    return f"Suites, number and hash: {about}. Took {took}."
