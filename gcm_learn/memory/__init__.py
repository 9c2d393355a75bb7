"""Memory: catches that are kept, found again from a new situation alone, and bent to it.

>>> from gcm_learn.memory import Memory, RawIndex, RecallPlanner, trace_of
>>> memory = Memory(RawIndex.fit(situations))                         # doctest: +SKIP
>>> memory.add(situations, [trace_of(s, p) for s, p in zip(situations, plans)])  # doctest: +SKIP
>>> RecallPlanner(memory).plan(another)                               # doctest: +SKIP
"""

from gcm_learn.memory.adaptation import Adaptation, adapt, transfer
from gcm_learn.memory.growth import Coverage, Curve, grow
from gcm_learn.memory.index import Index, RandomIndex, RawIndex, index_class
from gcm_learn.memory.planners import (
    HybridPlanner,
    RecallPlanner,
    Recollection,
    Rollout,
    SplinesPlanner,
    unverified,
)
from gcm_learn.memory.store import Entry, Memory
from gcm_learn.memory.traces import Trace, path_of, trace_of

__all__ = [
    "Adaptation",
    "Coverage",
    "Curve",
    "Entry",
    "HybridPlanner",
    "Index",
    "Memory",
    "RandomIndex",
    "RawIndex",
    "RecallPlanner",
    "Recollection",
    "Rollout",
    "SplinesPlanner",
    "Trace",
    "adapt",
    "grow",
    "index_class",
    "path_of",
    "trace_of",
    "transfer",
    "unverified",
]
