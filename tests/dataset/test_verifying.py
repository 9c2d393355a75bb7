"""The check finds what is wrong with a dataset, and nothing where nothing is."""

import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from gcm_learn.cli import main
from gcm_learn.dataset import spec_to_json
from gcm_learn.dataset.folder import Folder
from gcm_learn.dataset.item import make_item
from gcm_learn.dataset.record import Record, rows_of
from gcm_learn.dataset.shards import KEY, shard_name, write_shard
from gcm_learn.dataset.verifying import verify_dataset
from tests.dataset.conftest import SMALL
from tests.dataset.test_generation import Noting


@pytest.fixture(autouse=True)
def _here(monkeypatch):
    monkeypatch.setattr("gcm_learn.dataset.generation.LocalCrew", Noting)


@pytest.fixture
def folder(small_folder, tmp_path):
    """Return a copy of the small dataset, to be spoiled."""
    return Path(shutil.copytree(small_folder, tmp_path / "copy"))


def test_changed_bytes_and_missing_shards_are_found(folder):
    path = folder / shard_name(1)
    content = bytearray(path.read_bytes())
    content[len(content) // 3] ^= 1
    path.write_bytes(content)
    assert shard_name(1) in verify_dataset(folder).quoted[0]
    path.unlink()
    assert "shard-000001" in verify_dataset(folder).quoted[0]


def spoiled(spec, shard, folder, change):
    """Write a shard whose items have been changed, and say so in the manifest."""
    items = [make_item(spec, k) for k in spec.indices(shard)]
    write_shard(spec, shard, [change(item) for item in items], str(folder))
    manifest = json.loads((folder / "manifest.json").read_text())
    manifest["shards"][shard]["sha256"] = Folder(folder).sha256(shard_name(shard))
    (folder / "manifest.json").write_text(json.dumps(manifest))


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (lambda way: replace(way, path=way.hand + 1e-6 * (way.time[:, None] > 0)), None),
        (lambda way: replace(way, path=way.hand * 0.9), "does not start at the hand"),
        (lambda way: replace(way, time=way.time * 0.999), "does not end at the catch"),
        (
            lambda way: replace(way, time=np.append(0.5 * way.time[:-1], way.time[-1])),
            "faster than max_hand_speed",
        ),
        (lambda way: replace(way, path=np.vstack([way.hand[:-1], way.hand[:1]])), "hold"),
    ],
)
def test_plans_that_do_not_hold_are_found(folder, spoil, said):
    spec = replace(SMALL, audit=0.1)

    def change(record):
        plan = record.plans["layered"]
        if not plan.caught or plan.catch_time < 0.05:
            return record
        worse = replace(plan, trajectory=spoil(plan.trajectory))
        return Record(spec, record.values | {"plans": record.plans | {"layered": worse}})

    spoiled(spec, 0, folder, change)
    report = verify_dataset(folder)
    assert report.faults > 3 or said is None
    if said is not None:
        assert any(said in fault for fault in report.quoted)


def test_an_item_that_would_be_made_differently_is_found(folder):
    spec = replace(SMALL, audit=0.1)
    spoiled(spec, 0, folder, lambda record: Record(spec, record.values | {"stratum": "L"}))
    assert any("made differently" in fault for fault in verify_dataset(folder).quoted)


def test_the_command_makes_checks_and_tells(tmp_path, capsys):
    spec = tmp_path / "spec.json"
    spec.write_text(json.dumps(spec_to_json(SMALL)))
    out = str(tmp_path / "out")
    assert main(["generate", str(spec), "--out", out, "--verify", "--workers", "1"]) == 0
    said = capsys.readouterr().out
    assert "50 records" in said and "verified 50 records" in said and "0 faults" in said
    path = Path(out) / shard_name(0)
    table = pq.read_table(path)
    pq.write_table(table, path)
    assert table.schema.metadata[KEY]
    assert main(["generate", str(spec), "--out", out, "--verify", "--workers", "1"]) == 1
    assert "bytes, the manifest says" in capsys.readouterr().err


def test_the_command_refuses(tmp_path, capsys):
    spec, out = tmp_path / "spec.json", tmp_path / "out"
    for text, options, said in (
        (json.dumps(spec_to_json(SMALL)), ["--workers", "0"], "--workers 0"),
        (json.dumps(spec_to_json(SMALL)), ["--shards", "4/4"], "--shards 4/4"),
        (json.dumps(spec_to_json(SMALL)), ["--shards", "x"], "--shards x"),
        ("{}", [], "format: must be"),
    ):
        spec.write_text(text)
        assert main(["generate", str(spec), "--out", str(out), *options]) == 2
        told = capsys.readouterr().err
        assert said in told and told.count("\n") == 1 and not out.exists()


def test_rows_do_not_depend_on_their_neighbours(small):
    one, both = make_item(small, 5), [make_item(small, k) for k in (4, 5)]
    assert rows_of(small, [one]).equals(rows_of(small, both).slice(1))
