"""Comparison: any planners and policies on the same situations, with paired statistics."""

from gcm_learn.evaluation.contest import DELAYS, compare, warmed
from gcm_learn.evaluation.costs import Cost, costs_of, log_of
from gcm_learn.evaluation.entrants import Entrant, entrants_of
from gcm_learn.evaluation.measures import (
    Measures,
    Pair,
    charged_curve,
    declines,
    measured,
    pairs,
)
from gcm_learn.evaluation.methods import ActorMethod, Method, Result, get_method
from gcm_learn.evaluation.movements import collision_point
from gcm_learn.evaluation.statistics import (
    Interval,
    beyond_chance,
    chance,
    difference,
    hierarchical,
    holm,
    mcnemar,
    stratified,
    wilson,
)
from gcm_learn.evaluation.suites import (
    Entry,
    check_suite,
    draw_suite,
    hash_of,
    suite_file,
    suite_names,
)
from gcm_learn.evaluation.table import Results
from gcm_learn.evaluation.under_noise import (
    UnderNoise,
    compare_under_noise,
    noise_episodes,
    under_noise,
)
from gcm_learn.evaluation.verdict import verdict, who

__all__ = [
    "ActorMethod",
    "Cost",
    "DELAYS",
    "Entrant",
    "Entry",
    "Interval",
    "Measures",
    "Method",
    "Pair",
    "Result",
    "Results",
    "UnderNoise",
    "chance",
    "charged_curve",
    "check_suite",
    "collision_point",
    "compare",
    "compare_under_noise",
    "costs_of",
    "declines",
    "difference",
    "draw_suite",
    "entrants_of",
    "get_method",
    "hash_of",
    "hierarchical",
    "holm",
    "log_of",
    "beyond_chance",
    "mcnemar",
    "measured",
    "noise_episodes",
    "pairs",
    "stratified",
    "suite_file",
    "suite_names",
    "under_noise",
    "verdict",
    "warmed",
    "who",
    "wilson",
]
