"""``gcm-learn inspect``: datasets, models and arms, in numbers and pictures."""

from __future__ import annotations

import json
import re
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

pytest.importorskip("pyarrow")

from gcm_learn import dataset
from gcm_learn.cli import main
from gcm_learn.cli.generate import _hint
from gcm_learn.cli.inspect import per_second
from gcm_learn.dataset.folder import Folder
from gcm_learn.dataset.shards import make_shard, shard_name
from gcm_learn.errors import DatasetError
from gcm_learn.processes import Here
from gcm_learn.recall import Memory, RandomIndex
from tests.dataset.conftest import SMALL, make_here

ROOT = Path(__file__).parents[2]


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


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({}, "seed 3, map marching 40 x 40, rungs 2"),
        ({"map": "none"}, "seed 3, no maps, lattices 40 x 40, rungs 2"),
        pytest.param(
            {"map": "none", "families": (dataset.FamilyShare("late-target-space"),)},
            "seed 3, spatial arms, no maps",
            marks=pytest.mark.slow,
        ),
    ],
)
def test_inspect_tells_what_maps_there_are(changes, said, tmp_path, capsys):
    make_here(replace(SMALL, count=1, **changes), str(tmp_path))
    assert main(["inspect", str(tmp_path)]) == 0
    assert f"  {said}\n" in capsys.readouterr().out


def test_a_low_rate_of_acceptance_is_a_hint():
    manifest = {"records": 300, "drawn": 4000, "rejected": {"blocked": 200, "stratum": 3500}}
    said = _hint(manifest)
    assert "7.5% of 4,000 drawn situations were kept" in said and "'stratum'" in said
    assert _hint({**manifest, "drawn": 400}) is None
    assert _hint({"records": 0, "drawn": 0, "rejected": {}}) is None


@pytest.mark.parametrize(
    ("rate", "said"), [(0.586, "0.59/s"), (0.004, "0.004/s"), (9.1, "9.1/s"), (1204.3, "1204/s")]
)
def test_slow_rates_have_digits(rate, said):
    assert per_second(rate) == said


def test_inspect_tells_of_one_under_way(tmp_path, capsys):
    Folder(tmp_path).make()
    for shard in (0, 2):
        make_shard(SMALL, shard, str(tmp_path))
    assert main(["inspect", str(tmp_path)]) == 0
    assert "30 records, 30 of 50" in capsys.readouterr().out
    assert not (tmp_path / "manifest.json").exists()


@pytest.mark.parametrize("manifest", [True, False])
@pytest.mark.parametrize(("left", "said"), [(0, "0 bytes"), (900, "900 bytes"), (None, "missing")])
def test_a_shard_that_is_cut_is_named(folder, tmp_path, capsys, manifest, left, said):
    """By the command, and by who reads it."""
    copy = Path(shutil.copytree(folder, tmp_path / "copy"))
    shard = copy / shard_name(1)
    content = shard.read_bytes()
    shard.unlink()
    if left is not None:
        shard.write_bytes(content[:left])
    if not manifest:
        (copy / "manifest.json").unlink()
    assert main(["inspect", str(copy)]) == (0 if left is None and not manifest else 1)
    out, err = capsys.readouterr()
    if left is not None or manifest:
        assert "small: " in out and err.count("\n") == 1
        assert shard_name(1) in err and (said in err or not manifest)
    if left is not None:
        with pytest.raises(DatasetError, match=f"{shard_name(1)}: not a shard"):
            dataset.open(copy)


