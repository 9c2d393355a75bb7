"""Find kinds of catches in space, and compare them with the plane's; write space.md.

python -m experiments 07_clusters/space SPACE PLANE

Both are folders of `gcm-learn generate`, of data/specs/space.toml and recall.toml.  Pictures are
space.png and kinds.gif.  Answers of planners are kept in out/ and reused.
"""

from __future__ import annotations

import argparse
import json
from collections import Counter
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from kinds import FEATURES, Kinds, features_of, lifted
from sklearn.cluster import HDBSCAN
from sklearn.metrics import adjusted_mutual_info_score, adjusted_rand_score
from space_pictures import write_figure, write_films

from experiments.clusters import (
    TRIED,
    Experience,
    Tries,
    directions,
    k_means,
    shared,
    shares,
    stability as k_means_stability,
    transfers,
    tries,
)
from gcm_learn import dataset, seeding
from gcm_learn.arms import SPATIAL
from gcm_learn.evaluation import Table
from gcm_learn.planners import search_in_space
from gcm_learn.recall import (
    MEMORIES,
    LearnedIndex,
    Scale,
    shipped_memory,
    waypoints_of,
)

HERE = Path(__file__).resolve().parent
MOVEMENTS = MEMORIES.of(SPATIAL)
MANY = (4, 6, 8)  # kinds that are tried
REPEATS = 4  # bootstrap samples whose clusterings are compared
LEAST = 60  # members of a cluster of HDBSCAN
LIFTED = 1000  # situations of the plane that are put into space
EFFORT = 0.5  # of the search, as in the records
STARTS = 3  # of k-means where many are asked for
SHUFFLES = 4
ASKED = 400  # situations that need more than a straight line, on which memories are tried
PLACED = 3000  # of the catches in space, that are placed by encoder, joints and parameters
WORLDS = {"plane": "the plane", "space": "space"}


class Catches(NamedTuple):
    """The earliest catches of training records, as they come."""

    records: list[dataset.Record]
    plans: list[Any]
    features: np.ndarray
    family: np.ndarray
    stratum: np.ndarray


def catches(folder: str, most: int) -> Catches:
    """Return the catches of a dataset of either kind of arm."""
    records, plans = [], []
    for record in dataset.open(folder).where(split="train"):
        found = [plan for plan in record.plans.values() if plan.caught]
        if found:
            records.append(record)
            plans.append(min(found, key=lambda plan: plan.catch_time))
        if len(records) == most:
            break
    rows = [features_of(r.situation, p.trajectory) for r, p in zip(records, plans, strict=True)]
    family, stratum = ([getattr(r, name) for r in records] for name in ("family", "stratum"))
    return Catches(records, plans, np.array(rows), np.array(family), np.array(stratum))


def experience(some: Catches, kinds: np.ndarray) -> Experience:
    """Return the labels and features that clusters in space are compared with."""
    memories = [waypoints_of(r.situation, p) for r, p in zip(some.records, some.plans, strict=True)]
    arms = [r.situation.arm for r in some.records]
    start = np.array([[*a.joints, np.hypot(*a.upper_arm[:2]) / a.reach] for a in arms])
    last = np.array([m.knots[-1, :5] for m in memories])
    product = [last[:, i] * last[:, j] for i in range(5) for j in range(i + 1)]
    return Experience(
        some.records,
        np.array([m.knots for m in memories], np.float32),
        np.array([m.goal for m in memories], np.float32),
        {"family": some.family, "stratum": some.stratum, "kind": kinds},
        start,
        np.column_stack([last, *product, start]),
    )


def spaces(some: Experience) -> dict[str, np.ndarray]:
    """Return the places of the catches (n, d), by the features they are placed by."""
    index: Any = shipped_memory("recall", SPATIAL).index
    assert isinstance(index, LearnedIndex)
    situations = [record.situation for record in some.records]
    queries = np.array([index.embed_query(s) for s in situations])
    memories = index.encoder.embed_memories(situations, some.traces, some.goals)
    joints = MOVEMENTS.path_features(some.traces, some.goals)
    raw = np.array([MOVEMENTS.raw_features(s) for s in situations])
    return {
        "memories": directions(memories),
        "situations": directions(queries),
        "joints": Scale.of(joints)(joints),
        "raw": Scale.of(raw)(raw),
    }


