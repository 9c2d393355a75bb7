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
# # Compare planners and policies
#
# All on the same frozen situations: planners, and the trained policies that come with the repository, acting
# as they go or (`@20`) tried out with the predictor and verified before the hand moves. With all strata
# and more situations this is the main figure of the report that `gcm-learn evaluate` writes.

# %%
# %matplotlib inline
import os

from gcm_learn.evaluation import compare, draw_suite
from gcm_learn.evaluation import beyond_chance, measured, pairs
from gcm_learn.plots import families_figure, rates_figure

FAST = bool(os.environ.get("GCM_LEARN_FAST"))
entries = draw_suite("demo", 8 if FAST else 50)
names = ["straight", "layered", "clone"] if FAST else [
    "straight", "straight-wait", "potential", "gcm", "marching", "layered",
    "clone", "clone@20", "ppo", "ppo-clone", "ppo-clone@20",
]  # fmt: skip
results = compare(names, entries, charge=0, workers=1)
rates_figure(results)

# %% [markdown]
# In numbers, over the situations that can be caught at all, and each against `layered`.

# %%
reachable = results.where(results["stratum"] != "U")
for name in names:
    m = measured(reachable, name)
    print(
        f"{name:14} caught {m.caught.value:4.0%}, touched {m.collisions.value:4.0%}, {m.latency:6.1f} ms"
    )

# %%
for pair in pairs(results, "layered"):
    d = pair.difference
    print(
        f"{pair.first:14} {d.value:+.2f} ({d.low:+.2f} to {d.high:+.2f}), p = {pair.p:.3f}, "
        f"beyond chance: {beyond_chance(d, pair.p)}"
    )

# %%
families_figure(results)
