"""Memory: stored catches, found by a new situation alone and adapted to that situation.

>>> from gcm_learn.recall import Memory, RawIndex, RecallPlanner, waypoints_of
>>> memory = Memory(RawIndex.fit(situations))                         # doctest: +SKIP
>>> memory.add([situation], [waypoints_of(situation, plan)])           # doctest: +SKIP
>>> RecallPlanner(memory).plan(another)                               # doctest: +SKIP
"""

from typing import TYPE_CHECKING

from gcm_learn import late
from gcm_learn.recall.adaptation import (
    Adaptation as Adaptation,
    adapt as adapt,
    transfer as transfer,
)
from gcm_learn.recall.clusters import (
    ASKED as ASKED,
    Clusters as Clusters,
    CrossTries as CrossTries,
    cluster as cluster,
    cross_tries as cross_tries,
)
from gcm_learn.recall.embedding import (
    embed as embed,
    map_encoder as map_encoder,
    nearest as nearest,
)
from gcm_learn.recall.encoder import (
    CONFIG as CONFIG,
    Encoder as Encoder,
    EncoderConfig as EncoderConfig,
    load_encoder as load_encoder,
    save_encoder as save_encoder,
)
from gcm_learn.recall.features import Sizes as Sizes
from gcm_learn.recall.files import MANIFEST as MANIFEST, is_memory as is_memory
from gcm_learn.recall.growth import remember as remember
from gcm_learn.recall.index import (
    Index as Index,
    LearnedIndex as LearnedIndex,
    PcaIndex as PcaIndex,
    RandomIndex as RandomIndex,
    RawIndex as RawIndex,
    index_class as index_class,
    nearest_rows as nearest_rows,
)
from gcm_learn.recall.kinds import (
    MEMORIES as MEMORIES,
    raw_features as raw_features,
    waypoints_of as waypoints_of,
)
from gcm_learn.recall.planners import (
    HybridPlanner as HybridPlanner,
    RecallPlanner as RecallPlanner,
    Recollection as Recollection,
    Rollout as Rollout,
    SplinesPlanner as SplinesPlanner,
    has_memory as has_memory,
    shipped_memory as shipped_memory,
    unverified as unverified,
    with_memory as with_memory,
)
from gcm_learn.recall.raw_features import Scale as Scale
from gcm_learn.recall.store import Entry as Entry, Memory as Memory
from gcm_learn.recall.waypoints import (
    Waypoints as Waypoints,
    passing_of as passing_of,
    path_of as path_of,
)

if TYPE_CHECKING:
    from gcm_learn.recall.training import (
        Effort as Effort,
        Trainer as Trainer,
        write_model as write_model,
    )
    from gcm_learn.recall.transfer_labels import (
        Best as Best,
        TransferLabels as TransferLabels,
        ValidMemories as ValidMemories,
    )

# Loaded when they are asked for: they need pyarrow or torch.
__getattr__ = late.late_names(
    __name__,
    {
        "training": ("Effort", "Trainer", "write_model"),
        "transfer_labels": ("Best", "TransferLabels", "ValidMemories"),
    },
)
