"""Memory: catches that are kept, found again from a new situation alone, and adapted to it.

>>> from gcm_learn.recall import Memory, RawIndex, RecallPlanner, waypoints_of
>>> memory = Memory(RawIndex.fit(situations))                         # doctest: +SKIP
>>> memory.add([situation], [waypoints_of(situation, plan)])           # doctest: +SKIP
>>> RecallPlanner(memory).plan(another)                               # doctest: +SKIP
"""

from typing import TYPE_CHECKING

from gcm_learn.late import late_names
from gcm_learn.recall.adaptation import Adaptation, adapt, transfer
from gcm_learn.recall.encoder import CONFIG, Encoder, EncoderConfig, load_encoder, save_encoder
from gcm_learn.recall.features import map_picture
from gcm_learn.recall.files import MANIFEST, is_memory
from gcm_learn.recall.growth import remember
from gcm_learn.recall.index import (
    Index,
    LearnedIndex,
    PcaIndex,
    RandomIndex,
    RawIndex,
    index_class,
    nearest_rows,
)
from gcm_learn.recall.kinds import MEMORIES, raw_features, waypoints_of
from gcm_learn.recall.lessons import Sizes
from gcm_learn.recall.planners import (
    HybridPlanner,
    RecallPlanner,
    Recollection,
    Rollout,
    SplinesPlanner,
    has_memory,
    shipped_memory,
    unverified,
    with_memory,
)
from gcm_learn.recall.raw_features import Scale
from gcm_learn.recall.store import Entry, Memory
from gcm_learn.recall.waypoints import Waypoints, passing, passing_of, path_of, ring_share

if TYPE_CHECKING:
    from gcm_learn.recall.training import Effort, Trainer, write_model
    from gcm_learn.recall.transfer_labels import Best, Labels, TransferLabels

# Loaded when they are asked for: they need pyarrow or torch.
__getattr__ = late_names(
    __name__,
    {
        "training": ("Effort", "Trainer", "write_model"),
        "transfer_labels": ("Best", "Labels", "TransferLabels"),
    },
)

__all__ = [
    "Adaptation",
    "Best",
    "CONFIG",
    "Effort",
    "Encoder",
    "EncoderConfig",
    "Entry",
    "HybridPlanner",
    "Index",
    "Labels",
    "LearnedIndex",
    "MANIFEST",
    "MEMORIES",
    "Memory",
    "PcaIndex",
    "RandomIndex",
    "RawIndex",
    "RecallPlanner",
    "Recollection",
    "Rollout",
    "Scale",
    "SplinesPlanner",
    "Trainer",
    "Sizes",
    "TransferLabels",
    "Waypoints",
    "adapt",
    "has_memory",
    "index_class",
    "is_memory",
    "load_encoder",
    "map_picture",
    "nearest_rows",
    "passing",
    "passing_of",
    "path_of",
    "raw_features",
    "remember",
    "ring_share",
    "save_encoder",
    "shipped_memory",
    "transfer",
    "unverified",
    "waypoints_of",
    "with_memory",
    "write_model",
]
