"""Do maps find memories better than raw parameters do, the more so the more there is around?

python -m experiments 10_map_embedding PLANE SPACE     sheets, their pages and tables in out/

Both are folders of `gcm-learn generate`. Encoders that know memories by their path, by their map,
by both and by raw parameters take the same lessons, with several seeds. They and the controls are
asked with the same memories, adapted in the same way. In the plane, more and more obstacles that do
not matter are added. The tables and the figure beside this file are of an earlier run.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
from autoencoder import AutoencoderIndex
from places import clusters_table
from teaching import Given, filed, trained

from gcm_learn import dataset, seeding
from gcm_learn.arms import PLANAR
from gcm_learn.evaluation import Case, Entrant, ask, page, pairs, shares
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
    Sizes,
    TransferLabels,
    Waypoints,
    nearest_rows,
    raw_features,
)
from gcm_learn.situation import Situation
from gcm_learn.wave import MarchingParams

HERE = Path(__file__).resolve().parent
WORLDS = ("plane", "space")
RECORDS = {"plane": 10_000, "space": 8_000}  # that are read
LESSONS = {"plane": Sizes(), "space": Sizes(256, 80)}  # a try costs more in space
SEEDS = (1, 2, 3)  # of lessons and of weights
TURNS, STEPS = 24, 20  # lessons of every encoder, steps of the optimiser after each
COUNT = 150  # situations of each stratum
EXTRAS = (0, 1, 2, 4, 8)  # obstacles that are added
DRAWS = 400  # of obstacles, before a situation counts as too crowded
FREE = 0.1  # clearance that they leave the limb on the known catch [forearm lengths]
CELLS = 40  # along a side of the maps that must not change
STRATA = ("W", "Q")
SPLITS = ("test", "validation")  # no lesson is about these
ADDED = ("map unchanged", "catch unchanged")
CHECKS = (1, 20)
PAIRS = (
    ("map", "raw neighbours"), ("raw, learned", "raw neighbours"), ("map", "raw, learned"),
    ("map", "path"), ("path and map", "path"),
)  # fmt: skip


def learned(labels: TransferLabels, maps: np.ndarray, seed: int) -> dict[str, Memory]:
    """Return the memories filed by encoders that know different things of them."""
    given: Given = {}
    raw = np.array([raw_features(s) for s in labels.situations])
    out = {}
    for name, kind, seen in (
        ("path", "trace", None),
        ("map", "map", maps),
        ("path and map", "both", maps),
        ("raw, learned", "map", Scale.of(raw)(raw)),
    ):
        config = EncoderConfig(
            memory=kind,  # type: ignore[arg-type]
            hard=0.0,
            steps=STEPS,
            seed=seed,
            arm=labels.spec.kind.name,
        )
        encoder = trained(labels, config, TURNS, seen, given)
        places = np.zeros((len(raw), encoder.dim), np.float32)
        if config.uses_traces:
            places += encoder._memory["trace"](labels.path_features)
        if seen is not None:
            places += encoder._memory["map"](seen)
        out[name] = filed(LearnedIndex(encoder), places, labels)
    return out


def controls(labels: TransferLabels) -> dict[str, Memory]:
    """Return the memories filed without learning; those by pictures of maps are of the plane."""
    raw = np.array([raw_features(s) for s in labels.situations])
    traces = [Waypoints(k, g) for k, g in zip(labels.knots, labels.goals, strict=True)]
    scale, lots = Scale.of(raw), RandomIndex()
    found = {
        "raw neighbours": filed(RawIndex(scale), nearest_rows(scale(raw)), labels),
        "random": filed(lots, lots.embed_memories(labels.situations, traces), labels),
    }
    if labels.spec.kind is PLANAR:
        pca = PcaIndex.fit(labels.situations[:3000])
        codes = AutoencoderIndex.fit(labels.situations[:3000])
        found["components of maps"] = filed(
            pca, pca.embed_memories(labels.situations, traces), labels
        )
        found["codes of maps"] = filed(
            codes, codes.embed_memories(labels.situations, traces), labels
        )
    return found


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


def crowds(records: dataset.Dataset, strict: bool) -> Iterator[Case]:
    """Yield planar situations of W and Q with ever more obstacles; the suite says how many."""
    for stratum in STRATA:
        rows: list[list[Case]] = []
        for record in records.where(split=SPLITS, stratum=stratum):
            plans = [p for p in record.plans.values() if p.caught]
            if not plans or record.situation.is_solid or len(rows) == COUNT:
                continue
            best = min(plans, key=lambda p: p.catch_time or 0.0)
            made = crowded(record.situation, best, record.index, strict)
            if len(made) == len(EXTRAS):
                suites = [f"{ADDED[not strict]}, +{extra}" for extra in EXTRAS]
                some = zip(made, suites, strict=True)
                rows.append([Case(one, suite, record.family, stratum) for one, suite in some])
        yield from (case for row in rows for case in row)


def as_drawn(records: dataset.Dataset) -> Iterator[Case]:
    """Yield situations of W and Q with nothing added, those in which a plan was found."""
    for stratum in STRATA:
        some = records.where(split=SPLITS, stratum=stratum)
        found = [r for r in some if any(plan.caught for plan in r.plans.values())][:COUNT]
        yield from (Case(r.situation, "as drawn", r.family, stratum) for r in found)


def entrants(world: str, records: dataset.Dataset) -> Iterator[Entrant]:
    """Yield every memory with each number of checks; write the table of clusters."""
    maps, tables = None, []
    for seed in SEEDS:
        some, sizes = records[: RECORDS[world]], LESSONS[world]
        labels = TransferLabels(some, seed, maps=maps is None, sizes=sizes)
        memories = {} if maps is not None else controls(labels)
        maps = labels.map_features if maps is None else maps
        assert maps is not None
        for checks in CHECKS:
            for name, memory in memories.items():
                yield Entrant(f"{name}, {checks}", RecallPlanner(memory, checks))
        taught = learned(labels, maps, seed)
        for checks in CHECKS:
            for name, memory in taught.items():
                yield Entrant(f"{name}, {checks}", RecallPlanner(memory, checks), seed)
        tables.append(clusters_table(some, labels, taught, maps, seed))
    (HERE / f"clusters-{world}.md").write_text("\n\n".join(tables) + "\n", "utf-8")


def main() -> None:
    """Train and ask; write what came of it."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    for world in WORLDS:
        parser.add_argument(world)
    given = vars(parser.parse_args())
    for world in WORLDS:
        records, out = dataset.open(given[world]), HERE / "out" / world
        both = (case for strict in (True, False) for case in crowds(records, strict))
        found = list(both if world == "plane" else as_drawn(records))
        sheet = ask(list(entrants(world, records)), found, keep=out)
        sheet.save(out / "sheet.parquet")
        asked = [(f"{a}, {n}", f"{b}, {n}") for n in CHECKS for a, b in PAIRS]
        told = [shares(sheet, ("entrant", "suite", "stratum")), pairs(sheet, asked, "suite")]
        (out / "table.md").write_text("\n\n".join(map(str, told)) + "\n", "utf-8")
        print(f"Open {page(sheet, out).as_uri()} in a browser.")


if __name__ == "__main__":
    main()
