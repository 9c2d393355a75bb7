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
# # An arm with mass
#
# Plans are kinematic. Here MuJoCo carries one out with an arm that has masses, motors and contacts (extra `sim`).

# %%
# %matplotlib inline
from matplotlib.figure import Figure

from gcm_learn import paper_scene, solve
from gcm_learn.execution import body_for, execute, with_motor_limits

scene = paper_scene("fig8-space")
body = body_for(scene.arm)
situation = with_motor_limits(scene, body)
print(
    body.name,
    "may accelerate its joints by",
    [round(a) for a in situation.arm.max_joint_acceleration],
    "rad/s^2",
)

# %% [markdown]
# `with_motor_limits` asks of the motors what they can give before anything is planned. Without it the plan may ask for
# torques that no motor has. The controller follows the plan; what is measured is how far the joints stray.

# %%
asked = {"within the motors' limits": situation, "without limits": scene}
for name, one in asked.items():
    plan = solve(one)
    done = execute(plan, one, body)
    print(
        f"{name:26} {done.status:8} {1e3 * done.error[1]:5.1f} mm off at most,"
        f" {100 * done.torque:4.0f} % of a motor's torque"
    )

# %% [markdown]
# **What to look at.** The path that was planned, and the error of the hand on it.

# %%
import numpy as np

plan = solve(situation)
times = np.linspace(0.0, plan.catch_time, 60)
hand = np.array([plan.trajectory.hand_at(t) for t in times])
figure = Figure(figsize=(6, 3.2), layout="constrained")
axes = figure.subplots()
axes.plot(times, hand, label=list("xyz"))
axes.axvline(plan.catch_time, color="0.6", linestyle=":")
axes.set(xlabel="time [s]", ylabel="hand as planned [upper arms]")
axes.legend()
figure

# %% [markdown]
# **Try.** `execute(plan, situation, heavier, believed=body)` with a body of larger masses (`dataclasses.replace`): at
# which factor is the catch lost? `planners.InTube` keeps a tube free about the plan: how much of the catches does that cost?
