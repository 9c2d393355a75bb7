"""What training and other libraries read: the same maps and labels as the records."""

import pickle
import shutil

import numpy as np
import pytest

from gcm_learn import dataset
from gcm_learn.dataset.reader import Dataset
from gcm_learn.errors import DatasetError


def test_the_cache_holds_what_the_records_hold(records, tmp_path):
    part = records[7:40].where(stratum=("L", "U"))
    cache = part.cache(tmp_path, labels=("stratum", "index"))
    assert len(cache) == len(part)
    for k in (0, 3, len(part) - 1):
        example, record = cache[k], part[k]
        assert example.index == record.index == example.labels["index"]
        assert example.labels["stratum"] == record.stratum
        np.testing.assert_array_equal(example.arrival, record.counts)
        assert example.quantum == record.row["quantum"]
        assert example.horizon == record.situation.horizon
    again = pickle.loads(pickle.dumps(cache))
    np.testing.assert_array_equal(again[2].arrival, cache[2].arrival)
    np.testing.assert_array_equal(cache[1:4][1].arrival, cache[2].arrival)


def test_the_picture_is_the_map(records, tmp_path):
    for k, example in enumerate(records.cache(tmp_path)[:10]):
        made, image = records[k].map, example.image()
        assert image.dtype == np.float32 and 0.0 <= image.min() and image.max() <= 1.0
        np.testing.assert_array_equal(image[0] == 1.0, ~made.arrival.mask)
        arrival = made.arrival.filled(0.0) / records[k].situation.horizon
        np.testing.assert_allclose(image[1], arrival, atol=1e-6)
        np.testing.assert_array_equal(image[2] == 1.0, made.effective_obstacles)


def test_the_cache_is_built_once_and_for_all_parts(records, tmp_path, monkeypatch):
    first = records[:5].cache(tmp_path)
    monkeypatch.setattr("gcm_learn.dataset.reader.build_cache", None)
    assert records[20:].cache(tmp_path).folder == first.folder
    assert [p.name for p in tmp_path.iterdir()] == [first.folder.name]


def test_no_maps_no_cache(records, monkeypatch):
    monkeypatch.setattr(Dataset, "folder", records.folder)
    object.__setattr__(records.spec, "map", "none")
    try:
        with pytest.raises(DatasetError, match="no maps"):
            records.cache()
    finally:
        object.__setattr__(records.spec, "map", "marching")


def test_a_stream_gives_every_map_once_in_a_seeded_order(records):
    part = records.where(index=lambda index: index % 3 != 1)
    runs = {
        key: [e.index for e in part.stream(*key, window=8, labels=("split",))]
        for key in ((0, 0), (0, 1), (1, 0))
    }
    indices = list(part.column("index"))
    for order in runs.values():
        assert sorted(order) == indices and order != indices
    assert len({tuple(order) for order in runs.values()}) == 3
    assert [e.index for e in part.stream(0, 0, window=8)] == runs[0, 0]
    example = next(iter(part.stream(labels=("split",))))
    record = records[example.index]
    assert example.labels == {"split": record.split}
    np.testing.assert_array_equal(example.arrival, record.counts)


def test_a_wide_window_mixes_everything(records):
    places = np.zeros((50, 50))
    for seed in range(200):
        for place, example in enumerate(records.stream(seed, window=50)):
            places[example.index, place // 10] += 1
    counts = places[:, :5]  # how often each record came in each fifth of the stream
    assert counts.sum() == 200 * 50
    assert abs(counts - 40).max() < 5 * (40 * 0.8) ** 0.5


def test_parts_of_a_stream_are_the_whole(records):
    seen = [e.index for i in range(4) for e in records.stream(5, part=(i, 4), window=5)]
    assert sorted(seen) == list(range(50))


@pytest.fixture
def torch_data():
    pytest.importorskip("torch")
    from gcm_learn.dataset import torch_data

    return torch_data


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:This DataLoader will create")
@pytest.mark.parametrize(("workers", "persistent"), [(1, False), (3, True)])
def test_torch_streams_every_map_once_with_workers(workers, persistent, records, torch_data):
    import torch
    from torch.utils.data import DataLoader

    def passes():
        loader = DataLoader(
            torch_data.TorchStream(records, 4, window=16), batch_size=8, num_workers=workers,
            persistent_workers=persistent, multiprocessing_context="spawn",
            generator=torch.Generator().manual_seed(0),
        )  # fmt: skip
        return [[int(k) for batch in loader for k in batch["index"]] for _ in range(2)]

    first, second = passes()
    assert sorted(first) == sorted(second) == list(range(50)) and first != second
    assert passes() == [first, second]


def test_torch_streams_are_other_orders_in_every_epoch(records, torch_data):
    feed = torch_data.TorchStream(records, 4, window=16)
    first, second = ([item["index"] for item in feed] for _ in range(2))
    assert sorted(first) == sorted(second) == list(range(50)) and first != second
    again = torch_data.TorchStream(records, 4, window=16)
    assert [item["index"] for item in again] == first


def test_a_copied_folder_has_its_own_cache(records, tmp_path):
    folder = shutil.copytree(records.folder.url, tmp_path / "copy", ignore=lambda *_: {"cache"})
    copy = dataset.open(folder)
    assert copy.cache().folder.is_relative_to(folder)
    np.testing.assert_array_equal(copy.cache()[3].arrival, records[3].counts)


def test_caches_of_the_shipped_sample_are_the_users(records, tmp_path, monkeypatch):
    """So reading it leaves nothing beside it; neither does what cannot be written to."""
    monkeypatch.setattr("gcm_learn.dataset.folder.user_cache", lambda name: tmp_path / name)
    monkeypatch.setattr("gcm_learn.dataset.folder._is_sample", lambda folder: True)
    assert records.cache().folder.parent == tmp_path / "maps"
    monkeypatch.undo()
    monkeypatch.setattr("gcm_learn.dataset.folder.user_cache", lambda name: tmp_path / name)
    monkeypatch.setattr("gcm_learn.dataset.folder.os.access", lambda *asked: False)
    assert records.cache().folder.parent == tmp_path / "maps"


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
