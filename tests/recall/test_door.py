"""What others may use of recall, and what it takes to import it."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from gcm_learn import recall

PACKAGE = Path(recall.__file__).parents[1]


def test_the_door_is_complete():
    pytest.importorskip("pyarrow")
    pytest.importorskip("torch")
    assert all(hasattr(recall, name) for name in recall.__all__)
    with pytest.raises(AttributeError, match="no attribute 'Memories'"):
        _ = recall.Memories


def test_others_come_by_the_door():
    past = re.compile(r"from gcm_learn\.recall\.\w+ import")
    for path in PACKAGE.rglob("*.py"):
        if "recall" not in path.relative_to(PACKAGE).parts:
            assert not past.search(path.read_text(encoding="utf-8")), path


def test_recall_needs_no_extra():
    code = (
        "import sys, gcm_learn.recall\n"
        "extras = {'torch', 'safetensors', 'pyarrow', 'dask', 'faiss', 'gymnasium', 'matplotlib'}\n"
        "print(*sorted(extras & set(sys.modules)))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == ""
