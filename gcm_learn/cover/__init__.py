"""Covers: stored catches with proven cells, for families of situations with few parameters."""

from gcm_learn.cover.catches import (
    Doubt as Doubt,
    StoredCatch as StoredCatch,
    doubt_of as doubt_of,
    planned as planned,
)
from gcm_learn.cover.cover import (
    Cell as Cell,
    Cover as Cover,
    is_cover as is_cover,
    load_cover as load_cover,
)
from gcm_learn.cover.families import (
    FAMILIES as FAMILIES,
    Parameter as Parameter,
    ParametricFamily as ParametricFamily,
    parametric_family as parametric_family,
)
from gcm_learn.cover.growth import (
    BATCH as BATCH,
    Budget as Budget,
    Finding as Finding,
    Question as Question,
    broken_of as broken_of,
    draws as draws,
    examine as examine,
    grow as grow,
)
from gcm_learn.cover.planner import (
    NAME as NAME,
    CoveredPlanner as CoveredPlanner,
    covered as covered,
    with_cover as with_cover,
)
