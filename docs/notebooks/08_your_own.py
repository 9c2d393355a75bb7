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


def place(target, t):
    """Return the place of a target on a parabola after t seconds."""
    law = target.motion
    return (
        np.array(law.position) + t * np.array(law.velocity) + t**2 / 2 * np.array(law.acceleration)
    )


class Direct:
    """Wait for a while, then go straight to the first place where the hand is in time."""

    def __init__(self, wait=0.0):
        self.wait, self.name = wait, f"direct {wait:.1f}"

    def plan(self, situation):
        """Return a plan that is believed to catch."""
        arm, target = situation.arm, situation.targets[0]
        start = np.array(arm.hand)
        for arrive in np.linspace(self.wait, situation.horizon, 60)[1:]:
            goal = place(target, arrive)
            lasts = np.linalg.norm(goal - start) / (0.9 * arm.max_hand_speed)
            if lasts <= arrive - self.wait and np.linalg.norm(goal) < 0.95 * (arm.upper_arm + 1.0):
                break
        else:
            return Plan(situation.name, self.name, "unreachable", "never in time", 0.0)
        times = np.linspace(0.0, arrive, 60)
        share = np.clip((times - self.wait) / (arrive - self.wait), 0.0, 1.0)
        moves = Movement.of_hand(arm, times, start + share[:, None] * (goal - start))
        said = f"caught {target.name!r} at {arrive:.2f} s"
        return Plan(
            situation.name, self.name, "caught", said, 0.0, arrive, target.name, trajectory=moves
        )


easy = families.draw("static-clutter", seed=0, index=4)
print(solve(easy, Direct()).message)

# %% [markdown]
# This catch was verified: the planner looks at no obstacle, but none is in its way here. Behind a gate the same planner
# promises too much, and the answer names what is wrong. A wait until the gate is open helps.

# %%
gate = families.draw("gate", seed=0, index=5)
for planner in (Direct(), Direct(wait=0.4)):
    plan = solve(gate, planner)
    print(f"{planner.name}: {plan.message}")

# %% [markdown]
# **What to look at.** Status `broken` is a promise that verification refuted: too fast, through an obstacle, off the
# target. On the same situations it stands beside other planners, with intervals and paired tests. `error` counts the
# situations in which the planner raised an exception: `place` knows parabolas only.

# %%
from collections import Counter

from gcm_learn.evaluation import ask, cases

suite = cases("demo", count=8)
sheet = ask(["straight", Direct(), "search"], suite)
for name in sheet.each("entrant"):
    print(f"{name:12}", dict(Counter(sheet.where(entrant=name)["outcome"].tolist())))

# %% [markdown]
# Where does it fail? The path of the search, over the map of the first situation that it catches.

# %%
from gcm_learn import build_map
from gcm_learn.plots import plot_map

case = next(case for case in suite if solve(case.situation).caught)
plan = solve(case.situation)
plot_map(build_map(case.situation), path=plan.trajectory.hand).figure

# %% [markdown]
# **Try.** Let `Direct` try several waits and arrivals, and return the first plan for which
# `solve(situation, self)` would not say `broken`. How close to `straight-wait` does it come, and to `search`?
