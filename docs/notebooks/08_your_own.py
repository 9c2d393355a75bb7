# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # Your own planner
#
# A planner is an object with `plan(situation)`. Whatever it returns is verified; what it promises wrongly is named.

# %%
# %matplotlib inline
import numpy as np

from gcm_learn import Movement, Plan, families, solve


class Patient:
    """Wait for a while, then go straight to where the target will be."""

    def __init__(self, wait, arrive):
        self.wait, self.arrive = wait, arrive
        self.name = f"patient {wait:.1f}"

    def plan(self, situation):
        """Return a plan that is believed to catch."""
        target = situation.targets[0]
        goal = np.array(target.motion.position) + self.arrive * np.array(target.motion.velocity)
        times = np.linspace(0.0, self.arrive, 60)
        share = np.clip((times - self.wait) / (self.arrive - self.wait), 0.0, 1.0)
        start = np.array(situation.arm.hand)
        moves = Movement.of_hand(situation.arm, times, start + share[:, None] * (goal - start))
        return Plan(
            situation.name, self.name, "caught", "", 0.0, self.arrive, target.name, trajectory=moves
        )


situation = families.draw("gate", seed=0, index=7)
for planner in (Patient(0.0, 0.9), Patient(0.4, 0.9)):
    print(planner.name, "->", solve(situation, planner).message)

# %% [markdown]
# **What to look at.** Status `broken` is a promise that verification refuted: too fast, through an obstacle, off the
# target. On the same situations it stands beside other planners, with intervals and paired tests.

# %%
from gcm_learn.evaluation import compare, draw_suite

suite = draw_suite("demo", 8)
results = compare(["straight", Patient(0.4, 0.9), "search"], suite, charge=0, workers=1)
names, outcomes = results["entrant"], results["outcome"]
for name in dict.fromkeys(names.tolist()):
    rows = outcomes[names == name]
    print(f"{name:12}", {one: int((rows == one).sum()) for one in sorted(set(rows.tolist()))})

# %% [markdown]
# Where does it fail? The path of the search, over the map of the first situation that it catches.

# %%
from gcm_learn import build_map
from gcm_learn.plots import plot_map

entry = next(e for e in suite if solve(e.situation).caught)
plan = solve(entry.situation)
plot_map(build_map(entry.situation), path=plan.trajectory.hand).figure

# %% [markdown]
# **Try.** Let `Patient` try several waits and arrivals, and return the first plan for which
# `solve(situation, self)` would not say `broken`. How close to `straight-wait` does it come, and to `search`?
