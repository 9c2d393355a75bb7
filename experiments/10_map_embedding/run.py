"""Do maps find memories better than raw parameters do, the more so the more there is around?

python -m experiments 10_map_embedding DATASET

Writes table.md and figure.png. DATASET is a folder of `gcm-learn generate`. Encoders that know
memories by their way, by their map, by both and by raw parameters take the same lessons; they and
the controls are asked with the same memories, bent in the same way, in test situations to which
more and more obstacles are added that do not matter. Answers are kept in out/.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from autoencoder import AutoencoderIndex
from report import write_figure, write_table
from teaching import Given, filed, trained

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
    map_features,
    nearest_rows,
    raw_features,
)
from gcm_learn.situation import Situation
from gcm_learn.wave import MarchingParams

HERE = Path(__file__).resolve().parent
EXTRAS = (0, 1, 2, 4, 8)  # obstacles that are added
DRAWS = 400  # of obstacles, before a situation counts as too crowded
FREE = 0.1  # room that they leave the limb on the known catch [forearm lengths]
CELLS = 40  # along a side of the maps that must not change
STRATA = ("W", "Q")


def learned(labels: TransferLabels, turns: int, steps: int) -> dict[str, Memory]:
    """The memories filed by encoders that know different things of them."""
    given: Given = {}
    raw = np.array([raw_features(s) for s in labels.situations])
    padded = np.zeros((len(raw), map_features.COUNT), np.float32)
    padded[:, : raw.shape[1]] = Scale.of(raw)(raw)
    out = {}
    for name, kind, seen in (
        ("way", "trace", None),
        ("map", "map", labels.map_features),
        ("way and map", "both", labels.map_features),
        ("raw, learned", "map", padded),
    ):
        config = EncoderConfig(memory=kind, hard=0.0, steps=steps)  # type: ignore[arg-type]
        encoder = trained(labels, config, turns, seen, given)
        places = np.zeros((len(raw), encoder.dim), np.float32)
        if config.uses_traces:
            places += encoder._memory["trace"](labels.path_features)
        if seen is not None:
            places += encoder._memory["map"](seen)
        out[name] = filed(LearnedIndex(encoder), places, labels)
    return out


def controls(labels: TransferLabels) -> dict[str, Memory]:
    """The memories filed without learning."""
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
    """The situation with ever more obstacles that do not matter.

    They leave the limb on the known catch alone; if `strict`, the map stays the same as well.
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


def questions(
    records: dataset.Dataset, stratum: str, count: int, strict: bool
) -> list[tuple[str, list[Situation]]]:
    """Families and planar test situations of a stratum, each with ever more obstacles."""
    out = []
    for record in records.where(split="test", stratum=stratum):
        plans = [p for p in record.plans.values() if p.caught]
        if plans and not record.situation.is_solid:
            best = min(plans, key=lambda p: p.catch_time or 0.0)
            row = crowded(record.situation, best, record.index, strict)
            out += [(record.family, row)] if len(row) == len(EXTRAS) else []
        if len(out) == count:
            break
    return out


def answers(memories: dict[str, Memory], records: dataset.Dataset, count: int) -> Iterator[dict]:
    """Return the catches of every question with every memory."""
    for added in ("map unchanged", "catch unchanged"):
        for stratum in STRATA:
            asked = questions(records, stratum, count, added == "map unchanged")
            print(added, stratum, len(asked), flush=True)
            for name, memory in memories.items():
                planner = RecallPlanner(memory)
                for case, (family, row) in enumerate(asked):
                    for extra, situation in zip(EXTRAS, row, strict=True):
                        found = planner.recollect(situation)
                        yield {
                            "index": name, "added": added, "stratum": stratum, "case": case,
                            "family": family, "extra": extra, "caught": found.plan.caught,
                            "checks": found.checked,
                        }  # fmt: skip


def main() -> None:
    """Train, ask, write table.md and figure.png."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("dataset")
    parser.add_argument("--records", type=int, default=10_000, help="that are read")
    parser.add_argument("--turns", type=int, default=24, help="lessons of every encoder")
    parser.add_argument("--steps", type=int, default=20, help="of the optimiser after each")
    parser.add_argument("--situations", type=int, default=150, help="of each stratum")
    given = parser.parse_args()
    records = dataset.open(given.dataset)
    (HERE / "out").mkdir(exist_ok=True)
    effort = f"{given.turns} lessons, {given.steps} steps after each"
    size = f"{given.records}-{given.turns}-{given.steps}-{given.situations}"
    file = HERE / "out" / f"answers-{size}.json"
    if not file.exists():
        labels = TransferLabels(records[: given.records], 1, maps=True)
        memories = learned(labels, given.turns, given.steps) | controls(labels)
        lines = list(answers(memories, records, given.situations))
        file.write_text(json.dumps({"memories": len(labels.knots), "lines": lines}))
    made = json.loads(file.read_text())
    lines, told = made["lines"], f"{made['memories']} memories; encoders: {effort}"
    write_table(HERE / "table.md", lines, told)
    write_figure(HERE / "figure.png", lines)


if __name__ == "__main__":
    main()
