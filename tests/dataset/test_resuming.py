"""A dataset that an older version left half made is taken up, and becomes the same."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from gcm_learn import dataset
from gcm_learn.dataset.folder import Folder
from gcm_learn.dataset.shards import code_version, header_of, read_columns, shard_name
from tests.dataset.test_generation import Noting

OLD = Path(__file__).parent / "data" / "half-made"
"""Four shards that an earlier version of the code made in one go."""
THERE = (0, 1)
MISSING = (2, 3)
NEWER = ["plan_layered"]  # what a planner answers that has changed since


@pytest.fixture
def half_made(tmp_path, monkeypatch) -> Path:
    """Return a folder with the first two shards."""
    monkeypatch.setattr("gcm_learn.dataset.generation.LocalCrew", Noting)
    monkeypatch.setattr(Noting, "made", [])
    (tmp_path / "shards").mkdir()
    for shard in THERE:
        shutil.copy(OLD / shard_name(shard), tmp_path / shard_name(shard))
    return tmp_path


def test_shards_of_older_code_are_kept_and_the_rest_is_made(half_made):
    spec = dataset.read_spec(OLD / "spec.toml")
    told = []
    manifest = dataset.generate(spec, half_made, progress=told.append)
    assert tuple(Noting.made) == MISSING and told == [4, 2, 2]
    assert manifest["complete"] and manifest["records"] == spec.count and not manifest["failed"]
    (older,) = {header_of(Folder(OLD), shard_name(k))["info"]["code"] for k in THERE}
    assert manifest["code"] == {older: 2, code_version(): 2}
    assert dataset.verify_dataset(half_made).faults == 0
    assert [record.index for record in dataset.open(half_made)] == list(range(spec.count))


def test_what_is_resumed_is_what_is_made_in_one_go(half_made):
    dataset.generate(dataset.read_spec(OLD / "spec.toml"), half_made)
    for shard in (*THERE, *MISSING):
        old, new = (read_columns(Folder(f), shard_name(shard)) for f in (OLD, half_made))
        assert new.column_names == old.column_names
        both = [table.drop_columns(NEWER).replace_schema_metadata(None) for table in (old, new)]
        assert both[0].equals(both[1])
        before, after = (header_of(Folder(f), shard_name(shard)) for f in (OLD, half_made))
        assert after | {"info": after["info"] | {"code": ""}} == before | {
            "info": before["info"] | {"code": ""}
        }
    for shard in THERE:
        content = [(folder / shard_name(shard)).read_bytes() for folder in (OLD, half_made)]
        assert content[0] == content[1]
