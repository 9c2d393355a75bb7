"""Output files appear whole or not at all."""

from __future__ import annotations

import os
import stat
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gcm_learn.cli.failures import CommandFailure
from gcm_learn.cli.files import FileNames, made_folder, output, staged


def test_nothing_is_seen_before_the_end(tmp_path):
    target = tmp_path / "out.txt"
    with staged(target) as place:
        place.write_text("all")
        assert place != target and place.suffix == ".txt" and not target.exists()
    assert target.read_text() == "all" and os.listdir(tmp_path) == ["out.txt"]


@pytest.mark.parametrize("error", [KeyboardInterrupt, SystemExit, ValueError])
def test_an_error_leaves_what_was_there(tmp_path, error):
    target = tmp_path / "out.txt"
    target.write_text("before")
    with pytest.raises(error), staged(target) as place:
        place.write_text("half")
        raise error
    assert target.read_text() == "before" and os.listdir(tmp_path) == ["out.txt"]


def test_mode_and_link_survive(tmp_path):
    real, link = tmp_path / "real.txt", tmp_path / "link.txt"
    real.write_text("before")
    real.chmod(0o640)
    link.symlink_to(real)
    with staged(link) as place:
        place.write_text("after")
    assert link.is_symlink() and real.read_text() == "after"
    assert stat.S_IMODE(real.stat().st_mode) == 0o640


def test_a_device_is_written_to_and_stays_a_device():
    with staged(Path(os.devnull)) as place:
        assert place == Path(os.devnull)
    assert stat.S_ISCHR(os.stat(os.devnull).st_mode)


@pytest.mark.parametrize("name", ["", "missing/out.txt", "n" * 300])
def test_a_place_that_cannot_be_written_to(tmp_path, name):
    with pytest.raises(CommandFailure, match="--out") as caught, staged(tmp_path / name):
        pytest.fail("the block must not begin")
    assert caught.value.exit_code == 2 and "\n" not in str(caught.value)


def test_a_file_is_no_folder(tmp_path):
    (tmp_path / "file").touch()
    with pytest.raises(CommandFailure, match="--plot"):
        made_folder(tmp_path / "file", option="--plot")
    assert os.listdir(made_folder(tmp_path / "a" / "b", option="--plot")) == []


@given(st.lists(st.text(max_size=100), max_size=20))
def test_file_names_are_safe_and_differ(names):
    unused = FileNames()
    made = [unused.unused(name) for name in names]
    assert len({name.lower() for name in made}) == len(names)
    for name in made:
        assert name.isascii() and name[0] not in ".-" and "/" not in name and len(name) < 100


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no device that is always full")
def test_a_full_place_is_named():
    full = Path("/dev/full")
    with pytest.raises(CommandFailure, match="--out /dev/full: No space left"), output(full) as out:
        out.write("much")
        out.flush()
