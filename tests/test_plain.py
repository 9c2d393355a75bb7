"""Kernels where the inside of numba is not known."""

from __future__ import annotations

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