def clusters_table(some: Experience, found: Tries, places: dict[str, np.ndarray]) -> str:
    """Return what clusters of places agree with, and where catches transfer."""
    head = ["space", *(f"AMI {name}" for name in some.labels), "stable: Rand",
            "transfers within", "across", "ratio"]  # fmt: skip
    lines = []
    groups = {name: k_means(rows, 0).labels_.astype(int) for name, rows in places.items()}
    for name, rows in places.items():
        cells = [f"{adjusted_mutual_info_score(v, groups[name]):.2f}" for v in some.labels.values()]
        rand = f"{k_means_stability(rows, REPEATS)[0]:.2f}"
        lines.append([name, *cells, rand, *shares(transfers(found, groups[name]))])
        print(" | ".join(lines[-1]), flush=True)
    return str(Table(head, lines)) + "\n\n" + shared("catches", some, found)


def stability(rows: np.ndarray, count: int) -> float:
    """Mean adjusted Rand index of kinds that are found in bootstrap samples."""
    fits = []
    for k in range(REPEATS):
        sample = seeding.rng(8, k).integers(len(rows), size=len(rows))
        fits.append(Kinds.of(rows[sample], count, k, STARTS)(rows))
    return float(np.mean([adjusted_rand_score(a, b) for k, a in enumerate(fits) for b in fits[:k]]))


def carried_over(plane: Catches, space: Catches, count: int) -> tuple[float, float]:
    """Rand index of space's kinds with the plane's; the same for a plane of shuffled features.

    Each world has its own scale, and a movement in space is of the kind whose centre in the plane
    is the nearest.
    """
    own = Kinds.of(space.features, count)
    mine, places = own(space.features), own.scaled(space.features)
    there = adjusted_rand_score(mine, Kinds.of(plane.features, count).fit.predict(places))
    chance = []
    for k in range(SHUFFLES):
        rng = seeding.rng(12, k)
        mixed = np.column_stack([rng.permutation(column) for column in plane.features.T])
        chance.append(
            adjusted_rand_score(mine, Kinds.of(mixed, count, k, STARTS).fit.predict(places))
        )
    return float(there), float(np.mean(chance))


def in_space(plane: Catches) -> list[dict[str, Any]]:
    """Situations of the plane among solids, W and Q, put into space: held in the plane, and free.

    Answers are kept.
    """
    file = HERE / "out" / "lifted.jsonl"
    file.parent.mkdir(exist_ok=True)
    lines = file.read_text("utf-8").splitlines() if file.exists() else []
    rows = [json.loads(line) for line in lines]
    solid = [k for k, name in enumerate(plane.family.tolist()) if name.endswith("-solid")]
    hard = [k for k in solid if plane.stratum[k] in "WQ"][:LIFTED]
    planner = search_in_space(effort=EFFORT)
    with file.open("a", encoding="utf-8") as stream:
        for k in hard[len(rows) :]:
            record = plane.records[k]
            row: dict[str, Any] = {"index": record.index, "place": k}
            for name, held in (("held", True), ("free", False)):
                situation = lifted(record.situation, held=held)
                plan = planner.plan(situation)
                row[name] = None
                if plan.trajectory is not None and plan.caught:
                    row[name] = features_of(situation, plan.trajectory).tolist()
            rows.append(row)
            stream.write(json.dumps(row) + "\n")
            stream.flush()
    return rows


def kinds_table(worlds: dict[str, Catches], names: dict[str, np.ndarray]) -> str:
    """Return what the kinds are, in both worlds."""
    head = ["kind", "world", "share", "L / W / Q", "most of its families", *FEATURES]
    lines = []
    for kind in ordered(names["space"]):
        for world, some in worlds.items():
            mine = names[world] == kind
            if not mine.any():
                continue
            strata = Counter(some.stratum[mine].tolist())
            each = " / ".join(f"{100 * strata[s] / mine.sum():.0f}" for s in "LWQ")
            common = Counter(some.family[mine].tolist()).most_common(2)
            families = ", ".join(f"{f} {100 * n / mine.sum():.0f} %" for f, n in common)
            middle = np.median(some.features[mine], axis=0)
            which = [kind, world, f"{100 * mine.mean():.0f} %", each, families]
            lines.append([*which, *(f"{value:.2f}" for value in middle)])
    return str(Table(head, lines))


def ordered(names: np.ndarray) -> list[str]:
    """The kinds, those that go straight first and those that wait last."""
    return sorted(
        set(names.tolist()),
        key=lambda name: ("wait" in name, "round" in name, "far" in name, name),
    )


