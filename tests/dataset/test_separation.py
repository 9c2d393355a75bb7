"""Twins are found and left out; the distance of test and training records is what it is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gcm_learn import dataset
from gcm_learn.dataset import DatasetSpec, FamilyShare, Holdout, Split, generation
from gcm_learn.dataset.folder import Folder
from gcm_learn.dataset.generation import distance_of, twins_of
from gcm_learn.dataset.item import make_item
from gcm_learn.dataset.record import Record
from gcm_learn.dataset.shards import make_shard, shard_name, write_shard
from gcm_learn.dataset.spec import DatasetSpec as Spec
from tests.dataset.test_generation import Noting

MIXED = DatasetSpec(
    "mixed", seed=5, count=60, planners=("layered",), map="none", n=40, rungs=1, shard_size=30,
    families=(
        FamilyShare("moving-point", config={"obstacles": [1, 1]}),
        FamilyShare("random-planar", config={"obstacles": [0, 2]}), FamilyShare("gate"),
    ),
    split=Split(validation=0.2, test=0.3), holdouts=(Holdout("test-gate", family="gate"),),
)  # fmt: skip


@pytest.fixture(scope="module")
def mixed(tmp_path_factory) -> tuple[Spec, str]:
    """Return a dataset of a few families, one of them held out."""
    folder = str(tmp_path_factory.mktemp("mixed"))
    patch = pytest.MonkeyPatch()
    patch.setattr(generation, "LocalCrew", Noting)
    generation.generate(MIXED, folder)
    patch.undo()
    return MIXED, folder


def test_a_family_that_is_held_out_is_nowhere_else(mixed):
    records = dataset.open(mixed[1])
    held = records.where(split="test-gate")
    assert len(held) > 5 and set(held.column("family")) == {"gate"}
    rest = records.where(split=("train", "validation", "test"))
    assert "gate" not in rest.column("family") and len(held) + len(rest) == len(records)


def test_the_distance_is_the_smallest_of_all_pairs(mixed):
    records = dataset.open(mixed[1])
    told = records.manifest["distance"]
    pairs = {}
    tests = [r for r in records if r.split.startswith("test")]
    for test in tests:
        for other in records.where(split="train", structure=test.row["structure"]):
            away = np.linalg.norm(test.parameters.astype(float) - other.parameters)
            pairs[test.index, other.index] = away
    assert told["smallest"] == pytest.approx(min(pairs.values()), abs=1e-5)
    assert tuple(told["pair"]) == min(pairs, key=pairs.get)
    assert told["comparable"] == len({test for test, _ in pairs}) > 3
    assert told["test_records"] == told["measured"] == len(tests)


def test_twins_are_left_out(mixed, tmp_path):
    spec = replace(mixed[0], count=30, shard_size=10)
    folder = Folder(tmp_path)
    folder.make()
    for shard in (0, 1):
        make_shard(spec, shard, str(tmp_path))
    items = [make_item(spec, k) for k in spec.indices(2)]
    items[4] = Record(spec, make_item(spec, 3).values | {"index": items[4].index})
    items[7] = Record(spec, make_item(spec, 12).values | {"index": items[7].index})
    write_shard(spec, 2, items, str(tmp_path))
    names = [shard_name(k) for k in range(3)]
    assert twins_of(folder, names) == [24, 27]
    assert twins_of(folder, names[:2]) == []
    manifest = generation.generate(spec, tmp_path)
    assert manifest["twins"] == {"removed": [24, 27]}
    records = dataset.open(tmp_path)
    assert len(records) == 28 and not {24, 27} & set(records.column("index"))


def test_a_twin_in_the_test_split_would_be_at_distance_zero(mixed, tmp_path):
    spec = replace(mixed[0], count=30, shard_size=30)
    folder = Folder(tmp_path)
    folder.make()
    items = [make_item(spec, k) for k in spec.indices(0)]
    twin = next(k for k, item in enumerate(items) if item.split == "test")
    train = next(k for k, item in enumerate(items) if item.split == "train")
    items[twin] = Record(spec, items[train].values | {"index": twin, "split": "test"})
    write_shard(spec, 0, items, str(tmp_path))
    names = [shard_name(0)]
    assert distance_of(folder, spec, names, [])["smallest"] == 0.0
    assert distance_of(folder, spec, names, [twin])["smallest"] > 0.0


def test_what_is_measured_is_measured_once(mixed, monkeypatch):
    monkeypatch.setattr(generation, "distance_of", None)
    manifest = generation.generate(mixed[0], mixed[1])
    assert manifest["distance"]["smallest"] > 0.0
