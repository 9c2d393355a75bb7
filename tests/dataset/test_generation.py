"""Making a dataset: by any hands, in any order, after any crash, the same bytes."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import ClassVar

import pytest

from gcm_learn import dataset
from gcm_learn.cli import main
from gcm_learn.dataset import generate, shards
from gcm_learn.dataset.folder import Folder
from gcm_learn.dataset.generation import make_alone
from gcm_learn.dataset.item import make_item
from gcm_learn.dataset.manifest import read_manifest
from gcm_learn.dataset.record import Record
from gcm_learn.dataset.shards import ShardInfo, make_shard, shard_name
from gcm_learn.dataset.spec import spec_to_json
from gcm_learn.errors import DatasetError
from gcm_learn.processes import Here
from tests.dataset.conftest import SMALL, SPACE, make_here
from tests.refusals import refusal

ROOT = Path(__file__).parents[2]


def hashes(folder: object) -> dict[str, str]:
    place = Folder(str(folder))
    return {name: place.sha256(f"shards/{name}") for name in place.names("shards")}


class Noting(Here):
    """A crew that works in this process and notes at what."""

    made: ClassVar[list[int]] = []

    def __init__(self, workers, ahead=2):
        pass

    def results(self, work, tasks, alone=None):
        """Do the tasks at once."""
        return super().results(work, (self.made.append(task) or task for task in tasks))


@pytest.fixture
def here(monkeypatch):
    """Let shards be made in this process; returns those that were."""
    monkeypatch.setattr("gcm_learn.dataset.generation.LocalCrew", Noting)
    monkeypatch.setattr(Noting, "made", [])
    return Noting


def test_only_what_is_missing_is_made(small, tmp_path, here, small_folder):
    generate(small, tmp_path)
    assert here.made == [0, 1, 2]
    before = hashes(tmp_path)
    Folder(tmp_path).open(shard_name(1)).close()
    os.remove(tmp_path / shard_name(1))
    (tmp_path / "shards" / ".shard-000001.parquet.99.tmp").write_bytes(b"left by a killed writer")
    counts = []
    manifest = generate(small, tmp_path, progress=counts.append)
    assert here.made == [0, 1, 2, 1] and counts == [30, 20]
    assert hashes(tmp_path) == before
    assert manifest["complete"] and len(manifest["runs"]) == 2
    generate(small, tmp_path)
    assert here.made == [0, 1, 2, 1]


def test_a_shard_that_cannot_be_read_is_made_again(small, tmp_path, here):
    generate(small, tmp_path)
    before = hashes(tmp_path)
    path = tmp_path / shard_name(0)
    path.write_bytes(path.read_bytes()[:-100])
    generate(small, tmp_path)
    assert here.made == [0, 1, 2, 0] and hashes(tmp_path) == before


@pytest.mark.parametrize(
    "spec", [SMALL, pytest.param(SPACE, marks=pytest.mark.slow)], ids=["plane", "space"]
)
def test_a_shard_that_was_stopped_goes_on_after_its_last_items(spec, tmp_path, monkeypatch):
    spec = replace(spec, shard_size=12, count=12)
    made, stops = [], [7, 9]

    def item(spec, k):
        if k in stops:
            stops.remove(k)
            raise KeyboardInterrupt
        made.append(k)
        return make_item(spec, k)

    for name in ("whole", "parts"):
        Folder(tmp_path / name).make()
    make_shard(spec, 0, str(tmp_path / "whole"))
    monkeypatch.setattr(shards, "make_item", item)
    monkeypatch.setattr(shards, "BETWEEN_PARTS", -1.0)
    for _ in range(2):
        with pytest.raises(KeyboardInterrupt):
            make_shard(spec, 0, str(tmp_path / "parts"))
    assert shards.kept(spec, Folder(tmp_path / "parts")) == 9
    make_shard(spec, 0, str(tmp_path / "parts"))
    assert made == list(range(12))
    assert os.listdir(tmp_path / "parts" / "shards") == ["shard-000000.parquet"]
    assert hashes(tmp_path / "parts") == hashes(tmp_path / "whole")


def test_a_report_counts_items_of_stopped_shards(small, tmp_path, monkeypatch, capsys):
    def item(spec, k):
        if k == 25:
            raise KeyboardInterrupt
        return make_item(spec, k)

    monkeypatch.setattr("gcm_learn.dataset.generation.LocalCrew", Noting)
    monkeypatch.setattr(shards, "make_item", item)
    monkeypatch.setattr(shards, "BETWEEN_PARTS", -1.0)
    with pytest.raises(KeyboardInterrupt):
        generate(small, tmp_path)
    assert main(["inspect", str(tmp_path)]) == 0
    said = capsys.readouterr().out.splitlines()[0]
    assert said == "small: 20 records, 20 of 50, and 5 kept of shards that are not finished"


def test_items_of_other_code_are_made_again(small, tmp_path, monkeypatch):
    Folder(tmp_path).make()
    part = tmp_path / "shards" / ".shard-000000.tmp"
    monkeypatch.setattr(shards, "BETWEEN_PARTS", -1.0)
    monkeypatch.setattr(shards, "write_shard", lambda *given: None)
    for code in ("older", "newer"):
        monkeypatch.setattr(shards, "code_version", lambda code=code: code)
        assert shards._kept(small, 0, Folder(tmp_path)) == []
        make_shard(small, 0, str(tmp_path))
        assert len(shards._kept(small, 0, Folder(tmp_path))) == len(small.indices(0))
    whole = part.read_bytes()
    for damaged in (whole[:-50], whole[:4] + bytes(2000) + whole[2004:]):
        part.write_bytes(damaged)
        assert shards._kept(small, 0, Folder(tmp_path)) == []


def test_time_and_size_are_told_beforehand(tmp_path, capsys, small_folder):
    made = dataset.open(small_folder).manifest
    small = dataset.spec_from_json(made["spec"])
    told = dataset.estimate(small, tmp_path / "new")
    assert (told.records, told.asked) == (50, 50) and 0.0 < told.seconds < 60.0
    assert 0.5 * made["bytes"] < told.bytes < 1.5 * made["bytes"]
    assert dataset.estimate(small, tmp_path / "new", least=51) is None
    assert dataset.estimate(small, small_folder) is None
    spec = tmp_path / "spec.json"
    spec.write_text(json.dumps(spec_to_json(replace(small, count=1000))))
    command = ["generate", str(spec), "--out", str(tmp_path / "new"), "--dry-run"]
    assert main([*command, "--shards", "0/2"]) == 0
    assert "new: 500 records to make, about 0:" in capsys.readouterr().out
    assert not (tmp_path / "new").exists()


def test_a_larger_count_goes_on_and_remakes_the_short_shard(small, tmp_path, here):
    generate(small, tmp_path)
    first = hashes(tmp_path)
    generate(replace(small, count=75), tmp_path)
    assert here.made == [0, 1, 2, 2, 3]
    second = hashes(tmp_path)
    assert [first[name] == second[name] for name in first] == [True, True, False]
    records = dataset.open(tmp_path)
    assert [record.index for record in records] == list(range(75))


def test_parts_of_a_job_array_make_the_whole(small, tmp_path, here):
    generate(small, tmp_path / "whole")
    states = []
    for i in (2, 0, 1):
        manifest = generate(small, tmp_path / "parts", part=(i, 3))
        states.append(manifest["complete"])
        assert dataset.open(tmp_path / "parts").manifest["records"] == manifest["records"]
    assert states == [False, False, True]
    assert hashes(tmp_path / "parts") == hashes(tmp_path / "whole")


def test_another_specification_is_refused(small, tmp_path, here):
    generate(small, tmp_path)
    said = refusal(DatasetError, generate, replace(small, seed=99, name="other"), tmp_path)
    assert re.search(r"specification 'small', not of this 'other' .*in name, seed", said)


def test_a_folder_in_memory_needs_no_other_processes(small, tmp_path):
    """Processes would each have a memory of their own."""
    url, few = "memory://alone", replace(small, count=3, shard_size=2)
    assert generate(few, url, 2)["complete"]
    assert dataset.verify_dataset(url).faults == 0
    with pytest.raises(DatasetError, match=r"^memory://alone/shards/shard-000000.parquet: is of"):
        generate(replace(few, seed=99), url)


@pytest.mark.parametrize(
    ("url", "said"),
    [
        ("s3://bucket/folder", "s3://bucket/folder: needs s3fs: pip install s3fs"),
        ("nowhere://folder", "nowhere://folder: Protocol not known: nowhere"),
    ],
)
def test_a_place_that_cannot_be_reached_is_one_line(url, said, tmp_path, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "s3fs", None)
    spec = tmp_path / "spec.json"
    spec.write_text(json.dumps(spec_to_json(SMALL)))
    assert main(["generate", str(spec), "--out", url]) == 2
    assert main(["inspect", url]) == 2
    assert capsys.readouterr().err == 2 * f"gcm-learn: {said}\n"


@pytest.mark.parametrize("url", ["memory://made/set", "file"])
def test_fsspec_folders(url, small, tmp_path, here):
    url = f"file://{tmp_path}/remote" if url == "file" else url
    manifest = generate(small, url)
    generate(small, tmp_path / "local")
    assert manifest["hash"] == read_manifest(Folder(tmp_path / "local"))["hash"]
    assert sorted(Folder(url).names()) == ["manifest.json", "shards"]
    assert [r.index for r in dataset.open(url)[:3]] == [0, 1, 2]


def test_the_manifest_adds_up(small_folder):
    records = dataset.open(small_folder)
    manifest = records.manifest
    assert manifest["records"] == len(records) == 50
    column = list(records.column("stratum"))
    assert manifest["strata"] == {s: column.count(s) for s in "LWQU"}
    assert sum(manifest["shares"].values()) == pytest.approx(1.0, abs=1e-3)
    assert manifest["drawn"] == 50 + sum(manifest["rejected"].values())
    assert sum(manifest["splits"].values()) == 50
    assert manifest["caught"]["layered"] == sum(r.plans["layered"].caught for r in records)
    assert manifest["bytes"] == sum(os.path.getsize(path) for path in records.files)
    assert manifest["spec"]["seed"] == 3 and json.dumps(manifest)
    for shard in manifest["shards"]:
        assert records.folder.sha256(shard["name"]) == shard["sha256"]
    audit = manifest["audit"]
    agreed = sum(n for pair, n in audit["label/oracle"].items() if pair[0] == pair[-1])
    assert audit["disagreement"] == pytest.approx(1 - agreed / audit["records"], abs=1e-4)


def mortal(spec, shard, url) -> ShardInfo:
    """Make a shard, but die the first time that shard 1 is asked for."""
    mark = Path(url) / "died"
    if shard == 1 and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return make_shard(spec, shard, url)


def cursed(spec, shard, url) -> ShardInfo:
    """Make a shard, but die whenever shard 1 is asked for."""
    if shard == 1:
        os.kill(os.getpid(), signal.SIGKILL)
    return make_shard(spec, shard, url)


def fatal(spec, k) -> Record:
    """Make an item, but die whenever item 23 is asked for."""
    if k == 23:
        os.abort()
    return make_item(spec, k)


def test_a_killed_worker_costs_nothing_but_time(small, tmp_path, monkeypatch, small_folder):
    make_here(small, str(tmp_path / "here"))
    monkeypatch.setattr("gcm_learn.dataset.generation.make_shard", mortal)
    generate(small, tmp_path / "pool", 2)
    assert (tmp_path / "pool" / "died").exists()
    assert hashes(tmp_path / "pool") == hashes(tmp_path / "here")
    assert multiprocessing_children() == []


def multiprocessing_children() -> list[int]:
    """Return the process ids of worker processes of this one that are still there."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            status = (folder / "status").read_text()
            command = (folder / "cmdline").read_text()
        except OSError:
            continue
        if f"PPid:\t{os.getpid()}\n" in status and "spawn_main" in command:
            found.append(int(folder.name))
    return found


