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
# # Generate and explore a dataset
#
# A dataset is made from a specification and nothing else: item *k* is a pure function of the two.
# `gcm-learn generate SPEC --out DIR` makes all of them on all cores; here are some, one by one. Needs the extra
# `data`.

# %%
# %matplotlib inline
import os

from gcm_learn import artifacts, dataset
from gcm_learn.dataset import DatasetSpec, FamilyShare, make_item
from gcm_learn.plots import plot_map

FAST = bool(os.environ.get("GCM_LEARN_FAST"))
families = tuple(FamilyShare(name) for name in ("gate", "crossing-swarm", "random-planar"))
spec = DatasetSpec(name="notebook", seed=7, count=1000, families=families, planners=("layered",),
                   map="marching", rungs=2)  # fmt: skip
for k in range(3 if FAST else 12):
    found = make_item(spec, k)
    print(k, found.family, found.stratum, found.plans["layered"].message)
again = make_item(spec, 2)
assert again.situation == found.situation or k != 2

# %% [markdown]
# The sample that comes with the package is a dataset like any other. Labels are read without touching
# anything else. L: a straight line works; W: a way round is needed; Q: the hand has to wait; U: none of the
# planners catches.

# %%
records = dataset.open(artifacts.shipped("data") / "sample")
records.to_pandas()[["family", "stratum", "obstacles", "top_speed"]].head(10)

# %%
import numpy as np

strata, counts = np.unique(records.column("stratum").astype(str), return_counts=True)
print(dict(zip(strata.tolist(), counts.tolist(), strict=True)))

# %% [markdown]
# A record holds the situation in its canonical form, its map and its plans.

# %%
record = next(r for r in records.where(stratum="W") if r.plans["layered"].caught)
print(record.family, record.stratum, record.plans["layered"].message)
plot_map(record.map).figure
