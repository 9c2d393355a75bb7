"""Do memories of static situations catch in dynamic ones? Writes table.md and figure.png.

python -m experiments 09_static_twins DATASET [ENCODER]

DATASET is a folder of `gcm-learn generate`, ENCODER one of `gcm-learn train-encoder` (the shipped
one by default).
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from report import write_example, write_figure, write_table

from gcm_learn import dataset, seeding
from gcm_learn.arms.planar_limb import SIDE, elbow_of
from gcm_learn.collision.distance import arm_distance
from gcm_learn.dataset import Record, planner_of
from gcm_learn.plots import birth
from gcm_learn.recall import (
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
from gcm_learn.scene.bodies import HAND, PART, TOP_SPEED, pose_at
from gcm_learn.scene.packing import pack_bodies
from gcm_learn.situation import Body, PlanarQuadratic, Situation

HERE = Path(__file__).resolve().parent
STRATA = ("L", "W", "Q")
POSES = {"twins, one pose": 1, "twins, five poses": 5}
CLEAR = 1e-3  # what stands nearer to the limb at t = 0 is no obstacle of it [forearm lengths]
Catch = tuple[Situation, Waypoints]


class Twin(NamedTuple):
    """A static situation in place of a dynamic one."""

    situation: Situation
    agreement: tuple[float, float]
    """Share of the effective obstacles that the twin's front does not enter, either; share of the
    cells that were reached that its front reaches, too."""
    trace: Waypoints | None
    """The catch by first arrival, or None."""


def moving(situation: Situation) -> bool:
    """Return whether an obstacle of a planar situation moves."""
    if situation.is_solid:
        return False
    rows = pack_bodies(situation).rows
    return bool(np.any(rows[rows[:, PART] != HAND, TOP_SPEED] > 0.1))


def best_plan(record: Record) -> Any:
    """The earliest catch."""
    plans = [plan for plan in record.plans.values() if plan.caught]
    return min(plans, key=lambda plan: plan.catch_time or 0.0) if plans else None


def met(record: Record) -> dict[int, np.ndarray]:
    """When the front met each obstacle: times of the effective cells that are its own."""
    made, arm, bodies = record.map, record.situation.arm, pack_bodies(record.situation)
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
    """A body as it is at time t, for good."""
    poses = np.zeros((len(bodies.rows), 12))
    poses[:, [3, 7, 11]] = 1.0
    pose_at(bodies, b, t, poses)
    turn = float(np.arctan2(poses[b, 6], poses[b, 3]))
    place = (float(poses[b, 0]), float(poses[b, 1]))
    return replace(body, name=name, motion=PlanarQuadratic(place, (0.0, 0.0), (0.0, 0.0), turn))


def twin_of(record: Record, poses: int) -> Situation:
    """Every obstacle stands where the front met it, the target where it was caught.

    With several poses an obstacle stands wherever it was met at as many shares of its effective
    cells, in order of time. Cells that the front never met are left out.
    """
    situation, plan = record.situation, best_plan(record)
    bodies, arm, out = pack_bodies(situation), situation.arm, []
    elbow = elbow_of(*arm.hand, arm.upper_arm, SIDE[arm.elbow])
    for b, body in enumerate(situation.bodies):
        if body.name == plan.catch_body:
            out.append(still(body, bodies, b, plan.catch_time, body.name))
    for b, times in met(record).items():
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


def twin(record: Record, poses: int, n: int) -> Twin:
    """A record's twin, how its map agrees, and its catch."""
    situation = twin_of(record, poses)
    plan = planner_of("marching", n, 1).plan(situation)
    trace = waypoints_of(situation, plan) if plan.caught else None
    here, there = record.map, plan.map
    if there is None or there.arrival.count() == 0:
        return Twin(situation, (np.nan, np.nan), trace)
    entered = ~np.ma.getmaskarray(there.arrival)
    walls = here.effective_obstacles
    reached = ~np.ma.getmaskarray(here.arrival)
    # Fronts stop at contact: only what both had the time to reach is compared.
    soon = reached & (here.arrival.filled(np.inf) < 0.95 * float(there.arrival.max()))
    blocked = 1.0 - entered[walls].mean() if walls.any() else np.nan
    kept = entered[soon].mean() if soon.any() else np.nan
    return Twin(situation, (float(blocked), float(kept)), trace)