def stability_table(plane: Catches, space: Catches) -> str:
    """Return how stable so many kinds are, and how well kinds of the plane fit space."""
    head = ["kinds", "stable: plane", "stable: space", "plane's kinds in space", "if shuffled"]
    lines = []
    for count in MANY:
        two = [stability(some.features, count) for some in (plane, space)]
        cells = [*two, *carried_over(plane, space, count)]
        lines.append([count, *(f"{cell:.2f}" for cell in cells)])
        print(" | ".join(lines[-1]), flush=True)
    dense = {}
    for name, some in (("plane", plane), ("space", space)):
        scaled = Kinds.of(some.features).scaled(some.features)
        found = HDBSCAN(min_cluster_size=LEAST, min_samples=5, copy=True).fit_predict(scaled)
        dense[name] = (
            f"{found.max() + 1} in {WORLDS[name]} ({100 * (found < 0).mean():.0f} % left out)"
        )
    return f"{Table(head, lines)}\n\nHDBSCAN finds {' and '.join(dense.values())}."


def lifted_table(
    plane: Catches, rows: list[dict[str, Any]], kinds: Kinds, call: dict[int, str]
) -> tuple[str, np.ndarray, list[str]]:
    """Return kinds in the plane beside kinds of the same situations in space, also as shares."""
    there = [row for row in rows if row["free"] is not None]
    words = np.array([call[k] for k in range(len(call))])
    before = words[kinds(plane.features[[row["place"] for row in there]])]
    after = words[kinds(np.array([row["free"] for row in there]))]
    names = ordered(words)
    moved = np.array([[np.mean(after[before == a] == b) for b in names] for a in names])
    lines = [
        [name, (before == name).sum(), *(f"{100 * share:.0f}" for share in row)]
        for name, row in zip(names, moved, strict=True)
    ]
    first = str(Table(["in the plane", "situations", *names], lines))
    held = [row for row in rows if row["held"] is not None]
    head = ("the same arm", "catches", "same kind", "if independent", "AMI", "waits stay waits")
    lines = []
    for how, mine in (("held", held), ("free", there)):
        one = words[kinds(plane.features[[row["place"] for row in mine]])]
        other = words[kinds(np.array([row[how] for row in mine]))]
        chance = sum(np.mean(one == name) * np.mean(other == name) for name in names)
        waits = np.array([name.startswith("wait") for name in one])
        still = np.array([name.startswith("wait") for name in other])
        agreed = [f"{100 * np.mean(one == other):.0f} %", f"{100 * chance:.0f} %"]
        mutual = f"{adjusted_mutual_info_score(one, other):.2f}"
        waited = f"{100 * np.mean(still[waits]):.0f} % of {waits.sum()}"
        lines.append([how, f"{len(mine)} of {len(rows)}", *agreed, mutual, waited])
    return f"{first}\n\n{Table(head, lines)}", moved, names


def main() -> None:
    """Find kinds, compare, write."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("space")
    parser.add_argument("plane")
    parser.add_argument("--memories", type=int, default=5000)
    given = parser.parse_args()
    space, plane = (catches(folder, given.memories) for folder in (given.space, given.plane))
    found = {"plane": Kinds.of(plane.features), "space": Kinds.of(space.features)}
    names, call = {}, {}
    for world, some in (("plane", plane), ("space", space)):
        call[world] = found[world].named(some.features)
        names[world] = np.array([call[world][k] for k in found[world](some.features)])
    rows = in_space(plane)
    lifts, moved, order = lifted_table(plane, rows, found["plane"], call["plane"])
    worlds = {"plane": plane, "space": space}
    parts = [kinds_table(worlds, names), stability_table(plane, space), lifts]
    write_figure(HERE / "space.png", worlds, found, names, moved, order)
    write_films(HERE / "kinds.gif", space, found["space"], names["space"], order)
    few = Catches(*(part[:PLACED] for part in space))
    some = experience(few, names["space"][:PLACED])
    tried = tries(some, ASKED)
    parts.append(clusters_table(some, tried, spaces(some)))
    note = (
        f"{len(space.records)} catches in space and {len(plane.records)} in the plane, of which "
        f"{len(few.records)} in space are placed. Features are medians; strata and families in "
        f"percent of the kind. Transfer: {len(tried.asked)} situations of W and Q in space, "
        f"{TRIED} random memories each, bent and checked. AMI: adjusted mutual information, 0 is "
        "chance."
    )
    (HERE / "space.md").write_text("\n\n".join([*parts, note]) + "\n", "utf-8")


if __name__ == "__main__":
    main()
