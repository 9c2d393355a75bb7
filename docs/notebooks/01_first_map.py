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
# # A first cognitive map, in five minutes
#
# An arm of two joints has to catch a ball that flies past a moving post. Lengths are in forearms, times in
# seconds, and the shoulder is the origin.

# %%
# %matplotlib inline
from gcm_learn import Arm, Body, Disc, PlanarQuadratic, Situation, build_map, solve
from gcm_learn.plots import draw_courses, draw_workspace, plot_map

flight = PlanarQuadratic(position=(0.2, 1.6), velocity=(0.9, 0.0), acceleration=(0.0, -1.5))
drift = PlanarQuadratic(position=(1.0, 0.45), velocity=(0.5, 0.0), acceleration=(0.0, 0.0))
ball = Body("target", "ball", Disc(radius=0.08), flight)
post = Body("obstacle", "post", Disc(radius=0.1), drift)
situation = Situation("flying-ball", 1.0, Arm(hand=(1.5, -0.6), max_hand_speed=3.0), (ball, post))

# %% [markdown]
# The straight line to the earliest interception would touch the post. The planner of the paper lets a wave
# of excitation spread from the hand through hand-space and reads a path from what it leaves behind.

# %%
print(solve(situation, "straight").message)
plan = solve(situation, "gcm")
assert plan.caught
print(plan.message, f"({plan.clearance:.2f} forearms clear)")

# %% [markdown]
# The situation with the courses of its bodies, and the map: arrival times of the wave, in red the cells in
# which it met the post, and the path.

# %%
from matplotlib.figure import Figure

figure = Figure(figsize=(9, 4.2), layout="constrained")
left, right = figure.subplots(1, 2)
draw_workspace(left, situation)
draw_courses(left, situation, plan.catch_time)
plot_map(plan.map, right, plan.trajectory.hand)
figure

# %% [markdown]
# The same map without neurons, by causal marching: arrivals are exact, and it takes a fraction of the time.

# %%
from gcm_learn import MarchingParams

marched = build_map(situation, MarchingParams())
print(
    f"contact: {plan.map.interception.time:.3f} s by the wave, {marched.interception.time:.3f} s by marching"
)