@pytest.mark.slow
def test_a_shard_that_always_kills_its_process_is_made_alone(small, tmp_path, monkeypatch):
    make_here(small, str(tmp_path / "here"))
    monkeypatch.setattr("gcm_learn.dataset.generation.make_shard", cursed)
    generate(small, tmp_path / "pool", 2)
    assert hashes(tmp_path / "pool") == hashes(tmp_path / "here")


@pytest.mark.slow
def test_an_item_that_kills_its_process_is_recorded(small, tmp_path, monkeypatch):
    monkeypatch.setattr("gcm_learn.dataset.generation.make_item", fatal)
    Folder(tmp_path).make()
    info = make_alone(small, 1, str(tmp_path))
    assert info.failures == 1 and info.failed == {"23": "the process that made it died"}
    assert info.rows == 20


def deadly(spec, k) -> Record:
    """Die whatever is asked for."""
    os.abort()


@pytest.mark.slow
def test_processes_that_make_nothing_are_no_dataset(small, tmp_path, monkeypatch):
    monkeypatch.setattr("gcm_learn.dataset.generation.make_item", deadly)
    Folder(tmp_path).make()
    with pytest.raises(DatasetError, match="die before they make anything"):
        make_alone(replace(small, shard_size=2), 1, str(tmp_path))
    assert Folder(tmp_path).names("shards") == []


