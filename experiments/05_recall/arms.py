"""Does learned recall hold on arms outside those of its training? Writes arms.md.

python -m experiments 05_recall/arms [--count 300]

Situations are drawn as data/specs/space.toml says, with arms of its split `test-arms` and a seed of
their own; the same memories are asked by the trained encoder and by raw parameters.  What is asked
is kept in out/ and not asked again.  Every catch is judged by the referee.
"""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar, Self

import numpy as np

from gcm_learn.arms import SPATIAL
from gcm_learn.dataset import make_item, quantities_of, read_spec
from gcm_learn.evaluation import chance, complaints, difference, holm, mcnemar, wilson
from gcm_learn.recall import (
    MEMORIES,
    RandomIndex,
    RawIndex,
    RecallPlanner,
    Scale,
    nearest_rows,
    shipped_memory,
)
from gcm_learn.seeding import rng

HERE = Path(__file__).resolve().parent
REPOSITORY = HERE.parents[1]
MOVEMENTS = MEMORIES.of(SPATIAL)
SEED = 1616
SPLIT = "test-arms"
OF_ARM = slice(4, 20)
"""Of raw parameters: the arm's ranges, speeds, proportions, thickness and grasp."""
FIRST = (1, 20)  # memories that are tried


@dataclass(frozen=True)
class ScaledIndex:
    """Raw neighbours whose queries are scaled to the arm.

    Lengths are in reaches, as in every raw query, and what else the arm is is not asked for: an arm
    that no memory has would be far from all of them.
    """

    scale: Scale
    name: ClassVar[str] = "raw, scaled"
    key: ClassVar[str] = "scaled"

    @classmethod
    def fit(cls, situations: Sequence[Any]) -> Self:
        """Learn the scales of the parameters."""
        return cls(RawIndex.fit(situations).scale)

    @property
    def dim(self) -> int:
        """As of raw neighbours."""
        return len(self.scale.mean) + 1

    def _places(self, situations: Sequence[Any]) -> np.ndarray:
        places = self.scale(np.array([MOVEMENTS.raw_features(s) for s in situations]))
        places[:, OF_ARM] = 0.0
        return places

    def embed_query(self, situation: Any, scene: Any = None) -> np.ndarray:
        """Embedding of a situation."""
        return np.append(self._places([situation])[0], 1.0).astype(np.float32)

    def embed_memories(self, situations: Sequence[Any], trajectories: Sequence[Any]) -> np.ndarray:
        """Embeddings of memories."""
        return nearest_rows(self._places(situations))


def planners() -> dict[str, Any]:
    """Who is asked: the same memories, filed in four ways."""
    memory = shipped_memory("recall", SPATIAL)
    situations = memory.situations()
    scaled: Any = ScaledIndex.fit(situations)
    filed = {
        "learned": memory,
        "raw, scaled": memory.refiled(scaled),
        "raw": memory.refiled(RawIndex.fit(situations)),
        "random": memory.refiled(RandomIndex.fit(situations)),
    }
    return {
        f"{name}, {count}": RecallPlanner(kept, count, name, novelty=0.0 if count == 1 else 0.05)
        for name, kept in filed.items()
        for count in FIRST
    }


def drawn(spec: Any) -> Iterator[Any]:
    """Records of arms outside those of the training, W and Q."""
    for k in range(10**6):
        source = rng(spec.seed, k, 0)
        situation = spec.choose(source).draw(source, "probe")
        if outside(spec, situation):
            record = make_item(spec, k)
            if record.split == SPLIT and record.stratum in "WQ":
                yield record


def outside(spec: Any, situation: Any) -> bool:
    """Whether an arm is outside those of the training."""
    told = quantities_of(situation, 0.0)
    ranges = [hold for hold in spec.holdouts if hold.split == SPLIT]
    return any(hold.holds("", told) for hold in ranges)


