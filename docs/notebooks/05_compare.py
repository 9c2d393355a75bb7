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
# The first table of the README, on situations that you draw: change the seed. Maps guide `gcm` and `ppo-guide`, memories are
# retrieved by `recall` and `recall-map`, `ppo` and `ppo-clone` have learned, `search` and `marching` plan. The referee judges
# each answer. A trained policy acts as it goes, or (`ppo@20`) is tried out with the predictor and verified first.

# %%
# %matplotlib inline
import os
from tempfile import mkdtemp

from gcm_learn.evaluation import Condition, ask, cases, page, pairs, shares

FAST = bool(os.environ.get("GCM_LEARN_FAST"))
SEED = 2026
entrants = ["search", "recall", "ppo", "marching"]
if FAST:
    mine = cases("gate", "crossing-swarm", count=4, seed=SEED)
else:  # looks for 30 that need a detour and 30 that need a wait, some minutes
    mine = cases("W", "Q", count=30, seed=SEED)
    entrants += ["gcm", "ppo-guide", "recall-map", "ppo-clone"]
conditions = [Condition(), Condition(thinking=0.02)]
sheet = ask(entrants, mine, conditions, keep=mkdtemp())

# %% [markdown]
# Shares of catches, without thinking charged and after 20 ms. Families may hold situations without any catch, so look at
# differences rather than at shares there.

# %%
print(shares(sheet, ("entrant", "thinking")))

# %%
plain = sheet.where(thinking="0 ms")
print(pairs(plain, "search"))

# %% [markdown]
# One page has the rest: times, families, what goes wrong, conditions and the machine. `gcm-learn compare search,recall
# --on mine.jsonl` does the same for situations in a file.

# %%
print(page(sheet, mkdtemp()))

# %%
from gcm_learn.plots import sheet_figures

names = plain.each("entrant")
spans = dict(zip(names, shares(plain, "entrant")["caught [%]"], strict=True))
sheet_figures.spans_figure("drawn here", "caught [%]", spans, sheet_figures.colours_of(names))
