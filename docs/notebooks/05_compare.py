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
# Draw situations, ask whatever acts, and look at one sheet of answers. The referee judges each answer. A trained policy
# acts as it goes, or (`@20`) is tried out with the predictor and verified before the hand moves.

# %%
# %matplotlib inline
import os
from tempfile import mkdtemp

from gcm_learn.evaluation import Condition, ask, cases, page, pairs, shares

FAST = bool(os.environ.get("GCM_LEARN_FAST"))
count = 4 if FAST else 30
mine = cases("gate", "crossing-swarm", count=count, seed=1)
entrants = ["search", "straight", "recall", "clone"]
if not FAST:
    entrants += ["hybrid", "straight-wait", "marching", "clone@20"]
conditions = [Condition(), Condition(thinking=0.02), Condition(thinking="own")]
sheet = ask(entrants, mine, conditions, keep=mkdtemp())

# %% [markdown]
# Shares of catches, without thinking charged, after 20 ms, and after each answer's own processor time. Families may hold
# situations without any catch, so look at differences rather than at shares.

# %%
print(shares(sheet, ("entrant", "thinking")))

# %%
plain = sheet.where(thinking="0 ms")
print(pairs(plain, "search", "family"))

# %% [markdown]
# One page has the rest: times, families, what goes wrong, conditions and the machine. `gcm-learn compare search,recall
# --on mine.jsonl` does the same for situations in a file.

# %%
print(page(sheet, mkdtemp()))

# %%
from gcm_learn.plots import sheet_figures

names = plain.each("entrant")
spans = dict(zip(names, shares(plain, "entrant")["caught [%]"], strict=True))
sheet_figures.spans_figure("gates and swarms", "caught [%]", spans, sheet_figures.colours_of(names))
