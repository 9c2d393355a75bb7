"""Do maps find memories better than raw parameters do, the more so the more there is around?

python -m experiments 10_map_embedding DATASET     outcomes, then the table and the figure

DATASET is a folder of `gcm-learn generate`. Encoders that know memories by their path, by their
map, by both and by raw parameters take the same lessons. They and the controls are asked with the
same memories, adapted in the same way. More and more obstacles that do not matter are added to the
situations. Answers are kept in out/.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from autoencoder import AutoencoderIndex
from report import write_figure
from teaching import Given, filed, trained

from experiments import recompute
from experiments.common import outcomes
from experiments.common.questions import Question
from gcm_learn import dataset, seeding
from gcm_learn.families.random_planar import RandomPlanar
from gcm_learn.maps import build_map
from gcm_learn.motion.clearance import clearance
from gcm_learn.planners import Plan
from gcm_learn.planners.completion import Problem
from gcm_learn.recall import (
    EncoderConfig,
    LearnedIndex,
    Memory,
    PcaIndex,
    RandomIndex,
    RawIndex,
    RecallPlanner,
    Scale,
    TransferLabels,
    Waypoints,
    nearest_rows,
    raw_features,
)
from gcm_learn.recall.features import COUNT as COUNT_OF_MAP
from gcm_learn.situation import Situation
from gcm_learn.wave import MarchingParams

HERE = Path(__file__).resolve().parent
RECORDS = 10_000  # that are read
TURNS, STEPS = 24, 20  # lessons of every encoder, steps of the optimiser after each
COUNT = 150  # situations of each stratum
EXTRAS = (0, 1, 2, 4, 8)  # obstacles that are added
DRAWS = 400  # of obstacles, before a situation counts as too crowded
FREE = 0.1  # clearance that they leave the limb on the known catch [forearm lengths]
CELLS = 40  # along a side of the maps that must not change
STRATA = ("W", "Q")
SPLITS = ("test", "validation")  # no lesson is about these


def learned(labels: TransferLabels) -> dict[str, Memory]:
    """Return the memories filed by encoders that know different things of them."""
    given: Given = {}
    raw = np.array([raw_features(s) for s in labels.situations])
    padded = np.zeros((len(raw), COUNT_OF_MAP), np.float32)
    padded[:, : raw.shape[1]] = Scale.of(raw)(raw)
    out = {}
    for name, kind, seen in (
        ("path", "trace", None),
        ("map", "map", labels.map_features),
        ("path and map", "both", labels.map_features),
        ("raw, learned", "map", padded),
    ):
        config = EncoderConfig(memory=kind, hard=0.0, steps=STEPS)  # type: ignore[arg-type]
        encoder = trained(labels, config, TURNS, seen, given)
        places = np.zeros((len(raw), encoder.dim), np.float32)
        if config.uses_traces:
            places += encoder._memory["trace"](labels.path_features)
        if seen is not None:
            places += encoder._memory["map"](seen)
        out[name] = filed(LearnedIndex(encoder), places, labels)
    return out


def controls(labels: TransferLabels) -> dict[str, Memory]:
    """Return the memories filed without learning."""
    raw = np.array([raw_features(s) for s in labels.situations])
    scale, pca, lots = Scale.of(raw), PcaIndex.fit(labels.situations[:3000]), RandomIndex()
    codes = AutoencoderIndex.fit(labels.situations[:3000])
    traces = [Waypoints(k, g) for k, g in zip(labels.knots, labels.goals, strict=True)]
    return {
        "raw neighbours": filed(RawIndex(scale), nearest_rows(scale(raw)), labels),
        "components of maps": filed(pca, pca.embed_memories(labels.situations, traces), labels),
        "codes of maps": filed(codes, codes.embed_memories(labels.situations, traces), labels),
        "random": filed(lots, lots.embed_memories(labels.situations, traces), labels),
    }


def same_map(before: Situation, after: Situation) -> bool:
    """Return whether an obstacle leaves a situation's map alone: arrivals, effective obstacles."""
    maps = [build_map(s, MarchingParams(n=CELLS)) for s in (before, after)]
    arrivals = [made.arrival.filled(-1.0) for made in maps]
    walls = [made.effective_obstacles for made in maps]
    return bool(np.array_equal(*arrivals) and np.array_equal(*walls))


def crowded(situation: Situation, plan: Plan, seed: int, strict: bool) -> list[Situation]:
    """Return the situation with ever more obstacles that do not matter.

    They stay clear of the limb on the known catch; if `strict`, the map stays the same as well.
    """
    now, found = situation, [situation]
    for k in range(DRAWS):
        rng = seeding.rng(6, seed, k)
        drawn = RandomPlanar(obstacles=(1, 1)).sketch(rng, "drawn").obstacles[0]
        more = replace(now, bodies=(*now.bodies, replace(drawn, name=f"extra {k}")))
        if Problem(more, "crowd").early_answer() is not None:
            continue
        if clearance(more, plan.trajectory)[0] <= min(FREE, plan.clearance - 1e-6):
            continue
        if strict and not same_map(now, more):
            continue
        now = more
        if len(now.bodies) - len(situation.bodies) in EXTRAS:
            found.append(now)
        if len(found) == len(EXTRAS):
            break
    return found


def questions(records: dataset.Dataset, strict: bool) -> Iterator[tuple[int, Question]]:
    """Yield planar situations of W and Q with ever more obstacles, and how many these are."""
    for stratum in STRATA:
        found = 0
        for record in records.where(split=SPLITS, stratum=stratum):
            plans = [p for p in record.plans.values() if p.caught]
            if not plans or record.situation.is_solid:
                continue
            best = min(plans, key=lambda p: p.catch_time or 0.0)
            row = crowded(record.situation, best, record.index, strict)
            if len(row) < len(EXTRAS):
                continue
            for extra, situation in zip(EXTRAS, row, strict=True):
                yield extra, Question(stratum, record.family, record.index, situation)
            found += 1
            if found == COUNT:
                break


def answers(records: dataset.Dataset) -> Iterator[dict[str, Any]]:
    """Yield the outcomes of every question with every memory."""
    labels = TransferLabels(records[:RECORDS], 1, maps=True)
    print(len(labels.knots), "memories", flush=True)
    memories = learned(labels) | controls(labels)
    for added in ("map unchanged", "catch unchanged"):
        asked = list(questions(records, added == "map unchanged"))
        print(added, len(asked), flush=True)
        for name, memory in memories.items():
            planner = RecallPlanner(memory)
            for extra, question in asked:
                found = planner.recollect(question.situation)
                row = question.about() | {"method": name, "added": added, "extra": extra}
                yield row | {"caught": found.plan.caught, "checks": found.checked}


def main() -> None:
    """Train and ask, or read the answers; write the outcomes, and what is computed from them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("dataset")
    records, file = dataset.open(parser.parse_args().dataset), HERE / "outcomes.csv.gz"
    outcomes.write(file, outcomes.kept(HERE / "out" / "answers.jsonl", lambda: answers(records)))
    recompute.update(HERE)
    write_figure(HERE / "figure.png", outcomes.read(file))


if __name__ == "__main__":
    main()
