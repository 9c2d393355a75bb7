"""The tables of the comparison."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from gcm_learn.evaluation import (
    DELAYS,
    Interval,
    Results,
    chance,
    declines,
    difference,
    mcnemar,
    measured,
    stratified,
    under_noise,
)

ALLOWED = 20.0  # thinking that H1 grants [ms]


def share(interval: Interval) -> str:
    """A share with its interval [%]."""
    return f"{100 * interval.value:.1f} ({100 * interval.low:.0f}–{100 * interval.high:.0f})"


def line(*cells: str) -> str:
    """A row of a table."""
    return "| " + " | ".join(cells) + " |"


def head(*cells: str) -> list[str]:
    """The head of a table."""
    return [line(*cells), "|" + "---|" * len(cells)]


def caught(results: Results) -> Interval:
    """Share caught, resampled within families."""
    return stratified(results["outcome"] == "caught", results["family"].astype(str))


def by_stratum(whole: Results) -> list[str]:
    """Catches, touches, times and latency of every method."""
    lines = head(
        "policy", "L", "W", "Q", "touched, W and Q", "U declined", "time / oracle", "ms", "95 %"
    )
    for name in whole.methods:
        mine = whole.of_method(name)
        cells = [share(caught(mine.where(mine["stratum"] == s))) for s in "LWQ"]
        hard = measured(mine.where(np.isin(mine["stratum"].astype(str), ("W", "Q"))), name)
        all_of_it = measured(mine.where(mine["stratum"] != "U"), name)
        lines.append(
            line(
                f"`{name}`", *cells, f"{100 * hard.collisions.value:.1f}",
                f"{100 * declines(whole, name).value:.1f}", f"{all_of_it.ratio:.3f}",
                f"{all_of_it.latency:.1f}", f"{all_of_it.latency_95:.1f}",
            )
        )  # fmt: skip
    return lines


def of_natural(natural: Results) -> list[str]:
    """Catches of what can be caught in the natural mix."""
    reachable = natural.where(natural["stratum"] != "U")
    lines = head("policy", f"caught of {len(reachable) // len(natural.methods)}", "touched")
    for name in natural.methods:
        m = measured(reachable, name)
        lines.append(line(f"`{name}`", share(m.caught), f"{100 * m.collisions.value:.1f}"))
    return lines


def in_time(results: Results, name: str) -> np.ndarray:
    """Catches after 20 ms in which an answer was found (n,) bool."""
    mine = results.of_method(name)
    return (mine["charged_20"] == "caught") & (mine["latency_ms"] <= ALLOWED)


def thinking(charged: Results) -> list[str]:
    """Catches of W over charged time, and H1."""
    delays = [f"charged_{round(1e3 * delay)}" for delay in DELAYS]
    lines = head(
        "policy", *(f"{name.removeprefix('charged_')} ms" for name in delays), "own latency",
        "20 ms, if ready by then", "ms", "95 %",
    )  # fmt: skip
    for name in charged.methods:
        mine = charged.of_method(name)
        groups, m = mine["family"].astype(str), measured(charged, name)
        cells = [share(stratified(mine[d] == "caught", groups)) for d in (*delays, "charged_own")]
        cells.append(share(stratified(in_time(charged, name), groups)))
        lines.append(line(f"`{name}`", *cells, f"{m.latency:.1f}", f"{m.latency_95:.1f}"))
    first, second = charged.of_method("hybrid"), charged.of_method("gcm")
    groups = first["family"].astype(str)
    lines += ["", *head("`hybrid` against `gcm` on W", "points (95 %)", "only `hybrid`",
                        "only `gcm`", "p (McNemar)")]  # fmt: skip
    pairs = {
        "20 ms of thinking charged": [r["charged_20"] == "caught" for r in (first, second)],
        "20 ms charged, nothing done if not ready by then": [
            in_time(charged, "hybrid"), in_time(charged, "gcm"),
        ],
        "own latency charged": [r["charged_own"] == "caught" for r in (first, second)],
    }  # fmt: skip
    for words, (a, b) in pairs.items():
        d, (only_a, only_b, p) = difference(a, b, groups), mcnemar(a, b)
        points = f"{100 * d.value:+.1f} ({100 * d.low:.1f} to {100 * d.high:.1f})"
        lines.append(line(words, points, str(only_a), str(only_b), chance(p)))
    return lines


def inexact(noise: Results) -> list[str]:
    """Catches under inexact perception."""
    lines = head("policy", "deviation [forearms]", "plans", "caught", "touched", "lost [points]")
    for b in under_noise(noise):
        lines.append(
            line(
                f"`{b.method}`", f"{b.noise:g}", b.way if b.noise else "exact",
                share(b.caught), f"{100 * b.collisions:.1f}", f"{100 * b.lost:.1f}",
            )
        )  # fmt: skip
    return lines


def write_tables(
    file: Path,
    whole: Results,
    charged: Results,
    noise: Results,
    natural: Results | None,
    hashes: dict[str, str],
    costs: dict[str, dict[str, float]],
) -> None:
    """Write all tables into one file."""
    counts = ", ".join(f"{name} ({text})" for name, text in hashes.items())
    spent = ", ".join(
        f"{name} {cost['cpu']:.0f} min of a core ({cost['minutes']:.0f} by the clock)"
        for name, cost in costs.items()
    )
    n = len(noise.where((noise["noise"] == 0.0) & (noise["entrant"] == noise.methods[0])))
    parts = [
        f"Suites, how many of each and hash: {counts}. Took: {spent}.",
        "## By stratum\n\nCatches [%] with 95 % intervals, resampled within families.",
        "\n".join(by_stratum(whole)),
        "## Thinking is charged\n\nCatches of W [%] if the world runs on while they think.",
        "\n".join(thinking(charged)),
        f"## Perception is not exact\n\nCatches [%] of {n} situations of W and Q.",
        "\n".join(inexact(noise)),
    ]
    if natural is not None:
        parts += ["## The natural mix\n\nReachable situations [%].", "\n".join(of_natural(natural))]
    file.write_text("\n\n".join(parts) + "\n", "utf-8")