def run_generate(spec: Path, out: Path, *options: str) -> subprocess.Popen:
    command = [sys.executable, "-m", "gcm_learn", "generate", str(spec), "--out", str(out)]
    return subprocess.Popen(
        [*command, *options], cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )


def write_spec(small, folder: Path, **changes) -> Path:
    path = folder / "spec.json"
    path.write_text(json.dumps(dataset.spec_to_json(replace(small, **changes))))
    return path


@pytest.mark.slow
def test_eight_workers_and_one_give_the_same_bytes(small, tmp_path):
    spec = write_spec(small, tmp_path, count=400)
    for workers in ("1", "8"):
        assert run_generate(spec, tmp_path / workers, "--workers", workers).wait() == 0
    assert hashes(tmp_path / "1") == hashes(tmp_path / "8")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("spec", "changes", "workers", "shards"),
    [(SMALL, {"count": 4000}, "2", 200), (SPACE, {"count": 60, "effort": 0.1}, "1", 15)],
    ids=["plane", "space"],
)
def test_ctrl_c_leaves_a_folder_that_goes_on(
    spec, changes, workers, shards, tmp_path, interruptible
):
    spec = write_spec(spec, tmp_path, **changes)
    done = run_generate(spec, tmp_path / "out", "--workers", workers)
    wait_for(lambda: len(list((tmp_path / "out").glob("shards/shard-*"))) >= 2, 200.0)
    done.send_signal(signal.SIGINT)
    _, error = done.communicate(timeout=60)
    assert done.returncode == 130 and error == "gcm-learn: interrupted\n"
    there = hashes(tmp_path / "out")
    assert 2 <= len(there) < shards
    second = run_generate(spec, tmp_path / "out", "--workers", "2")
    assert second.wait() == 0
    whole = hashes(tmp_path / "out")
    assert len(whole) == shards and there.items() <= whole.items()


@pytest.mark.slow
def test_kill_9_at_random_moments(small, tmp_path):
    """What is left of a killed run, workers included, goes on to the same hashes."""
    spec = write_spec(small, tmp_path, count=600)
    assert run_generate(spec, tmp_path / "whole", "--workers", "2").wait() == 0
    expected = hashes(tmp_path / "whole")
    moments = json.loads(os.environ.get("GCM_LEARN_KILLS", "[3.0, 3.6, 4.4, 5.2]"))
    for k, seconds in enumerate(moments):
        out = tmp_path / f"killed-{k}"
        run = run_generate(spec, out, "--workers", "2")
        time.sleep(seconds)
        run.kill()
        run.wait()
        again = run_generate(spec, out, "--workers", "2")
        assert again.wait() == 0, again.stderr.read()
        assert hashes(out) == expected, f"killed after {seconds} s"


def wait_for(condition, seconds: float = 60.0) -> None:
    deadline = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < deadline, "it never came"
        time.sleep(0.05)
