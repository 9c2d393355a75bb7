"""Memory: catches that are kept, found again from a new situation alone, and bent to it.

>>> from gcm_learn.recall import Memory, RawIndex, RecallPlanner, trace_of
>>> memory = Memory(RawIndex.fit(situations))                         # doctest: +SKIP
>>> memory.add(situations, [trace_of(s, p) for s, p in zip(situations, plans)])  # doctest: +SKIP
>>> RecallPlanner(memory).plan(another)                               # doctest: +SKIP
"""

from gcm_learn.recall.adaptation import Adaptation, adapt, transfer
from gcm_learn.recall.encoder_config import EncoderConfig
from gcm_learn.recall.encoder_files import load_encoder, save_encoder
from gcm_learn.recall.growth import Coverage, Curve, grow
from gcm_learn.recall.index import Index, RandomIndex, RawIndex, index_class
from gcm_learn.recall.planners import (
    HybridPlanner,
    RecallPlanner,
    Recollection,
    Rollout,
    SplinesPlanner,
    unverified,
)
from gcm_learn.recall.store import Entry, Memory
from gcm_learn.recall.towers import Encoder
from gcm_learn.recall.waypoints import Trace, path_of, trace_of

__all__ = [
    "Adaptation",
    "Coverage",
    "Curve",
    "Encoder",
    "EncoderConfig",
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
    "load_encoder",
    "path_of",
    "save_encoder",
    "trace_of",
    "transfer",
    "unverified",
]
