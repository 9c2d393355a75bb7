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
# # Clusters of catches
#
# Which catches are alike? An encoder places each by its cognitive map, another by its movement. Raw
# parameters of the situation are the control. K-means takes the number of clusters that separates them best.

# %%
import os

import numpy as np

from gcm_learn import artifacts, build_map, dataset
from gcm_learn.plots import plot_map
from gcm_learn.recall import cluster, cross_tries, remember

# %matplotlib inline
FAST = bool(os.environ.get("GCM_LEARN_FAST"))
records = dataset.open(artifacts.shipped("data") / "sample")
memory = remember(records, most=60 if FAST else None)
found = {by: cluster(memory, by, count=4 if FAST else None) for by in ("map", "trace", "raw")}
for by, one in found.items():
    print(f"{by:6}", np.bincount(one.labels)[1:], f"silhouette {one.silhouette:.2f}")

# %% [markdown]
# Are they kinds of movements? Then a catch should do for others of its cluster. Random catches are tried on
# situations that no straight line solves; shares with their 95 % intervals.

# %%
tries = cross_tries(memory)
labels = {by: one.labels for by, one in found.items()} | {"any": np.zeros(len(memory))}
for by, own in labels.items():
    share, *draws = tries.shares(own)
    low, high = np.percentile(draws, [2.5, 97.5])
    print(f"same cluster by {by:6} {share:4.0%} ({low:.0%} to {high:.0%})")

# %% [markdown]
# The most central catch of each of the three largest clusters: where its hand can be, and when.

# %%
from matplotlib.figure import Figure

figure = Figure(figsize=(9, 3.3), layout="constrained")
maps = found["map"]
for ax, k in zip(figure.subplots(1, 3), maps.medoids, strict=False):
    plot_map(build_map(memory[k].situation), ax)
    ax.set_title(f"{memory[k].family}, one of {np.sum(maps.labels == maps.labels[k])}")
figure

# %% [markdown]
# To try: `gcm-learn cluster models/recall --out clusters` makes a page on which every point shows its map and
# its catch. It takes your own datasets, too.
