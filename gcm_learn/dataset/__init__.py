"""Datasets: situations by the thousand with their maps, plans and labels.

>>> from gcm_learn import dataset
>>> spec = dataset.read_spec("spec.toml")      # doctest: +SKIP
>>> dataset.generate(spec, "data/mine")        # doctest: +SKIP
>>> hard = dataset.open("data/mine").where(stratum="Q")  # doctest: +SKIP
"""

try:
    import pyarrow as _pyarrow  # noqa: F401
except ImportError as _error:  # pragma: no cover - depends on what is installed
    raise ImportError(
        "gcm_learn.dataset needs pyarrow and fsspec: pip install 'gcm_learn[data]'"
    ) from _error

from gcm_learn.dataset.cases import planner_of as planner_of
from gcm_learn.dataset.cells import WINDOW as WINDOW, Example as Example, MapCache as MapCache
from gcm_learn.dataset.folder import Folder as Folder
from gcm_learn.dataset.generation import (
    Estimate as Estimate,
    estimate as estimate,
    generate as generate,
)
from gcm_learn.dataset.item import (
    make_item as make_item,
    quantities_of as quantities_of,
    warm_up as warm_up,
)
from gcm_learn.dataset.kinds import kind_of_version as kind_of_version
from gcm_learn.dataset.manifest import (
    Manifest as Manifest,
    faults_of as faults_of,
    survey as survey,
)
from gcm_learn.dataset.reader import Dataset as Dataset, open_dataset
from gcm_learn.dataset.record import Record as Record
from gcm_learn.dataset.shards import make_shard as make_shard, uncollected as uncollected
from gcm_learn.dataset.spec import (
    DatasetSpec as DatasetSpec,
    FamilyShare as FamilyShare,
    read_spec as read_spec,
    spec_from_json as spec_from_json,
    spec_to_json as spec_to_json,
)
from gcm_learn.dataset.splits import Holdout as Holdout, Split as Split
from gcm_learn.dataset.verifying import verify_dataset as verify_dataset

open = open_dataset
