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
# # A measured world
#
# Cameras give points, drawings give triangles, trackers give positions that are a little wrong. Here a Panda plans
# among all three.

# %%
# %matplotlib inline
from gcm_learn import families, solve
from gcm_learn.plots import plan_figure

situation = families.draw("panda-room-cloud", seed=1, index=0)
plan = solve(situation)
for body in situation.obstacles:
    print(body.name, body.shape.kind, len(getattr(body.shape, "points", ())), "points")
print(plan.message, f"{plan.clearance:.3f} m clear")

# %% [markdown]
# **What to look at.** Each ball is one point of the shelf with its radius. The planner, the judge and the referee take
# the balls themselves.

# %%
plan_figure(situation, plan)

# %% [markdown]
# **Fewer balls.** `simplified` joins the points in each cube. The balls grow, so that they hold all of the old ones.

# %%
from dataclasses import replace

shelf = next(body for body in situation.obstacles if body.shape.kind == "cloud")
cloud, grown = shelf.shape.simplified(cell=0.05)
print(
    len(shelf.shape.points),
    "points,",
    len(cloud.points),
    "after; the radius grows by",
    round(grown, 3),
)
bodies = tuple(replace(b, shape=cloud) if b is shelf else b for b in situation.bodies)
simple = replace(situation, bodies=bodies)
print(solve(simple).message)

# %% [markdown]
# **Somebody walks past.** Where a person will be is known the less, the later it is. The pale shell is the margin at the
# end of the movement.

# %%
for k in range(30):
    walk = families.draw("panda-person", seed=1, index=k)
    plan = solve(walk)
    persons = [body for body in walk.obstacles if body.margin is not None]
    if plan.caught and persons:
        break
print(plan.message)
print(persons[0].margin)
plan_figure(walk, plan)

# %% [markdown]
# **Try it.** Give a person a larger rate, `replace(person, margin=Margin(0.05, 0.3))`, and see when no catch is left.
# `gcm-learn calibrate` finds margins from recorded tracks.
