"""Small specifications, and a small dataset that many tests read."""

from __future__ import annotations

from dataclasses import replace

import pytest

pytest.importorskip("pyarrow")

from gcm_learn import dataset
from gcm_learn.dataset import DatasetSpec, FamilyShare
from gcm_learn.dataset.folder import Folder
from gcm_learn.dataset.manifest import manifest_of, write_manifest
from gcm_learn.dataset.shards import make_shard

SMALL = DatasetSpec(
    name="small",
    seed=3,
    count=50,
    families=(FamilyShare("random-planar"),),
    planners=("marching", "layered"),
    map="marching",
    n=40,
    rungs=2,
    shard_size=20,
)


@pytest.fixture
def small() -> DatasetSpec:
    """Return a specification of 50 items in three shards, quick to make."""
    return SMALL


def make_here(spec: DatasetSpec, folder: str) -> None:
    """Make a dataset in this process."""
    place = Folder(folder)
    place.make()
    infos = {shard: make_shard(spec, shard, folder) for shard in range(spec.shards)}
    write_manifest(place, manifest_of(place, spec, infos, []))


@pytest.fixture(scope="session")
def small_folder(tmp_path_factory) -> str:
    """Return the folder of a dataset that no test changes."""
    folder = str(tmp_path_factory.mktemp("small"))
    make_here(replace(SMALL, audit=0.1), folder)
    return folder


@pytest.fixture
def records(small_folder):
    """Return the records of that dataset."""
    return dataset.open(small_folder)
