"""Do memories of static situations catch in dynamic ones? Writes outcomes, table and figures.

python -m experiments 09_static_twins DATASET [ENCODER]

DATASET is a folder of `gcm-learn generate`, ENCODER one of `gcm-learn train-encoder` (the shipped
one by default).
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import replace
from itertools import count, islice
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from report import INDEXES, write_example, write_figure

from experiments import recompute
from experiments.common import outcomes
from experiments.common.questions import Question
from gcm_learn import dataset, seeding
from gcm_learn.arms.planar_limb import SIDE, elbow_of
from gcm_learn.collision.distance import arm_distance
from gcm_learn.dataset import DatasetSpec, Record, make_item, planner_of
from gcm_learn.maps import CognitiveMap, build_map
from gcm_learn.plots import birth
from gcm_learn.recall import (
    Adaptation,
    Index,
    LearnedIndex,
    Memory,
    RandomIndex,
    RawIndex,
    RecallPlanner,
    Waypoints,
    load_encoder,
    waypoints_of,
)
from gcm_learn.recall.adaptation import DEFAULT
from gcm_learn.scene.bodies import HAND, PART, TOP_SPEED, pose_at
from gcm_learn.scene.packing import pack_bodies
from gcm_learn.situation import Body, PlanarQuadratic, Situation
from gcm_learn.wave import MarchingParams

HERE = Path(__file__).resolve().parent
STRATA = ("L", "W", "Q")
SPLITS = ("test", "validation")  # no memory is of these
SIZE, COUNT = 2000, 300  # memories of each kind, situations of each stratum at most
POSES = {"twins, one pose": 1, "twins, five poses": 5}
CLEAR = 1e-3  # what stands nearer to the limb at t = 0 is no obstacle of it [forearm lengths]
Catch = tuple[Situation, Waypoints]


class Twin(NamedTuple):
    """A static situation in place of a dynamic one."""

    situation: Situation
    shut: float
    """Share of the effective obstacles that the twin's front does not enter, either."""
    open: float
    """Share of the cells that were reached that its front reaches, too."""
    trace: Waypoints | None
    """The catch by first arrival, or None."""


def moving(situation: Situation) -> bool:
    """Return whether an obstacle of a planar situation moves."""
    if situation.is_solid:
        return False
    rows = pack_bodies(situation).rows
    return bool(np.any(rows[rows[:, PART] != HAND, TOP_SPEED] > 0.1))


def best_plan(record: Record) -> Any:
    """Return the earliest catch."""
    plans = [plan for plan in record.plans.values() if plan.caught]
    return min(plans, key=lambda plan: plan.catch_time or 0.0) if plans else None


def met(situation: Situation, made: CognitiveMap) -> dict[int, np.ndarray]:
    """Return times at which the front met each obstacle, one for each of its effective cells."""
    arm, bodies = situation.arm, pack_bodies(situation)
    when = birth(made) * made.kappa
    obstacles = np.flatnonzero(bodies.rows[:, PART] != HAND)
    poses, times = np.zeros((len(bodies.rows), 12)), {int(b): [] for b in obstacles}
    for iy, ix in np.argwhere(made.effective_obstacles & np.isfinite(when)):
        x, y = made.lattice.centres[ix], made.lattice.centres[iy]
        near, far = 1.0001 * arm.inner_reach, 0.9999 * arm.reach
        r = np.hypot(x, y)
        x, y = (v * np.clip(r, near, far) / max(r, 1e-9) for v in (x, y))
        ex, ey = elbow_of(x, y, arm.upper_arm, SIDE[arm.elbow])
        gaps = []
        for b in obstacles:
            pose_at(bodies, b, when[iy, ix], poses)
            gaps.append(arm_distance(bodies, poses, b, x, y, ex, ey))
        times[int(obstacles[int(np.argmin(gaps))])].append(float(when[iy, ix]))
    return {b: np.array(t) for b, t in times.items() if t}


def still(body: Body, bodies: Any, b: int, t: float, name: str) -> Body:
    """Return a body as it is at time t, for good."""
    poses = np.zeros((len(bodies.rows), 12))
    poses[:, [3, 7, 11]] = 1.0
    pose_at(bodies, b, t, poses)
    turn = float(np.arctan2(poses[b, 6], poses[b, 3]))
    place = (float(poses[b, 0]), float(poses[b, 1]))
    return replace(body, name=name, motion=PlanarQuadratic(place, (0.0, 0.0), (0.0, 0.0), turn))


def twin_of(record: Record, made: CognitiveMap, poses: int) -> Situation:
    """Put every obstacle where the front met it, the target where it was caught.

    With several poses an obstacle stands wherever it was met at as many shares of its effective
    cells, in order of time. Cells that the front never met are left out.
    """
    situation, plan = record.situation, best_plan(record)
    bodies, arm, out = pack_bodies(situation), situation.arm, []
    elbow = elbow_of(*arm.hand, arm.upper_arm, SIDE[arm.elbow])
    for b, body in enumerate(situation.bodies):
        if body.name == plan.catch_body:
            out.append(still(body, bodies, b, plan.catch_time, body.name))
    for b, times in met(situation, made).items():
        shares = [0.5] if poses == 1 else np.linspace(0.0, 1.0, poses)
        moves = bodies.rows[b, TOP_SPEED] > 0.0
        for k, t in enumerate(np.quantile(times, shares if moves else [0.5])):
            copy = still(
                situation.bodies[b], bodies, b, float(t), f"{situation.bodies[b].name} {k}"
            )
            alone = pack_bodies(replace(situation, bodies=(*out[:1], copy)))
            pose = np.zeros((2, 12))
            pose[:, [3, 7, 11]] = 1.0
            pose_at(alone, 1, 0.0, pose)
            if arm_distance(alone, pose, 1, *arm.hand, *elbow) > arm.thickness + CLEAR:
                out.append(copy)
    return replace(situation, name=f"twin of {situation.name}", bodies=tuple(out))