def moved(records: dataset.Dataset) -> Iterator[Record]:
    """Planar records with a catch and an obstacle that moves."""
    for record in records:
        if moving(record.situation) and best_plan(record) is not None:
            yield record


class Banks(NamedTuple):
    """Memories of equal size by where they come from, and what is known of the twins."""

    catches: dict[str, list[Catch]]
    lines: list[dict[str, Any]]
    example: tuple[Record, dict[str, Twin]]


def banks(records: dataset.Dataset, size: int) -> Banks:
    """Twins that can be caught of dynamic situations, these themselves, others, and static ones."""
    train = records.where(split="train")
    out: dict[str, list[Catch]] = {name: [] for name in ("dynamic", "dynamic, those of the twins")}
    out |= {name: [] for name in POSES}
    lines, example = [], None
    for record in moved(train):
        catch = (record.situation, waypoints_of(record.situation, best_plan(record)))
        if len(out["dynamic"]) < size:
            out["dynamic"].append(catch)
        twins = {name: twin(record, poses, record.n) for name, poses in POSES.items()}
        for name, found in twins.items():
            lines.append({"stratum": record.stratum, "twin": name, "caught": bool(found.trace),
                          "agreement": found.agreement})  # fmt: skip
        if all(found.trace for found in twins.values()):
            shut = [found.agreement[0] for found in twins.values()]
            if example is None and record.stratum == "W" and shut[0] < 0.75 and shut[1] > 0.95:
                example = (record, twins)
            out["dynamic, those of the twins"].append(catch)
            for name, found in twins.items():
                out[name].append((found.situation, found.trace))
        if len(out["dynamic, those of the twins"]) == size:
            break
    calm = train.where(family="static-clutter")
    still_ones = [(r.situation, waypoints_of(r.situation, best_plan(r)))
                  for r in calm[: 3 * size] if best_plan(r) is not None]  # fmt: skip
    out["static as drawn"] = still_ones[:size]
    assert example is not None
    return Banks(out, lines, example)


def questions(records: dataset.Dataset, count: int) -> list[tuple[str, str, Situation]]:
    """Stratum, family and situation of dynamic test records."""
    out = []
    for stratum in STRATA:
        some = records.where(split="test", stratum=stratum)
        found = (r for r in moved(some))
        out += [(stratum, r.family, r.situation) for r, _ in zip(found, range(count), strict=False)]
    return out


def answers(
    banks: dict[str, list[Catch]], indexes: Sequence[Index], asked: list
) -> Iterator[dict[str, Any]]:
    """Return the catches of every question by every memory, found by every index."""
    for name, catches in banks.items():
        for index in indexes:
            memory = Memory(index, "exact")
            memory.add([s for s, _ in catches], [t for _, t in catches])
            planner = RecallPlanner(memory)
            for case, (stratum, family, situation) in enumerate(asked):
                found = planner.recollect(situation)
                yield {"bank": name, "index": index.name, "size": len(catches), "case": case,
                       "stratum": stratum, "family": family, "caught": found.plan.caught,
                       "checks": found.checked}  # fmt: skip
            print(name, index.name, len(catches), flush=True)


def main() -> None:
    """Make twins, ask, write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("dataset")
    parser.add_argument("encoder", nargs="?", default=str(HERE.parents[1] / "models" / "encoder"))
    parser.add_argument("--memories", type=int, default=2000)
    parser.add_argument("--situations", type=int, default=300, help="of each stratum")
    given = parser.parse_args()
    records, encoder = dataset.open(given.dataset), load_encoder(given.encoder)
    made = banks(records, given.memories)
    size = min(len(catches) for catches in made.catches.values())
    lots = seeding.rng(9).permutation(size)
    catches = {name: [c[k] for k in lots] for name, c in made.catches.items()}
    print({name: len(c) for name, c in made.catches.items()}, flush=True)
    scale = RawIndex.fit([s for s, _ in catches["dynamic"]])
    asked = questions(records, given.situations)
    lines = list(answers(catches, [LearnedIndex(encoder), scale, RandomIndex()], asked))
    (HERE / "out").mkdir(exist_ok=True)
    (HERE / "out" / "answers.json").write_text(json.dumps(lines))
    write_table(HERE / "table.md", lines, made.lines, encoder.key)
    write_figure(HERE / "figure.png", lines)
    write_example(HERE / "twins.png", *made.example)


if __name__ == "__main__":
    main()
