"""Compare learners: by reward alone, guided by maps, or begun with planned catches.

python -m experiments 04_policies OUT [--workers 2]   goes on where it was stopped

Needs data/train, the dataset of data/specs/train.toml. OUT holds the runs; table.md and figure.png
are written beside this file.
"""

from __future__ import annotations

import argparse
import json
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from multiprocessing import get_context
from pathlib import Path
from typing import Any

from report import write_report

from gcm_learn.envs import Pool
from gcm_learn.evaluation import cases
from gcm_learn.policies import Actor, TrainingPlan, plan_of, score, train

HERE = Path(__file__).parent
STRATA = ("L", "W", "Q")
SITUATIONS = 12_000
PPO = {
    "algo": "ppo", "n_timesteps": 600_000, "n_envs": 64, "n_steps": 128, "batch_size": 1024,
    "n_epochs": 4, "learning_rate": 3e-4, "ent_coef": 0.003, "net_arch": "256,256", "gamma": 0.99,
    "evaluate_every": 50_000,
}  # fmt: skip
SAC = {
    "algo": "sac", "actions": "velocity", "n_timesteps": 100_000, "n_envs": 32,
    "learning_starts": 5000, "buffer_size": 600_000, "batch_size": 256, "train_freq": 1,
    "gradient_steps": 8, "learning_rate": 5e-4, "ent_coef": "auto_0.01", "net_arch": "128,128",
    "gamma": 0.99, "evaluate_every": 20_000,
}  # fmt: skip
CLONE = {"algo": "clone", "epochs": 12, "batch": 2048, "rate": 1e-3}
LEARNERS: dict[str, dict[str, Any]] = {
    "clone": {**CLONE, "net_arch": "256,256"},
    "velocity": {**CLONE, "net_arch": "128,128", "actions": "velocity"},
    "ppo": PPO,
    "sac": SAC,
    "tqc": {**SAC, "algo": "tqc"},
}
BEGINS_AS = {"ppo": "clone", "sac": "velocity", "tqc": "velocity"}


@dataclass(frozen=True)
class Arm:
    """One run of the experiment."""

    learner: str
    help: str
    """scratch, guide (maps' time to go in the reward) or catches (a cloned start; learners with a
    replay buffer are also shown the catches)."""
    embedding: bool = False
    """True if the embedding of the situation is observed, too."""

    @property
    def name(self) -> str:
        """Of its folder."""
        return f"{self.learner}-{self.help}" + ("-embedding" if self.embedding else "")

    def plan(self, out: Path, seed: int) -> TrainingPlan:
        """Return the training of an arm; arms differ in one thing each."""
        entry: dict[str, Any] = {**LEARNERS[self.learner], "seed": seed}
        entry["situations"] = [
            {"source": "data/train", "count": SITUATIONS, "strata": list(STRATA)}
        ]
        entry["validation"] = [
            {"source": "data/train", "count": 600, "split": "validation", "strata": list(STRATA)},
            {"source": "random-planar", "count": 300, "reachable": True, "seed": 2},
        ]
        guide = 1.0 if self.help == "guide" else 0.0
        entry["settings"] = {"fan": True, "embedding": self.embedding, "weights": {"guide": guide}}
        if self.help == "catches" and self.learner in BEGINS_AS:
            start = Arm(BEGINS_AS[self.learner], "catches", self.embedding)
            entry["start"] = str(out / start.name)
            if self.learner != "ppo":
                entry |= {"demonstrations": True, "learning_starts": 0}
        return plan_of(entry)


CLONES = [Arm(learner, "catches", e) for e in (False, True) for learner in ("clone", "velocity")]
ARMS = [
    Arm(learner, help_, embedding)
    for embedding in (False, True)
    for learner in ("ppo", "sac")
    for help_ in ("scratch", "guide", "catches")
] + [Arm("tqc", "scratch")]


def do(arm: Arm, out: Path, seed: int) -> str:
    """Train an arm to its end."""
    folder = out / arm.name
    if not (folder / "card.md").exists():
        train(arm.plan(out, seed), folder, lambda text: None)
    return arm.name


def tested(folder: Path, count: int) -> dict[str, float]:
    """Catches and touches of a trained actor on the frozen suites of the strata."""
    kept = folder / f"suites-{count}.json"
    if not kept.exists():
        found = cases(*STRATA, count=count)
        pool = Pool.of([case.situation for case in found])
        scores = score(Actor.load(folder), pool, [case.stratum for case in found])
        kept.write_text(json.dumps(scores) + "\n")
    found: dict[str, float] = json.loads(kept.read_text("utf-8"))
    return found


def main() -> None:
    """Train what is missing, then report."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--count", type=int, default=1000, help="situations of a suite")
    parser.add_argument("--report", action="store_true", help="of what has been trained so far")
    given = parser.parse_args()
    if not given.report:
        with ProcessPoolExecutor(given.workers, get_context("spawn")) as pool:
            for arms in (CLONES, ARMS):
                for job in [pool.submit(do, arm, given.out, given.seed) for arm in arms]:
                    print(job.result(), flush=True)
    runs = [arm for arm in (*CLONES, *ARMS) if (given.out / arm.name / "card.md").exists()]
    rows = [(arm, given.out / arm.name, tested(given.out / arm.name, given.count)) for arm in runs]
    write_report(HERE, rows)
    print((HERE / "table.md").read_text("utf-8"))


if __name__ == "__main__":
    main()
