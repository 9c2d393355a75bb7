"""What does experience do to a memory? Writes table.md and figure.png.

python experiments/08_growth/run.py DATASET [ENCODER]

DATASET is a folder of `gcm-learn generate`, whose validation records are met one after the other,
ENCODER one of `gcm-learn train-encoder` (the shipped one by default). What is done is kept in out/.
"""

from __future__ import annotations

import argparse
import json
import sys
import time
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np

matplotlib.use("Agg")
import matplotlib.pyplot as plt

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parents[1])]

from gcm_learn import dataset  # noqa: E402
from gcm_learn.dataset import planner_of  # noqa: E402
from gcm_learn.evaluation import stratified  # noqa: E402
from gcm_learn.recall import (  # noqa: E402
    Coverage,
    Index,
    LearnedIndex,
    Memory,
    RawIndex,
    grow,
    load_encoder,
)
from gcm_learn.situation import Situation  # noqa: E402

MIXES = {"natural": ("L", "W", "Q", "U"), "W and Q": ("W", "Q")}
RULES = {"what was not recalled": np.inf, "also what came 10 % late": 0.1, "all": -1.0}
SMALL = (10, 40)  # memories that forget
FORGET = ("least used", "oldest", "random")
WINDOW = 300  # experiences that a rate is taken of
LATTICE = (80, 1)  # cells and rungs of the planner: those of the labels
COLOURS = {"learned": "#0b6e4f", "raw": "#c1666b"}
Run = dict[str, Any]


def met(records: dataset.Dataset, strata: tuple[str, ...], most: int) -> tuple[list, list]:
    """Situations that no encoder has learned from, and their families."""
    some = records.where(split="validation", stratum=strata)[:most]
    pairs = [(record.situation, record.family) for record in some]
    return [s for s, _ in pairs], [f for _, f in pairs]


def grown(
    file: Path, name: str, index: Index, situations: list[Situation], families: list[str],
    rule: str, most: int | None = None, forget: str = "least used",
) -> Run:  # fmt: skip
    """One life of a memory, unless it has been lived."""
    if not file.exists():
        memory, began = Memory(index, "exact"), time.process_time()
        planner = planner_of("layered", *LATTICE)
        steps = grow(memory, situations, planner, Coverage(RULES[rule]), most=most, forget=forget)
        run = {
            "index": name, "rule": rule, "most": most, "forget": forget if most else None,
            "recalled": [int(s.recalled) for s in steps],
            "caught": [int(s.caught) for s in steps],
            "sizes": [s.size for s in steps], "families": families,
            "seconds": time.process_time() - began,
        }  # fmt: skip
        file.write_text(json.dumps(run))
    run = json.loads(file.read_text())
    print(file.stem, run["sizes"][-1], np.mean(run["recalled"]), f"{run['seconds']:.0f} s",
          flush=True)  # fmt: skip
    return run


def rate(run: Run, first: int, last: int) -> tuple[float, float, float]:
    """Share of what was caught at all that was caught from memory [%], with its interval."""
    caught = np.array(run["caught"][first:last], bool)
    hits = np.array(run["recalled"][first:last], bool)[caught]
    value, low, high = stratified(hits, np.array(run["families"][first:last])[caught])
    return 100.0 * value, 100.0 * low, 100.0 * high


def write_table(file: Path, runs: dict[str, list[Run]], key: str) -> None:
    """Rates early and late, and sizes."""
    heads = ["met", "index", "remembered", "at most, forgets",
             "caught from memory: experiences 1-300", f"last {WINDOW}", "memories",
             "per 100 at the end"]  # fmt: skip
    lines = ["| " + " | ".join(heads) + " |", "|---" * len(heads) + "|"]
    for mix, some in runs.items():
        for run in some:
            early, late = rate(run, 0, WINDOW), rate(run, -WINDOW, None)
            limit = f"{run['most']}, {run['forget']}" if run["most"] else ""
            fresh = (run["sizes"][-1] - run["sizes"][-WINDOW - 1]) * 100 / WINDOW
            more = "" if run["most"] else f"{fresh:.0f}"
            lines.append(
                f"| {mix} | {run['index']} | {run['rule']} | {limit} | {_cell(early)} | "
                f"{_cell(late)} | {run['sizes'][-1]} | {more} |"
            )
    count = ", ".join(f"{len(some[0]['sizes'])} {mix}" for mix, some in runs.items())
    lines += ["", f"Situations met: {count}. Shares [%] of what was caught at all, before anything "
              "was learned from it, with at most 20 checks; 95 % intervals; encoder "
              f"`{key}`."]  # fmt: skip
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")


