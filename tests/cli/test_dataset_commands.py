"""``gcm-learn inspect`` and ``gallery`` on a small dataset."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest

pytest.importorskip("pyarrow")

from gcm_learn import dataset
from gcm_learn.cli import main
from gcm_learn.dataset.folder import Folder
from gcm_learn.dataset.shards import make_shard
from tests.dataset.conftest import SMALL, make_here


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> str:
    """Return a finished dataset."""
    path = str(tmp_path_factory.mktemp("finished"))
    make_here(replace(SMALL, audit=0.1), path)
    return path


def test_inspect_tells_what_the_manifest_says(folder, capsys):
    assert main(["inspect", folder]) == 0
    said = capsys.readouterr().out
    manifest = dataset.open(folder).manifest
    assert "small: 50 records, complete" in said and manifest["hash"] in said
    row = re.search(r"^all +50 (.*)$", said, re.M)[1]
    told = [float(share.rstrip("%")) for share in row.split()]
    assert told == pytest.approx([2 * n for n in manifest["strata"].values()])
    assert f"{manifest['rejected'].get('blocked', 0)}" in said


def test_inspect_tells_of_one_under_way(tmp_path, capsys):
    Folder(tmp_path).make()
    for shard in (0, 2):
        make_shard(SMALL, shard, str(tmp_path))
    assert main(["inspect", str(tmp_path)]) == 0
    assert "30 records, 30 of 50" in capsys.readouterr().out
    assert not (tmp_path / "manifest.json").exists()


@pytest.mark.parametrize("command", ["inspect", "gallery"])
def test_no_dataset_is_said_in_one_line(command, tmp_path, capsys):
    assert main([command, str(tmp_path / "nothing")]) == 2
    stdout, stderr = capsys.readouterr()
    assert stdout == "" and stderr.count("\n") == 1 and "holds no dataset" in stderr


def test_gallery_shows_every_stratum_that_is_there(folder, tmp_path, capsys):
    out = tmp_path / "page"
    assert main(["gallery", folder, "--out", str(out), "--each", "2"]) == 0
    assert (out / "index.html").as_uri() in capsys.readouterr().out
    there = set(dataset.open(folder).column("stratum"))
    assert {p.stem for p in out.glob("*.png")} == there
    page = (out / "index.html").read_text()
    for stratum in there:
        assert f'src="{stratum}.png"' in page and (out / f"{stratum}.png").stat().st_size > 5000
    assert main(["gallery", folder, "--split", "nothing", "--out", str(out)]) == 2
