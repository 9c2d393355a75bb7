"""Comparison: any planners and policies on the same situations, with paired statistics."""

from gcm_learn.evaluation.contest import compare
from gcm_learn.evaluation.suites import Entry, draw_suite, suite_names
from gcm_learn.evaluation.table import Results

__all__ = ["Entry", "Results", "compare", "draw_suite", "suite_names"]