def _cell(interval: tuple[float, float, float]) -> str:
    return "{:.1f} ({:.0f}–{:.0f})".format(*interval)


def smooth(run: Run) -> np.ndarray:
    """Rate over a sliding window [%]."""
    caught, hits = np.array(run["caught"], float), np.array(run["recalled"], float)
    box = np.ones(WINDOW)
    return 100.0 * np.convolve(hits, box, "valid") / np.convolve(caught, box, "valid")


def write_figure(file: Path, runs: dict[str, list[Run]]) -> None:
    """Rates and sizes against experience."""
    figure, axes = plt.subplots(2, 3, figsize=(13.0, 6.4), layout="constrained")
    styles = dict(zip(RULES, ("-", "-.", ":"), strict=True))
    for column, (mix, some) in enumerate(runs.items()):
        for run in (r for r in some if not r["most"]):
            look = {"color": COLOURS[run["index"]], "ls": styles[run["rule"]]}
            label = f"{run['index']}, remembers {run['rule']}"
            rates = smooth(run)
            axes[0, column].plot(np.arange(len(rates)) + WINDOW, rates, label=label, **look)
            axes[1, column].plot(run["sizes"], **look)
        axes[0, column].set(title=f"met: {mix}", ylabel="caught from memory [%]", ylim=(40, 101))
        axes[1, column].set(xlabel="experience", ylabel="memories", yscale="log")
    axes[0, 0].legend(fontsize=8)
    colours = dict(zip(FORGET, ("#0b6e4f", "#d4a017", "#7d8597"), strict=True))
    for row, most in enumerate(SMALL):
        ax = axes[row, 2]
        for run in (r for r in runs["W and Q"] if r["most"] == most):
            rates = smooth(run)
            ax.plot(np.arange(len(rates)) + WINDOW, rates, color=colours[run["forget"]],
                    label=f"forgets {run['forget']}")  # fmt: skip
        ax.set(title=f"W and Q, at most {most} memories", ylabel="caught from memory [%]")
    axes[0, 2].legend(fontsize=8)
    axes[1, 2].set(xlabel="experience")
    for ax in axes.flat:
        ax.grid(alpha=0.25)
    figure.savefig(file, dpi=120)
    plt.close(figure)


def main() -> None:
    """Live all lives; write table.md and figure.png."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("dataset")
    parser.add_argument("encoder", nargs="?", default=str(HERE.parents[1] / "models" / "encoder"))
    parser.add_argument("--experiences", type=int, default=1500)
    given = parser.parse_args()
    records, encoder = dataset.open(given.dataset), load_encoder(given.encoder)
    out = HERE / "out" / str(given.experiences)
    out.mkdir(parents=True, exist_ok=True)
    runs: dict[str, list[Run]] = {}
    for mix, strata in MIXES.items():
        situations, families = met(records, strata, given.experiences)
        indexes = {"learned": LearnedIndex(encoder), "raw": RawIndex.fit(situations[:1000])}
        runs[mix] = []
        for name, index in indexes.items():
            stamp = f"{mix}-{name}-{index.key}".replace(" ", "-")
            for rule in RULES:
                if rule == "also what came 10 % late" and name == "raw":
                    continue
                file = out / f"{stamp}-{RULES[rule]}.json"
                runs[mix].append(grown(file, name, index, situations, families, rule))
            if mix != "W and Q" or name == "raw":
                continue
            for most in SMALL:
                for forget in FORGET:
                    file = out / f"{stamp}-{most}-{forget.replace(' ', '-')}.json"
                    runs[mix].append(
                        grown(file, name, index, situations, families,
                              "what was not recalled", most, forget)
                    )  # fmt: skip
    write_table(HERE / "table.md", runs, encoder.key)
    write_figure(HERE / "figure.png", runs)


if __name__ == "__main__":
    main()