def twin(record: Record, here: CognitiveMap, poses: int) -> Twin:
    """Return a record's twin, how the maps agree, and its catch."""
    situation = twin_of(record, here, poses)
    plan = planner_of("marching", record.n, 1).plan(situation)
    trace = waypoints_of(situation, plan) if plan.caught else None
    there = plan.map
    if there is None or there.arrival.count() == 0:
        return Twin(situation, np.nan, np.nan, trace)
    entered = ~np.ma.getmaskarray(there.arrival)
    walls = here.effective_obstacles
    reached = ~np.ma.getmaskarray(here.arrival)
    # Fronts stop at contact: only what both had the time to reach is compared.
    soon = reached & (here.arrival.filled(np.inf) < 0.95 * float(there.arrival.max()))
    blocked = 1.0 - entered[walls].mean() if walls.any() else np.nan
    kept = entered[soon].mean() if soon.any() else np.nan
    return Twin(situation, float(blocked), float(kept), trace)


def moved(records: dataset.Dataset) -> Iterator[Record]:
    """Yield planar records with a catch and an obstacle that moves."""
    for record in records:
        if moving(record.situation) and best_plan(record) is not None:
            yield record


class Banks(NamedTuple):
    """Memories of equal size by where they come from, and outcomes of the twins."""

    catches: dict[str, list[Catch]]
    rows: list[dict[str, Any]]
    example: tuple[Record, CognitiveMap, dict[str, Twin]]


def banks(records: dataset.Dataset) -> Banks:
    """Return twins that can be caught, their dynamic situations, others, and static ones."""
    train = records.where(split="train")
    every, paired = [], []
    twins: dict[str, list[Catch]] = {name: [] for name in POSES}
    rows, example = [], None
    for record in moved(train):
        every.append((record.situation, waypoints_of(record.situation, best_plan(record))))
        made = build_map(record.situation, MarchingParams(n=record.n))
        found = {name: twin(record, made, poses) for name, poses in POSES.items()}
        about = Question(record.stratum, record.family, record.index, record.situation).about()
        for name, one in found.items():
            kept = {"shut": round(one.shut, 3), "open": round(one.open, 3)}
            rows.append(about | {"method": name, "caught": one.trace is not None} | kept)
        if not all(one.trace for one in found.values()):
            continue
        once, often = (one.shut for one in found.values())
        if example is None and record.stratum == "W" and once < 0.75 and often > 0.95:
            example = (record, made, found)
        paired.append(every[-1])
        for name, one in found.items():
            twins[name].append((one.situation, one.trace))
        if len(paired) == SIZE:
            break
    assert example is not None
    own = {"dynamic": every[:SIZE], "dynamic, those of the twins": paired}
    calm = list(islice(static(records.spec), SIZE))
    return Banks(own | twins | {"static as drawn": calm}, rows, example)


def static(spec: DatasetSpec) -> Iterator[Catch]:
    """Yield catches of further static situations by the dataset's specification."""
    some = tuple(one for one in spec.families if one.family == "static-clutter")
    spec = replace(spec, families=some, count=10**6, audit=0.0)
    for k in count(spec.count):
        record = make_item(spec, k)
        plan = best_plan(record) if record.split == "train" else None
        if plan is not None:
            yield record.situation, waypoints_of(record.situation, plan)


def questions(records: dataset.Dataset) -> list[Question]:
    """Return dynamic situations that no memory is of."""
    out = []
    for stratum in STRATA:
        some = islice(moved(records.where(split=SPLITS, stratum=stratum)), COUNT)
        out += [Question(stratum, r.family, r.index, r.situation) for r in some]
    return out


def answers(
    banks: dict[str, list[Catch]], indexes: dict[str, Index], asked: list[Question]
) -> Iterator[dict[str, Any]]:
    """Yield the outcomes of every question by every memory, found by every index."""
    for name, catches in banks.items():
        for index_name, index in indexes.items():
            memory = Memory(index, "exact")
            memory.add([s for s, _ in catches], [t for _, t in catches])
            bends = 0 if index_name.endswith("unchanged") else DEFAULT.bends
            planner = RecallPlanner(memory, how=Adaptation(bends=bends))
            for question in asked:
                found = planner.recollect(question.situation)
                row = question.about() | {"method": name, "index": index_name}
                yield row | {"caught": found.plan.caught, "checks": found.checked}
            print(name, index_name, len(catches), flush=True)


def main() -> None:
    """Make twins, ask, write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("dataset")
    parser.add_argument("encoder", nargs="?", default=str(HERE.parents[1] / "models" / "encoder"))
    given = parser.parse_args()
    records, encoder = dataset.open(given.dataset), load_encoder(given.encoder)
    made = banks(records)
    lots = seeding.rng(9).permutation(min(map(len, made.catches.values())))
    catches = {name: [c[k] for k in lots] for name, c in made.catches.items()}
    scale = RawIndex.fit([s for s, _ in catches["dynamic"]])
    indexes = dict(zip(INDEXES, (LearnedIndex(encoder), scale, RandomIndex()), strict=False))
    indexes["learned, unchanged"] = indexes["learned"]
    outcomes.write(HERE / "outcomes-twins.csv.gz", made.rows)
    outcomes.write(HERE / "outcomes.csv.gz", answers(catches, indexes, questions(records)))
    recompute.update(HERE)
    write_figure(HERE / "figure.png", outcomes.read(HERE / "outcomes.csv.gz"))
    write_example(HERE / "twins.png", *made.example)


if __name__ == "__main__":
    main()
