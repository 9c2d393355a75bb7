"""Output files appear whole or not at all."""

from __future__ import annotations

import os
from pathlib import Path

import pytest
from hypothesis import given, strategies as st

from gcm_learn.cli.failures import CommandFailure
from gcm_learn.cli.files import FileNames, made_folder, output, staged


def test_nothing_is_seen_before_the_end(tmp_path):
    target = tmp_path / "out.txt"
    with staged(target) as place:
        place.write_text("all")
        assert place != target and place.suffix == ".txt" and not target.exists()
    assert target.read_text() == "all" and os.listdir(tmp_path) == ["out.txt"]


def test_an_interrupted_block_leaves_what_was_there(tmp_path):
    target = tmp_path / "out.txt"
    target.write_text("before")
    with pytest.raises(KeyboardInterrupt), staged(target) as place:
        place.write_text("half")
        raise KeyboardInterrupt
    assert target.read_text() == "before" and os.listdir(tmp_path) == ["out.txt"]


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
