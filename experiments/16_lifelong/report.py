"""Reports on the lives of `run.py`: results.json, table.md and figure.png."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from stream import Met

from experiments.common.tables import table
from gcm_learn.evaluation import holm, mcnemar, stratified, wilson
from gcm_learn.plots import style
from gcm_learn.storage import write_whole

HERE = Path(__file__).resolve().parent
OTHERS = ("least used", "oldest", "random", "stops", "drawn")
MEASURES = {"life": "during life", "first": "first family at the end", "all": "all at the end"}
LIVES = ("life", "memories", *MEASURES.values(), "planned", "seconds")
PAIRS = ("pair", "measure", "only the first", "only the other", "points", "p", "p (Holm)")
COLOURS = {
    "no limit": style.INK,
    "covered": style.GOOD,
    "least used": style.OBSTACLE,
    "oldest": style.EXTENDED,
    "random": style.FAINT,
    "stops": style.TARGET,
    "drawn": style.EFFECTIVE,
}
Run = dict[str, Any]


def hits(row: str, mets: Sequence[Met]) -> np.ndarray:
    """Return whether catches of the teacher were caught from memory (n,)."""
    pairs = zip(row, mets, strict=True)
    return np.array([bit == "1" for bit, met in pairs if met.plan.caught])


def rows_of(run: Run) -> dict[str, str]:
    """Return the answers that each measure is taken of."""
    return {"life": run["recalled"], "first": run["first"][-1][1], "all": run["mixed"]}


def figures_of(run: Run, phases: list[tuple[str, int]], seen: dict[str, list[Met]]) -> Run:
    """The numbers of a life."""
    out: Run = {name: run[name] for name in ("index", "rule", "most", "judged")}
    out["complaints"], out["size"] = len(run["complaints"]), run["sizes"][-1]
    out["seconds"] = run["seconds"]
    for name, row in rows_of(run).items():
        caught = hits(row, seen[name])
        families = np.array([met.family for met in seen[name] if met.plan.caught])
        share = (
            stratified(caught, families) if name == "life" else wilson(caught.sum(), len(caught))
        )
        out[name] = {"n": len(caught), "percent": [round(100.0 * v, 2) for v in share]}
    out["planned"] = round(100.0 * run["recalled"].count("0") / len(run["recalled"]), 2)
    out["families"], at = {}, 0
    for name, count in phases:
        part = slice(at, at + count)
        caught = hits(run["recalled"][part], seen["life"][part])
        out["families"][name] = round(100.0 * float(caught.mean()), 2)
        at += count
    kept = {k: float(hits(row, seen["first"]).mean()) for k, row in run["first"]}
    out["kept"] = {phases[k][0]: round(100.0 * share, 2) for k, share in kept.items()}
    out["sizes"] = run["sizes"][99::100]
    return out


def pairs_of(runs: dict[str, Run], seen: dict[str, list[Met]]) -> list[Run]:
    """The cover rule beside each other way at the same size, Holm's correction over all."""
    out: list[Run] = []
    for title in (title for title in runs if title.endswith(", covered")):
        for other in OTHERS:
            against = title.replace("covered", other)
            for measure in MEASURES if against in runs else ():
                one, two = (
                    hits(rows_of(runs[t])[measure], seen[measure]) for t in (title, against)
                )
                ours, theirs, p = mcnemar(one, two)
                points = round(100.0 * (ours - theirs) / len(one), 2)
                out.append({"one": title, "other": against, "measure": measure, "only one": ours,
                            "only other": theirs, "points": points, "p": p})  # fmt: skip
    for pair, chance in zip(out, holm([pair["p"] for pair in out]), strict=True):
        pair["holm"], pair["p"] = float(f"{chance:.2g}"), float(f"{pair['p']:.2g}")
    return out


def write_table(results: Run) -> None:
    """table.md."""
    lives = []
    for title, run in results["lives"].items():
        cells = ["{:.1f} ({:.1f}–{:.1f})".format(*run[name]["percent"]) for name in MEASURES]
        cells += [f"{run['planned']:.1f}", f"{run['seconds']:.0f}"]
        lives.append([title, run["size"], *cells])
    pairs = []
    for pair in results["pairs"]:
        other = pair["other"].rsplit(", ", 1)[1]
        which = [f"{pair['one']} against {other}", MEASURES[pair["measure"]]]
        which += [pair["only one"], pair["only other"], f"{pair['points']:+.1f}"]
        pairs.append([*which, f"{pair['p']:.1g}", f"{pair['holm']:.1g}"])
    counts = {name: next(iter(results["lives"].values()))[name]["n"] for name in MEASURES}
    judged = sum(run["judged"] for run in results["lives"].values())
    broken = sum(run["complaints"] for run in results["lives"].values())
    about = (
        f"Seed {results['seed']}; {results['count']} situations, of which the teacher catches "
        f"{counts['life']}; {counts['first']} fresh ones of the first family and {counts['all']} "
        "of all. Shares [%] of what the teacher catches, within 20 checks and before anything is "
        "learned from the situation; 95 % intervals. Planned: share of all situations in which "
        "recall failed. Seconds of processor time, the referee's among them. It judged "
        f"{judged} catches: {broken} complaints."
    )
    parts = [table(LIVES, lives), table(PAIRS, pairs), about]
    write_whole(HERE / "table.md", "\n\n".join(parts) + "\n")


def draw(results: Run) -> None:
    """figure.png: rates by family, and on the first family after each."""
    figure = style.new_figure(9.6, 6.2)
    axes = figure.subplots(2, 2, sharex=True, sharey="row")
    lives = results["lives"]
    names = list(next(iter(lives.values()))["families"])
    for column, share in enumerate(("1/10", "1/3")):
        some = {"no limit": lives["learned, no limit"]}
        titles = {rule: f"learned, {share}, {rule}" for rule in COLOURS}
        some |= {rule: lives[title] for rule, title in titles.items() if title in lives}
        for rule, run in some.items():
            look: dict[str, Any] = {"color": COLOURS[rule], "lw": 2.0 if rule == "covered" else 1.1}
            look |= {"marker": "o", "ms": 2.5, "label": rule}
            axes[0, column].plot(list(run["families"].values()), **look)
            places = [names.index(name) for name in run["kept"]]
            axes[1, column].plot(places, list(run["kept"].values()), **look)
        most = some["covered"]["most"]
        axes[0, column].set_title(f"at most {most} memories ({share})", fontsize=style.TITLE)
        axes[1, column].set_xticks(range(len(names)), names, rotation=90, fontsize=style.SMALL)
    axes[0, 0].set_ylabel("caught from memory,\nfamily by family [%]", fontsize=style.LABEL)
    axes[1, 0].set_ylabel(
        f"on fresh ones of {names[0]}\nafter each family [%]", fontsize=style.LABEL
    )
    axes[0, 0].legend(fontsize=style.SMALL, ncols=2)
    for ax in axes.flat:
        ax.grid(alpha=0.25)
    figure.savefig(HERE / "figure.png", dpi=85)


def write(
    runs: dict[str, Run], phases: list[tuple[str, int]], seen: dict[str, list[Met]], about: Run
) -> None:
    """All three files."""
    lives = {title: figures_of(run, phases, seen) for title, run in runs.items()}
    results = {**about, "lives": lives, "pairs": pairs_of(runs, seen)}
    write_whole(HERE / "results.json", json.dumps(results, indent=1) + "\n")
    write_table(results)
    draw(results)
