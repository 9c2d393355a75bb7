"""Where compiled kernels are kept."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import pytest
from numba.core.caching import IndexDataCacheFile

import gcm_learn
from gcm_learn import compiled


def test_many_who_save_at_once_lose_nothing(tmp_path):
    """Threads stand for processes: each opens the lock and the files for itself."""
    assert gcm_learn.compiled is compiled  # whose import made saving take turns
    keys = [f"signature {k}" for k in range(60)]

    def save(key):
        IndexDataCacheFile(str(tmp_path), "kernel", "stamp").save(key, f"code of {key}")

    with ThreadPoolExecutor(6) as pool:
        list(pool.map(save, keys))
    cache = IndexDataCacheFile(str(tmp_path), "kernel", "stamp")
    assert [cache.load(key) for key in keys] == [f"code of {key}" for key in keys]


def test_a_folder_that_is_gone_is_said_by_saving_itself(tmp_path):
    gone = IndexDataCacheFile(str(tmp_path / "gone"), "kernel", "stamp")
    with pytest.raises(OSError, match="kernel") as error:
        gone.save("signature", "code")
    assert compiled.LOCK not in str(error.value) and not (tmp_path / "gone").exists()


def test_taking_turns_twice_is_taking_turns():
    before = IndexDataCacheFile.save
    compiled.save_in_turn()
    assert IndexDataCacheFile.save is before
