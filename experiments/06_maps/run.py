"""Do maps find memories better than raw parameters do, the more so the more there is around?

python experiments/06_maps/run.py DATASET

Writes table.md and figure.png. Encoders that know memories by their way, by their map and by both
take the same lessons; they and the controls are asked with the same memories, bent in the same way,
in test situations with more and more obstacles that leave the catch that is known alone.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parents[1])]

from gcm_learn import dataset, seeding  # noqa: E402
from gcm_learn.arm.clearance import clearance  # noqa: E402
from gcm_learn.encoder import EncoderConfig  # noqa: E402
from gcm_learn.encoder.lesson import Best, Lesson  # noqa: E402
from gcm_learn.encoder.training import Effort, Trainer  # noqa: E402
from gcm_learn.families.random_planar import RandomPlanar  # noqa: E402
from gcm_learn.memory import Memory, RandomIndex, RawIndex, RecallPlanner, Trace  # noqa: E402
from gcm_learn.memory.lessons import School  # noqa: E402
from gcm_learn.memory.pca import PcaIndex  # noqa: E402
from gcm_learn.memory.recall import LearnedIndex  # noqa: E402
from gcm_learn.planners import Plan  # noqa: E402
from gcm_learn.planners.completion import Problem  # noqa: E402
from gcm_learn.situation import Situation  # noqa: E402

EXTRAS = (0, 1, 2, 4, 8)  # obstacles that are added
FREE = 0.1  # room that they leave the limb on the known catch [forearm lengths]
KINDS = ("trace", "map", "both")


class Same:
    """A teacher that gives all encoders the same lessons."""

    def __init__(self, school: School, maps: bool, given: dict[int, Lesson]) -> None:
        self.school, self.given = school, given
        self.ways, self.pictures = school.ways, school.pictures if maps else None

    def lesson(self, index: int, best: Best | None) -> Lesson:
        """Lesson number `index`, made when it is first asked for."""
        if index not in self.given:
            self.given[index] = self.school.lesson(index, None)
        return self.given[index]

    def exam(self, best: Best) -> dict[str, float]:
        """That of the school."""
        return self.school.exam(best)


def trained(school: School, turns: int) -> dict[str, LearnedIndex]:
    """One index for every kind of encoder."""
    given: dict[int, Lesson] = {}
    out = {}
    for kind in KINDS:
        config = EncoderConfig(memory=kind, hard=0.0, steps=24)
        with tempfile.TemporaryDirectory() as folder:
            teacher = Same(school, config.uses_maps, given)
            trainer = Trainer(config, teacher, Path(folder), Effort(turns=turns))
            out[kind] = LearnedIndex(trainer.run())
        print(kind, trainer.exam(), flush=True)
    return out


def cluttered(situation: Situation, plan: Plan, seed: int) -> list[Situation]:
    """The situation with ever more planar obstacles that leave limb and known catch alone."""
    family, now = RandomPlanar(), situation
    found, k = [], 0
    while k < 3000:
        extra = len(now.bodies) - len(situation.bodies)
        if extra in EXTRAS:
            found.append(now)
        if extra == max(EXTRAS):
            return found
        rng = seeding.rng(6, seed, k)
        k += 1
        shape, motion = family._shape(rng), family._motion(rng, situation.arm)
        body = replace(situation.obstacles[0], name=f"extra {k}", shape=shape, motion=motion)
        more = replace(now, bodies=(*now.bodies, body))
        blocked = Problem(more, "clutter").early_answer() is not None
        if not blocked and clearance(more, plan.trajectory)[0] > min(FREE, plan.clearance - 1e-6):
            now = more
    return found  # too crowded for all


def questions(records: dataset.Dataset, stratum: str, count: int) -> list[list[Situation]]:
    """Planar test situations of a stratum, each with ever more obstacles."""
    out = []
    for record in records.where(split="test", stratum=stratum):
        plans = [p for p in record.plans.values() if p.caught]
        if plans and not record.situation.is_solid and record.situation.obstacles:
            best = min(plans, key=lambda p: p.catch_time or 0.0)
            row = cluttered(record.situation, best, record.index)
            out += [row] if len(row) == len(EXTRAS) else []
        if len(out) == count:
            break
    return out


def main() -> None:
    """Train, ask, write table.md and figure.png."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("dataset")
    parser.add_argument("--memories", type=int, default=8000, help="records that are read")
    parser.add_argument("--turns", type=int, default=40, help="lessons of every encoder")
    parser.add_argument("--situations", type=int, default=200, help="of each stratum")
    given = parser.parse_args()
    records = dataset.open(given.dataset)
    school = School(records, 1, most=given.memories, maps=True)
    print(len(school.traces), "memories", flush=True)
    learned = trained(school, given.turns)
    traces = [Trace(k, g) for k, g in zip(school.traces, school.goals, strict=True)]
    base = Memory(RawIndex.fit(school.situations[:3000]), "exact")
    base.add(school.situations, traces)
    memories = {name: base.refiled(index) for name, index in learned.items()}
    memories |= {"raw": base, "pca": base.refiled(PcaIndex.fit(school.situations[:2000]))}
    memories["random"] = base.refiled(RandomIndex())
    lines = []
    for stratum in ("W", "Q"):
        asked = questions(records, stratum, given.situations)
        for name, memory in memories.items():
            planner = RecallPlanner(memory)
            for i, row in enumerate(asked):
                for extra, situation in zip(EXTRAS, row, strict=True):
                    found = planner.recollect(situation)
                    case = {"index": name, "stratum": stratum, "case": i, "extra": extra}
                    lines.append({**case, "caught": found.plan.caught, "checks": found.checked})
            print(stratum, name, flush=True)
    (HERE / "out").mkdir(exist_ok=True)
    text = "".join(json.dumps(line) + "\n" for line in lines)
    (HERE / "out" / "answers.jsonl").write_text(text)
    report(lines, len(school.traces))


