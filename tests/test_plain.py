"""Kernels where the inside of numba is not known."""

from __future__ import annotations

import os
import subprocess
import sys
import textwrap

import numba
import pytest

from gcm_learn.compiled import plain


def doubled(x):
    return x + x


doubled.__module__ = "gcm_learn.wave.doubled"
MADE: list[object] = []


@pytest.fixture
def place(tmp_path, monkeypatch):
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    return tmp_path


def compiled_anew(x):
    """Call the function as a new process would; return what was compiled."""
    made = plain.kernel(doubled, {})
    MADE.append(made)  # numba finds what belongs to a module that is none while it lives
    assert made(x) == 2 * x
    return sum(made.stats.cache_misses.values())


def test_code_is_kept_by_content_and_numbas_setting_is_left_alone(place):
    assert [compiled_anew(2), compiled_anew(2), compiled_anew(0.5)] == [1, 0, 1]
    assert {path.parent.parent for path in place.rglob("*.nbc")} == {
        place / plain.folder_of(doubled.__module__)
    }
    assert numba.config.CACHE_DIR == str(place)


@pytest.mark.parametrize("suffix", ["nbi", "nbc"])
def test_damaged_code_is_compiled(place, suffix):
    compiled_anew(2)
    for path in place.rglob(f"*.{suffix}"):
        path.write_bytes(b"junk" * 100)
    assert compiled_anew(2) == 1


def test_a_file_in_place_of_the_folder_does_not_stop(place, monkeypatch):
    (place / "file").touch()
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(place / "file"))
    assert compiled_anew(2) == 1


TABLE = """
    from typing import NamedTuple
    from gcm_learn.compiled import by_type, njit

    class Disc(NamedTuple):
        radius: float

    class Square(NamedTuple):
        side: float

    @njit
    def of_disc(shape, by):
        return shape.radius * by

    @njit
    def of_others(shape, by):
        return shape[0] + by

    size = by_type({Disc: of_disc, None: of_others})

    @njit
    def sizes(disc, square):
        return size(disc, 3.0), size(square, 3.0)

    print(*sizes(Disc(2.0), Square(2.0)), size(Disc(2.0), 5.0))
"""


@pytest.mark.parametrize("as_it_is", ["", "1"])
def test_tables_choose_by_type(as_it_is):
    environment = os.environ | {"GCM_LEARN_PLAIN": as_it_is}
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(TABLE)],
        env=environment, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert done.stdout.split() == ["6.0", "5.0", "10.0"]