def test_a_byte_that_changed_is_found_by_checksums(folder, tmp_path, capsys):
    assert main(["inspect", folder, "--verify"]) == 0
    assert "the bytes of all shards agree with the manifest" in capsys.readouterr().out
    copy = Path(shutil.copytree(folder, tmp_path / "copy"))
    content = bytearray((copy / shard_name(2)).read_bytes())
    content[len(content) // 3] ^= 1
    (copy / shard_name(2)).write_bytes(content)
    assert main(["inspect", str(copy)]) == 0
    capsys.readouterr()
    assert main(["inspect", str(copy), "--verify"]) == 1
    assert f"{shard_name(2)}: its bytes differ from the manifest" in capsys.readouterr().err
    (copy / "manifest.json").unlink()
    assert main(["inspect", str(copy), "--verify"]) == 2
    assert "has no manifest to check it against" in capsys.readouterr().err


def test_no_dataset_is_said_in_one_line(tmp_path, capsys):
    assert main(["inspect", str(tmp_path)]) == 2
    stdout, stderr = capsys.readouterr()
    assert stdout == "" and stderr.count("\n") == 1 and "holds no dataset" in stderr


def test_pictures_show_every_stratum_that_is_there(folder, tmp_path, capsys):
    out = tmp_path / "page"
    assert main(["inspect", folder, "--pictures", str(out), "--each", "2"]) == 0
    assert (out / "index.html").as_uri() in capsys.readouterr().out
    there = set(dataset.open(folder).column("stratum"))
    assert {p.stem for p in out.glob("*.png")} == there
    page = (out / "index.html").read_text()
    for stratum in there:
        assert f'src="{stratum}.png"' in page and (out / f"{stratum}.png").stat().st_size > 5000


MODELS = ROOT / "models"


@pytest.mark.parametrize(
    ("path", "said"),
    [
        (MODELS / "encoder", "an encoder for planar arms, key 72471ed756129e02\n  32 numbers"),
        (MODELS / "clone", "a policy for planar arms, which commands a choice\n  layers of 157,"),
        (MODELS / "recall", "a memory of 3441 catches of planar arms\n  index learned, 32 numbers"),
        (ROOT / "gcm_learn/arms/models/ur5.json", "ur5, 6 joints, 8 capsules"),
    ],
)
def test_models_are_told_apart(path, said, capsys):
    if "encoder" in said or "learned" in said:
        pytest.importorskip("safetensors")
    assert main(["inspect", str(path)]) == 0
    assert said in capsys.readouterr().out
    assert main(["inspect", str(path), "--verify"]) == 2
    assert f"--verify: {path} is no dataset" in capsys.readouterr().err


def test_a_memory_is_shown_as_points(tmp_path, capsys, monkeypatch):
    asked = []

    def write_memory_page(memory, out, *, count):
        asked.append((memory.index.name, len(memory), out, count))
        return out / "index.html"

    monkeypatch.setattr("gcm_learn.plots.write_memory_page", write_memory_page)
    memory, page = tmp_path / "m", tmp_path / "page"
    Memory(RandomIndex()).save(memory)
    assert main(["inspect", str(memory), "--pictures", str(page), "--each", "3"]) == 0
    assert asked == [("random", 0, page, 300)]
    assert (page / "index.html").as_uri() in capsys.readouterr().out
    (memory / "manifest.json").write_text('{"format": "gcm-learn/memory@1"}')
    assert main(["inspect", str(memory)]) == 2  # it says that it is a memory, and is damaged
    assert "m/manifest.json" in capsys.readouterr().err


class Interrupted(Here):
    """A crew that makes one shard in this process, and is then told to stop."""

    def __init__(self, workers):
        pass

    def results(self, work, tasks, alone=None):
        """The first shard, then Ctrl-C."""
        yield 0, work(next(iter(tasks)))
        raise KeyboardInterrupt


def hashes(folder) -> list[str]:
    place = Folder(str(folder))
    return [place.sha256(f"shards/{name}") for name in place.names("shards")]


@pytest.fixture
def interrupted(tmp_path, monkeypatch):
    """A dataset of which one shard of three was made, and its specification."""
    out, spec = tmp_path / "out", tmp_path / "spec.json"
    spec.write_text(json.dumps(dataset.spec_to_json(SMALL)))
    with monkeypatch.context() as patch:
        patch.setattr("gcm_learn.dataset.generation.LocalCrew", Interrupted)
        assert main(["generate", str(spec), "--out", str(out)]) == 130
    return out, spec


def test_an_interrupted_dataset_says_what_is_missing(interrupted, capsys):
    out, _ = interrupted
    assert main(["inspect", str(out)]) == 0
    said = capsys.readouterr().out
    assert "small: 20 records, 20 of 50\n" in said and "complete" not in said
    assert len(dataset.open(out)) == 20 and dataset.open(out).spec == SMALL


def test_before_the_first_shard_there_is_a_manifest(tmp_path, monkeypatch, capsys):
    def none(self, work, tasks, alone=None):
        raise KeyboardInterrupt

    monkeypatch.setattr("gcm_learn.processes.LocalCrew.results", none)
    with pytest.raises(KeyboardInterrupt):
        dataset.generate(SMALL, tmp_path)
    assert main(["inspect", str(tmp_path)]) == 0
    assert "small: 0 records, 0 of 50\n" in capsys.readouterr().out


@pytest.mark.parametrize("manifest", [True, False])
def test_what_was_left_half_made_goes_on_to_the_same_bytes(interrupted, manifest, capsys):
    out, spec = interrupted
    if not manifest:  # as it was left before there was one from the beginning
        (out / "manifest.json").unlink()
        assert main(["inspect", str(out)]) == 0
        said = capsys.readouterr().out
        assert "20 records, 20 of 20 or more" in said and "complete" not in said
    assert main(["generate", str(spec), "--out", str(out), "--workers", "1"]) == 0
    make_here(SMALL, str(out.parent / "whole"))
    assert hashes(out) == hashes(out.parent / "whole") and len(hashes(out)) == 3
    capsys.readouterr()
    assert main(["inspect", str(out)]) == 0
    assert "small: 50 records, complete\n" in capsys.readouterr().out
