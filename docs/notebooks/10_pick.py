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
# # A pick that a robot can carry out
#
# A touch at two metres a second is no pick. Here the hand takes the part's velocity, keeps it while a gripper closes,
# carries the part to a bin and rests there.

# %%
# %matplotlib inline
from gcm_learn import families, solve

for k in range(10):
    situation = families.draw("panda-belt", seed=1, index=k)
    plan = solve(situation)
    print(situation.name, "|", plan.message)
    if plan.placed is not None:
        break

# %% [markdown]
# The target says what is wanted: for how long it is to be held, how fast the hand may be relative to it, and its place.
# From `held_until` to `placed` the part counts as a link of the arm, which keeps clear of obstacles.

# %%
target = situation.targets[0]
print(target.hold)
print(target.place)
print(plan.catches)

# %% [markdown]
# **What to look at.** The dark line is the hold, the cross is the place. Pale shells are margins.

# %%
from gcm_learn.plots import plan_figure

plan_figure(situation, plan)

# %% [markdown]
# **Speeds.** Before the catch the hand is much faster than the part. During the hold (grey) it is as fast, to the
# relative speed that is allowed. Then it speeds up again, until it rests.

# %%
import numpy as np
from matplotlib.figure import Figure

step = 1e-4
times = np.linspace(0.0, plan.trajectory.duration - step, 600)
ends = [plan.trajectory.hand_at(t) for t in (times, times + step)]
speed = np.linalg.norm(ends[1] - ends[0], axis=1) / step
figure = Figure(figsize=(7, 3.2), layout="constrained")
axes = figure.subplots()
axes.plot(times, speed, label="hand")
axes.axhline(np.linalg.norm(target.motion.velocity), color="0.4", linestyle="--", label="part")
axes.axvspan(plan.catch_time, plan.held_until, color="0.85", label="hold")
axes.set(xlabel="time [s]", ylabel="speed [m/s]")
axes.legend()
figure

# %% [markdown]
# **For the robot.** An even rate and rest at both ends are what controllers ask for. `to_csv` writes a row for each
# millisecond, `to_joint_trajectory` a message for ROS 2.

# %%
from gcm_learn.motion import to_csv, to_joint_trajectory

rows = to_csv(plan.trajectory, rate=1000).splitlines()
message = to_joint_trajectory(plan.trajectory, rate=250)
print(len(rows) - 1, "rows:", rows[0][:60], "...")
print(len(message["points"]), "points; the last velocities:", message["points"][-1]["velocities"])

# %% [markdown]
# **Try.** `families.draw("panda-turntable", seed=1, index=0)`, or `panda-handover`: which of them are caught? How does the share
# change when `relative_speed` is halved (`dataclasses.replace` of the target's `hold`)?