def answered(asked: dict[str, Any], record: Any) -> dict[str, Any]:
    """What all say of a situation."""
    row: dict[str, Any] = {name: getattr(record, name) for name in ("index", "family", "stratum")}
    row["upper_arm"] = record.quantities["upper_arm"]
    for name, planner in asked.items():
        since = time.process_time()
        plan = planner.plan(record.situation)
        ms = 1e3 * (time.process_time() - since)
        found = complaints(record.situation, plan) if plan.caught else []
        row[name] = {"caught": plan.caught, "ms": round(ms, 3), "complaints": found}
    return row


def report(rows: list[dict[str, Any]], names: Sequence[str]) -> str:
    """Catches by stratum, and pairs with Holm's correction."""
    hits = {name: np.array([row[name]["caught"] for row in rows]) for name in names}
    stratum = np.array([row["stratum"] for row in rows])
    masks = {"W": stratum == "W", "Q": stratum == "Q", "W and Q": stratum != ""}
    counts = " | ".join(str(m.sum()) for m in masks.values())
    lines = ["| asked, memories tried | " + " | ".join(masks) + " | complaints | ms |",
             "|---" * (len(masks) + 3) + "|", f"| situations | {counts} | | |"]  # fmt: skip
    for name, mine in hits.items():
        told = [wilson(int(mine[m].sum()), int(m.sum())) for m in masks.values()]
        cells = ["{:.0f} ({:.0f}–{:.0f})".format(*(100 * x for x in one)) for one in told]
        wrong = sum(bool(row[name]["complaints"]) for row in rows)
        ms = np.median([row[name]["ms"] for row in rows])
        lines.append(
            f"| {name} | " + " | ".join(cells) + f" | {wrong} of {mine.sum()} | {ms:.1f} |"
        )
    family = np.array([row["family"] for row in rows])
    pairs = []
    for count in FIRST:
        for other in ("raw, scaled", "raw", "random"):
            one, two = hits[f"learned, {count}"], hits[f"{other}, {count}"]
            pairs.append((f"learned less {other}, {count}", difference(one, two, family),
                          mcnemar(one, two)))  # fmt: skip
    lines += [
        "",
        "| pair | points | only learned / only other | p after Holm |",
        "|---|---|---|---|",
    ]
    for (name, more, test), p in zip(pairs, holm([test[2] for *_, test in pairs]), strict=True):
        value = "{:+.0f} ({:+.0f} to {:+.0f})".format(*(100 * x for x in more))
        lines.append(f"| {name} | {value} | {test[0]} / {test[1]} | {chance(p)} |")
    return "\n".join(lines)


def main() -> None:
    """Ask what was not asked yet; write arms.md."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=300, help="situations")
    parser.add_argument("--seed", type=int, default=SEED)
    given = parser.parse_args()
    spec = read_spec(REPOSITORY / "data" / "specs" / "space.toml")
    spec = replace(spec, seed=given.seed, count=10**6, audit=0.0)
    kept = HERE / "out" / f"arms-{given.seed}.jsonl"
    kept.parent.mkdir(exist_ok=True)
    lines = kept.read_text("utf-8").splitlines() if kept.exists() else []
    rows, asked = [json.loads(line) for line in lines], planners()
    known = {row["index"] for row in rows}
    with kept.open("a", encoding="utf-8") as file:
        for record in drawn(spec):
            if len(rows) >= given.count:
                break
            if record.index not in known:
                rows.append(answered(asked, record))
                file.write(json.dumps(rows[-1]) + "\n")
                file.flush()
    arms = len({round(row["upper_arm"], 6) for row in rows})
    note = (
        f"{len(rows)} situations of W and Q, seed {given.seed}, {arms} arms whose upper arm is "
        "under 0.8 or over 1.15 forearms. Catches [%] with 95 % intervals (Wilson), what the "
        "referee complains of, and processor time [ms], median; pairs by McNemar's exact test."
    )
    (HERE / "arms.md").write_text(f"{report(rows, list(asked))}\n\n{note}\n", "utf-8")


if __name__ == "__main__":
    main()
