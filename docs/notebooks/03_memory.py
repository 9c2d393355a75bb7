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
# # Train and use a memory
#
# A memory keeps catches as short traces. In a new situation it recalls some, bends their ends to the new
# hand and target, and answers with the first that a verification confirms. Nothing is planned.

# %%
import os

from gcm_learn import artifacts, dataset, families, solve
from gcm_learn.recall import RecallPlanner, SplinesPlanner
from gcm_learn.recall import remember

FAST = bool(os.environ.get("GCM_LEARN_FAST"))
records = dataset.open(artifacts.shipped("data") / "sample")
memory = remember(records.where(split="train"), "raw", most=80 if FAST else None)
print(len(memory), "catches of", len(records), "records are remembered")

# %% [markdown]
# How many of some new situations does it catch, with how little thinking? Random movements with the same
# verification are the control: they say what verification does alone.

# %%
import numpy as np

situations = [families.draw("crossing-swarm", 5, k) for k in range(6 if FAST else 60)]
planners = {
    "recall": RecallPlanner(memory),
    "random splines": SplinesPlanner(),
    "layered": "layered",
}
for name, planner in planners.items():
    solve(situations[0], planner)  # what is compiled or loaded first is no thinking
    plans = [solve(s, planner) for s in situations]
    caught = np.mean([p.caught for p in plans])
    print(
        f"{name:15} catches {caught:4.0%}, median {np.median([p.planning_ms for p in plans]):.1f} ms"
    )