def interval(values: np.ndarray) -> tuple[float, float]:
    """95 % bootstrap interval of a mean over situations."""
    draws = seeding.rng(0, len(values)).integers(len(values), size=(2000, len(values)))
    low, high = np.percentile(values[draws].mean(axis=1), [2.5, 97.5])
    return float(low), float(high)


def report(lines: list[dict], memories: int) -> None:
    """Write the table and the figure."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    def caught(name: str, stratum: str, extra: int, checks: int) -> np.ndarray:
        some = [
            x for x in lines if (x["index"], x["stratum"], x["extra"]) == (name, stratum, extra)
        ]
        return np.array([100.0 * (x["caught"] and x["checks"] <= checks) for x in some])

    names = list(dict.fromkeys(x["index"] for x in lines))
    rows = ["| stratum | checks | found by | " + " | ".join(f"+{e}" for e in EXTRAS) + " |",
            "|---|---|---|" + "---|" * len(EXTRAS)]  # fmt: skip
    figure, axes = plt.subplots(1, 4, figsize=(13.0, 3.6), sharey=True)
    panels = [(s, c) for s in ("W", "Q") for c in (1, 20)]
    for ax, (stratum, checks) in zip(axes, panels, strict=True):
        for name in names:
            values = [caught(name, stratum, e, checks) for e in EXTRAS]
            bounds = [interval(v) for v in values]
            cells = [
                f"{v.mean():.1f} ({a:.0f}–{b:.0f})"
                for v, (a, b) in zip(values, bounds, strict=True)
            ]
            rows.append(f"| {stratum} | {checks} | {name} | " + " | ".join(cells) + " |")
            ax.plot(EXTRAS, [v.mean() for v in values], "o-", ms=3, label=name)
        for kind in KINDS:
            gaps = [
                caught(kind, stratum, e, checks) - caught("raw", stratum, e, checks) for e in EXTRAS
            ]
            cells = [f"{g.mean():+.1f} ({a:+.0f}…{b:+.0f})" for g in gaps for a, b in [interval(g)]]
            rows.append(f"| {stratum} | {checks} | {kind} less raw | " + " | ".join(cells) + " |")
        ax.set(
            title=f"{stratum}, at most {checks} check{'s' * (checks > 1)}", xlabel="obstacles added"
        )
        ax.grid(alpha=0.25)
    axes[0].set_ylabel("caught [%]")
    axes[0].legend(fontsize=8)
    figure.tight_layout()
    figure.savefig(HERE / "figure.png", dpi=130)
    rows += ["", f"Caught [%] of {len(caught(names[0], 'W', 0, 1))} (W) and "
             f"{len(caught(names[0], 'Q', 0, 1))} (Q) planar test situations; {memories} memories; "
             "95 % bootstrap intervals, of differences over the same situations."]  # fmt: skip
    (HERE / "table.md").write_text("\n".join(rows) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
