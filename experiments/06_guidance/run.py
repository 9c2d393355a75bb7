"""Does guidance by cognitive maps, or a cloned start, halve the steps that learners need (H5)?

python -m experiments 06_guidance OUT   needs models/clone; goes on where it was stopped

OUT holds the runs; table.md and figure.png are written beside this file.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np

from experiments.common.tables import table
from gcm_learn.plots import style
from gcm_learn.policies import TrainingPlan, plan_of, train

HERE = Path(__file__).parent
EVERY = 8192  # steps between evaluations: one update of PPO
OFTEN = 2000  # the same of SAC
ARMS = {
    "scratch": "PPO from scratch",
    "guide": "PPO guided by maps' time to go",
    "clone": "PPO begun as the clone of planned catches",
    "sac-scratch": "SAC from scratch",
    "sac-guide": "SAC guided by maps' time to go",
}
STEPS = {"scratch": 25 * EVERY, "guide": 25 * EVERY, "clone": 3 * EVERY,
         "sac-scratch": 20 * OFTEN, "sac-guide": 20 * OFTEN}  # fmt: skip
COLOURS = {"scratch": style.FAINT, "guide": style.OBSTACLE, "clone": style.TARGET,
           "sac-scratch": style.FAINT, "sac-guide": style.OBSTACLE}  # fmt: skip
BASES = {arm: "sac-scratch" if arm.startswith("sac") else "scratch" for arm in ARMS}
PPO = {
    "algo": "ppo", "n_envs": 64, "n_steps": 128, "batch_size": 1024, "n_epochs": 4,
    "learning_rate": 3e-4, "ent_coef": 0.003, "net_arch": "256,256", "gae_lambda": 0.95,
    "evaluate_every": EVERY,
}  # fmt: skip
SAC = {
    "algo": "sac", "actions": "velocity", "n_envs": 32, "learning_starts": 2000,
    "buffer_size": 60_000, "batch_size": 256, "train_freq": 1, "gradient_steps": 8,
    "learning_rate": 5e-4, "ent_coef": "auto_0.01", "net_arch": "128,128",
    "evaluate_every": OFTEN,
}  # fmt: skip
SHARE = 0.8  # of the final rate


def plan_for(arm: str, seed: int, steps: int) -> TrainingPlan:
    """The run of an arm of the experiment; only what it is about differs."""
    entry = {
        **(SAC if arm.startswith("sac") else PPO), "n_timesteps": steps, "gamma": 0.99,
        "seed": seed, "situations": [{"source": "random-planar", "count": 3000}],
        "validation": [
            {"source": "random-planar", "count": 300, "reachable": True, "seed": 2}
        ],
        "settings": {"fan": True, "weights": {"guide": 1.0 if "guide" in arm else 0.0}},
    }  # fmt: skip
    if arm == "clone":
        entry["start"] = "models/clone"
    return plan_of(entry)


def curve_of(folder: Path, steps: int) -> np.ndarray:
    """Steps and catches (n, 2) of a run, so many steps of it."""
    rows = [json.loads(line) for line in (folder / "log.jsonl").read_text("utf-8").splitlines()]
    return np.array([(row["steps"], row["caught"]) for row in rows if row["steps"] <= steps])


def finished(out: Path, arm: str) -> list[np.ndarray]:
    """Curves of the runs of an arm that have ended."""
    folders = [p for p in sorted(out.glob(f"{arm}-?")) if (p / "card.md").exists()]
    return [curve_of(p, STEPS[arm]) for p in folders]


def steps_to(curve: np.ndarray, rate: float) -> float:
    """Steps until a rate is reached, between evaluations as on a straight line."""
    above = np.flatnonzero(curve[:, 1] >= rate)
    if not len(above):
        return float("inf")
    k = int(above[0])
    if k == 0:
        return 0.0
    (s0, r0), (s1, r1) = curve[k - 1], curve[k]
    return float(s0 + (rate - r0) / (r1 - r0) * (s1 - s0))


def report(curves: dict[str, list[np.ndarray]]) -> str:
    """The table: steps to 80 % of the final rate from scratch, by arm."""
    final = {arm: [float(np.mean(c[-3:, 1])) for c in each] for arm, each in curves.items()}
    head = [
        "arm", "seeds", "final rate [%], median (least to most)", "goal: 80 % of scratch's [%]",
        "steps to the goal, median (least to most)", "of scratch's",
    ]  # fmt: skip
    lines = []
    for arm, each in curves.items():
        goal = SHARE * float(np.median(final[BASES[arm]]))
        base = float(np.median([steps_to(c, goal) for c in curves[BASES[arm]]]))
        needed = [steps_to(c, goal) for c in each]
        middle = float(np.median(needed))
        low, high = 100 * min(final[arm]), 100 * max(final[arm])
        rate = f"{100 * np.median(final[arm]):.1f} ({low:.0f} to {high:.0f})"
        steps = f"{middle:,.0f} ({min(needed):,.0f} to {max(needed):,.0f})"
        share = f"{middle / base:.2f}"
        lines.append([ARMS[arm], len(each), rate, f"{100 * goal:.0f}", steps, share])
    return table(head, lines) + "\n"


def draw(curves: dict[str, list[np.ndarray]], path: Path) -> None:
    """Learning curves, one line a seed; a panel for each learner."""
    figure = style.new_figure(9.6, 3.4)
    panels = figure.subplots(1, 2, sharey=True)
    for ax, base in zip(panels, ("scratch", "sac-scratch"), strict=True):
        for arm, each in curves.items():
            if BASES[arm] != base:
                continue
            for k, curve in enumerate(each):
                ax.plot(
                    curve[:, 0] / 1e3, 100 * curve[:, 1], color=COLOURS[arm], lw=1.3,
                    label=ARMS[arm] if k == 0 else None,
                )  # fmt: skip
        ax.set_xlabel("steps [thousands]", fontsize=style.SMALL)
        ax.set_ylim(0, 102)
        ax.spines[["top", "right"]].set_visible(False)
        ax.legend(fontsize=style.SMALL, frameon=False, loc="lower right")
    panels[0].set_ylabel("caught, validation [%]", fontsize=style.SMALL)
    figure.savefig(path, dpi=150)


def main() -> None:
    """Train what is missing, then report."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("out", type=Path)
    parser.add_argument("--seeds", type=int, default=5)
    given = parser.parse_args()
    for seed in range(given.seeds):
        for arm in ARMS:
            folder = given.out / f"{arm}-{seed}"
            if not (folder / "card.md").exists():
                print(f"{arm}, seed {seed}", flush=True)
                train(plan_for(arm, seed, STEPS[arm]), folder, lambda text: None)
            done = {a: finished(given.out, a) for a in ARMS}
            if all(done.values()):
                (HERE / "table.md").write_text(report(done), "utf-8")
                draw(done, HERE / "figure.png")
    print((HERE / "table.md").read_text("utf-8"))


if __name__ == "__main__":
    main()
