"""What of the encoder and of recall is worth what? Writes table.md and figure.png.

python experiments/12_ablations/run.py DATASET [ENCODER]

DATASET is a folder of `gcm-learn generate`, ENCODER one of `gcm-learn train-encoder` (the shipped
one by default), with which the parts of recall are left out one by one. The parts of the encoder
are left out of small ones that are trained here, all for the same number of turns.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "10_map_embedding"), str(HERE.parents[1])]

from ablation_report import write_figure, write_table  # noqa: E402
from replay import replayed  # noqa: E402
from teaching import Given, filed, trained  # noqa: E402

from gcm_learn import dataset  # noqa: E402
from gcm_learn.planners.completion import Problem  # noqa: E402
from gcm_learn.recall import (  # noqa: E402
    Adaptation,
    EncoderConfig,
    LearnedIndex,
    Memory,
    RecallPlanner,
    TransferLabels,
    Waypoints,
    load_encoder,
    unverified,
)
from gcm_learn.situation import Situation  # noqa: E402
from gcm_learn.situation.canonical import canonical  # noqa: E402

STRATA = ("L", "W", "Q")
Found = tuple[bool, int]
Ask = Callable[[Situation], Found]


def encoders(steps: int) -> dict[str, EncoderConfig]:
    """What is trained; all but one learn from the same lessons."""
    base = EncoderConfig(hard=0.0, steps=steps)
    sizes = {f"{dim} numbers": replace(base, dim=dim) for dim in (4, 16, 64)}
    return {
        "base: 32 numbers, three losses": base,
        "base, another seed": replace(base, seed=1),
        **sizes,
        "without the listwise loss": replace(base, listwise=0.0),
        "without the contrast": replace(base, contrast=0.0),
        "with lessons on its own favourites": replace(base, hard=0.6),
    }


def by(planner: RecallPlanner) -> Ask:
    """What a planner that recalls answers."""

    def ask(situation: Situation) -> Found:
        found = planner.recollect(situation)
        return found.plan.caught, found.checked

    return ask


def by_replay(memory: Memory, moved: bool) -> Ask:
    """The memories that fit best, replayed one after the other without being bent."""

    def ask(situation: Situation) -> Found:
        turned, _ = canonical(situation)
        problem = Problem(turned, "replay")
        chosen = memory.recall(memory.index.embed_query(turned, problem.bodies), 20)
        for k, m in enumerate(chosen.tolist()):
            if replayed(problem, Waypoints(memory.knots[m], memory.goals[m]), moved):
                return True, k + 1
        return False, len(chosen)

    return ask


def recalls(memory: Memory) -> dict[str, Ask]:
    """Recall as it is, and with parts left out."""
    whole, plain = RecallPlanner(memory), Adaptation(bends=0)
    return {
        "recall as it is": by(whole),
        "a path that touches is not bent": by(replace(whole, how=plain)),
        "failures teach nothing": by(replace(whole, novelty=0.0, penalty=0.0)),
        "bent in cartesian coordinates": by(replace(whole, how=Adaptation(style="cartesian"))),
        "remembered times are kept": by(replace(whole, how=Adaptation(tempo="keep"))),
        "moved rigidly, not bent": by_replay(memory, True),
        "replayed as it is, from its own start": by_replay(memory, False),
        "not verified: acts on the first": lambda s: (unverified(memory, s).worked, 1),
    }


def questions(records: dataset.Dataset, count: int) -> list[tuple[str, str, Situation]]:
    """Stratum, family and situation of validation records; tests are not touched."""
    out = []
    for stratum in STRATA:
        some = records.where(split="validation", stratum=stratum)
        out += [(stratum, r.family, r.situation) for r in some[:count]]
    return out


def answers(name: str, ask: Ask, asked: list, **more: Any) -> Iterator[dict[str, Any]]:
    """Answers to all questions."""
    caught = []
    for stratum, family, situation in asked:
        hit, checks = ask(situation)
        caught.append(hit)
        yield {"name": name, "stratum": stratum, "family": family, "caught": bool(hit),
               "checks": checks, **more}  # fmt: skip
    print(name, f"{np.mean(caught):.3f}", flush=True)


def main() -> None:
    """Train, ask, write table.md and figure.png."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("dataset")
    parser.add_argument("encoder", nargs="?", default=str(HERE.parents[1] / "models" / "encoder"))
    parser.add_argument("--records", type=int, default=4000, help="that are read")
    parser.add_argument("--turns", type=int, default=12, help="lessons of every encoder")
    parser.add_argument("--steps", type=int, default=20, help="of the optimiser after each")
    parser.add_argument("--situations", type=int, default=150, help="of each stratum")
    given = parser.parse_args()
    records, encoder = dataset.open(given.dataset), load_encoder(given.encoder)
    labels = TransferLabels(records[: given.records], 1)
    asked = questions(records[given.records :], given.situations)
    (HERE / "out").mkdir(exist_ok=True)
    places = encoder.embed_memories([], labels.knots, labels.goals)
    lines = []
    for name, ask in recalls(filed(LearnedIndex(encoder), places, labels)).items():
        lines += answers(name, ask, asked, part="recall")
    taught: Given = {}
    for name, config in encoders(given.steps).items():
        file = HERE / "out" / f"{name}-{given.turns}-{given.steps}-{given.records}.json"
        if not file.exists():
            small = trained(labels, config, given.turns, None, taught)
            places = small.embed_memories([], labels.knots, labels.goals)
            planner = RecallPlanner(filed(LearnedIndex(small), places, labels))
            file.write_text(json.dumps(list(answers(name, by(planner), asked, part="encoder"))))
        lines += json.loads(file.read_text())
    told = (
        f"{len(labels.knots)} memories; recall: encoder `{encoder.key}`; encoders trained here: "
        f"{given.turns} lessons, {given.steps} steps after each"
    )
    write_table(HERE / "table.md", lines, told)
    write_figure(HERE / "figure.png", lines)


if __name__ == "__main__":
    main()
