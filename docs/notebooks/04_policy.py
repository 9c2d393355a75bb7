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
# # Train a policy
#
# The arm as a Gymnasium environment; needs the extra `rl`.

# %%
import os
import tempfile
from pathlib import Path

import gymnasium

FAST = bool(os.environ.get("GCM_LEARN_FAST"))
env = gymnasium.make(
    "gcm_learn:CatchArm-v0", situations="crossing-swarm", pool=16, render_mode="rgb_array"
)
observation, info = env.reset(seed=1)
over = False
while not over:
    observation, reward, ended, late, info = env.step(env.action_space.sample())
    over = ended or late
print(info["outcome"], info["reward_terms"])

# %% [markdown]
# Random actions catch hardly anything. A clone imitates planned catches: at every step it chooses one of 24
# directions, or to rest. This one sees only a few.

# %%
from gcm_learn.policies import plan_of
from gcm_learn.policies import train

plan = plan_of({
    "algo": "clone",
    "situations": [{"source": "random-planar", "count": 60 if FAST else 600}],
    "validation": [{"source": "random-planar", "count": 30, "reachable": True, "seed": 1}],
    "epochs": 10, "batch": 256, "net_arch": "64,64",
})  # fmt: skip
folder = Path(tempfile.mkdtemp()) / "clone"
scores = train(plan, folder)
print({name: round(value, 2) for name, value in scores.items()})

# %% [markdown]
# What it does in one situation, and the last moment.

# %%
from PIL import Image

from gcm_learn.policies import Actor
from gcm_learn.envs import CatchArm

actor = Actor.load(folder)
arm = CatchArm("random-planar", "rgb_array", pool=16, settings=actor.settings)
observation, info = arm.reset(seed=3)
over = False
while not over:
    action = actor.act(observation[None])[0]
    observation, reward, ended, late, info = arm.step(action)
    over = ended or late
print(info["outcome"], "after", round(info["time"], 2), "s")
Image.fromarray(arm.render())
