"""Files are whole or not there, whatever stops their writer."""

import hashlib
import io
import os
import stat
from pathlib import Path

import numba
import pytest

from gcm_learn import compiled, storage


@pytest.mark.parametrize("durable", [False, True])
def test_a_file_appears_at_the_end(tmp_path, durable):
    target = tmp_path / "a.txt"
    with storage.whole_file(target, durable=durable) as place:
        assert place.parent == tmp_path and place.suffix == ".txt"
        place.write_text("all")
        assert not target.exists()
    assert target.read_text() == "all" and os.listdir(tmp_path) == ["a.txt"]


@pytest.mark.parametrize("error", [ValueError, KeyboardInterrupt, SystemExit])
@pytest.mark.parametrize("before", [None, "before"])
def test_nothing_half_written_is_left(tmp_path, error, before):
    target = tmp_path / "a.txt"
    if before is not None:
        target.write_text(before)
    with pytest.raises(error), storage.whole_file(target) as place:
        place.write_text("half")
        raise error
    assert [p.read_text() for p in tmp_path.iterdir()] == ([] if before is None else [before])


def test_a_failing_rename_leaves_nothing(tmp_path, monkeypatch):
    def refused(*args):
        raise OSError("no")

    monkeypatch.setattr(storage.os, "replace", refused)
    with pytest.raises(OSError, match="no"):
        storage.write_whole(tmp_path / "a.txt", "all")
    assert not os.listdir(tmp_path)


def test_permissions_and_links_stay(tmp_path):
    real, link = tmp_path / "real.txt", tmp_path / "link.txt"
    real.touch(mode=0o640)
    link.symlink_to(real)
    storage.write_whole(link, b"new")
    assert link.is_symlink() and real.read_bytes() == b"new"
    assert stat.S_IMODE(real.stat().st_mode) == 0o640


def test_the_error_names_the_file_that_was_asked_for(tmp_path):
    for target in (tmp_path / "missing" / "a.txt", tmp_path):
        with pytest.raises(OSError) as caught:
            storage.write_whole(target, "")
        assert caught.value.filename == str(target)


def test_a_device_is_written_to_directly():
    with storage.whole_file(os.devnull) as place:
        assert place == Path(os.devnull)


def test_a_folder_appears_at_the_end(tmp_path):
    target = tmp_path / "above" / "folder"
    with pytest.raises(KeyboardInterrupt), storage.whole_folder(target) as place:
        (place / "a").touch()
        raise KeyboardInterrupt
    assert not os.listdir(target.parent)
    with storage.whole_folder(target) as place:
        (place / "a").touch()
    assert os.listdir(target.parent) == ["folder"] and os.listdir(target) == ["a"]


def test_the_first_of_two_folders_stays(tmp_path):
    target = tmp_path / "folder"
    with storage.whole_folder(target) as slow:
        (slow / "slow").touch()
        with storage.whole_folder(target) as fast:
            (fast / "fast").touch()
    assert os.listdir(tmp_path) == ["folder"] and os.listdir(target) == ["fast"]


def test_unfinished_files_are_known_by_name():
    assert storage.is_unfinished(storage.temporary_name())
    assert storage.is_unfinished(storage.temporary_name(".zip"))
    assert storage.is_unfinished(".shard-000001.parquet.17-0a1b2c3d.tmp")
    assert not storage.is_unfinished("shard-000001.parquet")
    assert not storage.is_unfinished("work.tmp")


def test_hashes_are_sha256():
    wanted = hashlib.sha256(b"one two")
    assert storage.content_hash("one ", b"two") == wanted.hexdigest()
    assert storage.stream_hash(io.BytesIO(b"one two")) == wanted.hexdigest()
    number = int.from_bytes(wanted.digest()[:6], "little")
    assert storage.content_number(b"one two", 6) == number


def test_the_users_folders(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setattr(numba.config, "CACHE_DIR", "")
    assert compiled.folder() == storage.user_cache("kernels")
    assert storage.user_cache("kernels").parent == storage.user_cache("maps").parent
    assert storage.user_cache("kernels") != storage.user_data("kernels")
    assert not (tmp_path / "cache").exists()
