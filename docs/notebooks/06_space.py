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
# # An arm in space
#
# The same idea with four joints: three in the shoulder, one in the elbow. Hand-space is a ball. At each place of the
# hand the elbow may be anywhere on a circle, so a map needs a rule that picks postures; a search over the joints needs none.

# %%
# %matplotlib inline
import numpy as np
from matplotlib.figure import Figure

from gcm_learn import families, paper_scene, solve

situation = paper_scene("fig8-space")
for planner in ("straight", "marching", "search"):
    plan = solve(situation, planner)
    print(f"{planner:10} {plan.status:12} {plan.message}")

# %% [markdown]
# **What to look at.** `marching` reads its path from the map, `search` moves the joints themselves. Joints and hand of the
# catch, over time: each joint keeps its greatest speed, and the hand its own.

# %%
plan = solve(situation)
moves = plan.trajectory
times = np.linspace(0.0, plan.catch_time, 80)
figure = Figure(figsize=(9, 3.2), layout="constrained")
left, right = figure.subplots(1, 2)
left.plot(times, [moves.joints_at(t) for t in times], label=["q1", "q2", "q3", "elbow"])
left.set(xlabel="time [s]", ylabel="joint [rad]")
left.legend()
right.plot(times, [moves.hand_at(t) for t in times], label=list("xyz"))
right.set(xlabel="time [s]", ylabel="hand")
right.legend()
figure

# %% [markdown]
# Random scenes come from families. How many of them does a straight move catch, and how many the search?

# %%
import os

count = 6 if os.environ.get("GCM_LEARN_FAST") else 60
drawn = [families.draw("window-space", 5, k) for k in range(count)]
for planner in ("straight", "straight-wait", "search"):
    caught = np.mean([solve(one, planner).caught for one in drawn])
    print(f"{planner:14} catches {caught:4.0%}")

# %% [markdown]
# **Try.** Replace `window-space` by another name of `families.family_names("spatial")`. Where does waiting help? Give the
# arm limits of acceleration (`families.draw` keeps those of the family; `dataclasses.replace(situation.arm,
# max_joint_acceleration=(30, 30, 60, 60))` sets them): how much later are the catches, and why does `straight` suffer most?
