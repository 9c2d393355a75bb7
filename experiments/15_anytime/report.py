"""Tables and the figure of what memory is worth where planning is dear."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from gcm_learn import seeding
from gcm_learn.evaluation import difference, holm, mcnemar, wilson
from gcm_learn.plots import style
from gcm_learn.storage import write_whole

HERE = Path(__file__).resolve().parent
ARMS = ("control", "hybrid", "hybrid-random")
CALLED = {"control": "no memory", "hybrid": "hybrid", "hybrid-random": "hybrid, random memories"}
COLOURS = {"hybrid": style.TARGET, "control": style.OBSTACLE, "hybrid-random": style.FAINT}
KINDS = {"free": "free joints", "limits": "limits of acceleration"}
WANTED = {"half": 0.10, "short": 0.05}  # by which the hybrid is to catch more
SHORT, LIMIT, NEAR = 20.0, 1000.0, 0.1  # [ms], [ms], horizons; as in `run`
DRAWS = 4000
AXIS = (1, 2, 5, 10, 20, 50, 100, 200)
Rows = list[dict[str, Any]]


def report(folder: Path, seed: int, choice: dict[str, Any]) -> None:
    """Write dear.json and dear.png of the answers to a suite."""
    made: dict[str, Any] = {"seed": seed}
    for kind in KINDS:
        path = folder / f"dear-{kind}-{seed}.jsonl"
        if path.exists():
            rows = [json.loads(line) for line in path.read_text("utf-8").splitlines()]
            made[kind] = of_kind(rows, choice[kind])
    decide([pair for kind in KINDS if kind in made for pair in made[kind]["pairs"].values()])
    write_whole(HERE / "dear.json", json.dumps(made, indent=1) + "\n")
    figure({kind: made[kind] for kind in KINDS if kind in made}, HERE / "dear.png")


def of_kind(rows: Rows, choice: dict[str, Any]) -> dict[str, Any]:
    """Return the results of one kind of joints."""
    budgets = {"half": choice["budget ms"], "short": SHORT}
    out: dict[str, Any] = {
        "control": choice["control"],
        "budgets ms": budgets,
        "situations": {s: sum(row["stratum"] == s for row in rows) for s in "WQ"},
        "families": dict(Counter(row["family"] for row in rows)),
        "complaints": sum(complaints(row) for row in rows),
        "fates": {name: fates(row["charged"][name] for row in rows) for name in budgets},
        "charged": {},
        "pairs": {},
    }  # fmt: skip
    family = np.array([row["family"] for row in rows])
    for name, ms in budgets.items():
        hits = {arm: np.array([caught(r["charged"][name], arm, ms) for r in rows]) for arm in ARMS}
        out["charged"][name] = {arm: by_stratum(rows, hit) for arm, hit in hits.items()}
        for other in ("control", "hybrid-random"):
            more = difference(hits["hybrid"], hits[other], family)
            won, lost, p = mcnemar(hits["hybrid"], hits[other])
            out["pairs"][f"{name}, {other}"] = {
                "more": list(more), "only hybrid": won, "only other": lost, "p": p,
                "wanted": WANTED[name],
            }  # fmt: skip
    out["curve"] = curve(rows, budgets)
    out["near"] = nearness(rows, family)
    return out


def fates(told: Iterable[Any]) -> dict[str, int]:
    """Return what became of arms during thought, where no method answered."""
    return dict(Counter(one for one in told if isinstance(one, str)))


def complaints(row: dict[str, Any]) -> int:
    """Return the number of answers that the referee complains of."""
    told = [*row["charged"].values(), *row.get("curve", {}).values()]
    answers = [one for each in told if isinstance(each, dict) for one in each.values()]
    return sum(bool(one.get("complaints")) for one in answers)


def caught(told: Any, arm: str, ms: float) -> bool:
    """Return whether a catch was ready in time."""
    if isinstance(told, str):
        return told == "caught"
    mine = told[arm]
    return mine["catch"] is not None and mine["ms"] <= ms and not mine["complaints"]


def by_stratum(rows: Rows, hits: np.ndarray) -> dict[str, list[float]]:
    """Shares with their 95 % intervals."""
    stratum = np.array([row["stratum"] for row in rows])
    masks = {"W": stratum == "W", "Q": stratum == "Q", "both": stratum != ""}
    return {name: list(wilson(int(hits[m].sum()), int(m.sum()))) for name, m in masks.items()}


def decide(pairs: list[dict[str, Any]]) -> None:
    """Add to each pair its probability after Holm, and whether what was wanted holds."""
    for pair, chance in zip(pairs, holm([pair["p"] for pair in pairs]), strict=True):
        pair["p, Holm"] = chance
        pair["holds"] = chance < 0.05 and pair["more"][0] >= pair["wanted"]


def curve(rows: Rows, budgets: dict[str, float]) -> dict[str, Any]:
    """Catches over the time to think, of the situations that were asked about it."""
    some = [row for row in rows if "curve" in row]
    if not some:
        return {}
    told = {float(ms): [row["curve"][ms] for row in some] for ms in some[0]["curve"]}
    told |= {ms: [row["charged"][name] for row in some] for name, ms in budgets.items()}
    at = sorted(told)
    shares = {
        arm: [list(wilson(sum(caught(one, arm, ms) for one in told[ms]), len(some))) for ms in at]
        for arm in ARMS
    }
    return {"situations": len(some), "ms": at, **shares}


def nearness(rows: Rows, family: np.ndarray) -> dict[str, Any]:
    """Processor time [ms] until a catch that comes within a tenth of the horizon of the best."""
    times = {arm: np.array([until_near(row, arm) for row in rows]) for arm in ARMS}
    ratios = {q: [] for q in (0.5, 0.9)}
    rng = seeding.rng(14, len(rows))
    groups = [np.flatnonzero(family == name) for name in sorted(set(family.tolist()))]
    for _ in range(DRAWS):
        draw = np.concatenate([rng.choice(group, len(group)) for group in groups])
        for q, kept in ratios.items():
            one, other = (np.quantile(times[arm][draw], q) for arm in ("hybrid", "control"))
            kept.append(one / other)
    out: dict[str, Any] = {
        arm: {
            "median ms": float(np.median(t)),
            "90 % ms": float(np.quantile(t, 0.9)),
            "95 % ms": float(np.quantile(t, 0.95)),
            "not in time": int((t >= LIMIT).sum()),
            "near at once": float(np.mean([at_once(row, arm) for row in rows])),
        }
        for arm, t in times.items()
    }
    for q, kept in ratios.items():
        one, other = (float(np.quantile(times[arm], q)) for arm in ("hybrid", "control"))
        low, high = np.quantile(kept, [0.025, 0.975])
        out[f"ratio, {q:.0%}"] = [one / other, float(low), float(high)]
    return out


def until_near(row: dict[str, Any], arm: str) -> float:
    """Return the time of one situation, or the limit."""
    last = latest(row)
    return min([ms for time, ms in row["improved"][arm] if time <= last], default=LIMIT)


def at_once(row: dict[str, Any], arm: str) -> bool:
    """Return whether the first answer comes so early."""
    return any(time <= latest(row) for time, _ in row["improved"][arm][:1])


def latest(row: dict[str, Any]) -> float:
    """By when a catch comes within a tenth of the horizon of the best known [s]."""
    known = [time for mine in row["improved"].values() for time, _ in mine]
    if row["reference"] is not None:
        known.append(row["reference"])
    return min(known, default=-np.inf) + NEAR * float(row["horizon"])


def figure(made: dict[str, Any], path: Path) -> None:
    """Catches over the time to think, and time until a good catch."""
    drawn = style.new_figure(4.4 * len(made), 3.2)
    panels = np.atleast_1d(drawn.subplots(1, len(made)))
    for ax, (kind, mine) in zip(panels, made.items(), strict=True):
        told = mine["curve"]
        for arm in ARMS:
            share = 100 * np.array(told[arm])
            ax.plot(told["ms"], share[:, 0], "o-", ms=3, color=COLOURS[arm], label=CALLED[arm])
            ax.fill_between(
                told["ms"], share[:, 1], share[:, 2], color=COLOURS[arm], alpha=0.12, lw=0
            )
        for ms in mine["budgets ms"].values():
            ax.axvline(ms, color=style.INK, lw=0.7, ls=":")
        ax.set_xscale("log")
        ax.set_xticks(AXIS, [str(ms) for ms in AXIS])
        ax.minorticks_off()
        ax.set(
            xlabel="time to think [ms], while the world goes on", ylabel="caught [%]", ylim=(0, 100)
        )
        style.title(ax, f"{KINDS[kind]}, {told['situations']} of W and Q")
    panels[0].legend(frameon=False, fontsize=style.SMALL, loc="lower right")
    drawn.savefig(path)
