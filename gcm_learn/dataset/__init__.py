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

from gcm_learn.dataset.cases import planner_of
from gcm_learn.dataset.cells import WINDOW, Example, MapCache
from gcm_learn.dataset.folder import Folder
from gcm_learn.dataset.generation import Estimate, estimate, generate
from gcm_learn.dataset.item import make_item, quantities_of, warm_up
from gcm_learn.dataset.kinds import kind_of_version
from gcm_learn.dataset.manifest import Manifest, faults_of, survey
from gcm_learn.dataset.reader import Dataset
from gcm_learn.dataset.reader import open_dataset as open
from gcm_learn.dataset.record import Record
from gcm_learn.dataset.shards import make_shard, uncollected
from gcm_learn.dataset.spec import (
    DatasetSpec,
    FamilyShare,
    read_spec,
    spec_from_json,
    spec_to_json,
)
from gcm_learn.dataset.splits import Holdout, Split
from gcm_learn.dataset.verifying import verify_dataset

__all__ = [
    "Dataset",
    "DatasetSpec",
    "Estimate",
    "Example",
    "FamilyShare",
    "Folder",
    "Holdout",
    "Manifest",
    "MapCache",
    "Record",
    "Split",
    "WINDOW",
    "estimate",
    "faults_of",
    "generate",
    "kind_of_version",
    "make_item",
    "make_shard",
    "open",
    "planner_of",
    "quantities_of",
    "read_spec",
    "spec_from_json",
    "spec_to_json",
    "survey",
    "uncollected",
    "verify_dataset",
    "warm_up",
]
