"""Covers: stored catches with proven cells, for families of situations with few parameters."""

from gcm_learn.cover.catches import Doubt, StoredCatch, doubt_of, planned
from gcm_learn.cover.cover import Cell, Cover, is_cover, load_cover
from gcm_learn.cover.families import FAMILIES, Parameter, ParametricFamily, parametric_family
from gcm_learn.cover.growth import BATCH, Budget, Finding, Question, broken_of, draws, examine, grow
from gcm_learn.cover.planner import NAME, CoveredPlanner, covered, with_cover

__all__ = [
    "BATCH",
    "Budget",
    "Cell",
    "Cover",
    "CoveredPlanner",
    "Doubt",
    "FAMILIES",
    "Finding",
    "NAME",
    "Parameter",
    "ParametricFamily",
    "Question",
    "StoredCatch",
    "broken_of",
    "covered",
    "doubt_of",
    "draws",
    "examine",
    "grow",
    "is_cover",
    "load_cover",
    "parametric_family",
    "planned",
    "with_cover",
]
