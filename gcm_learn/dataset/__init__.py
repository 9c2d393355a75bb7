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

from gcm_learn.dataset.generation import generate
from gcm_learn.dataset.reader import Dataset
from gcm_learn.dataset.reader import open_dataset as open
from gcm_learn.dataset.record import Record
from gcm_learn.dataset.spec import DatasetSpec, FamilyShare, spec_to_json
from gcm_learn.dataset.spec_file import read_spec, spec_from_json
from gcm_learn.dataset.splits import Holdout, Split

__all__ = [
    "Dataset",
    "DatasetSpec",
    "FamilyShare",
    "Holdout",
    "Record",
    "Split",
    "generate",
    "open",
    "read_spec",
    "spec_from_json",
    "spec_to_json",
]
