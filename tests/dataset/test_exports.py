"""Other libraries get the same records."""

from __future__ import annotations

import numpy as np
import pytest

from gcm_learn import dataset


def test_hugging_face_loads_the_shards(records, tmp_path):
    datasets = pytest.importorskip("datasets")
    loaded = datasets.load_dataset(
        "parquet", data_files=records.files, split="train", cache_dir=str(tmp_path)
    )
    assert len(loaded) == 50 and set(loaded.column_names) == set(records.table().column_names)
    for k in (0, 27):
        row, record = loaded[k], records[k]
        assert row["index"] == record.index and row["stratum"] == record.stratum
        np.testing.assert_array_equal(np.frombuffer(row["arrival"], "<u2"), record.counts.ravel())
        path = record.plans["layered"].trajectory
        assert row["plan_layered"]["time"] == (None if path is None else path.time.tolist())


def test_pandas_gets_the_labels(records):
    pytest.importorskip("pandas")
    frame = dataset.open(records.folder.url).where(stratum="L").to_pandas(["index", "upper_arm"])
    assert list(frame.columns) == ["index", "upper_arm"]
    assert frame["upper_arm"].between(0.8, 1.2).all() and len(frame) > 5
