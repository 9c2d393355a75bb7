"""In continuous integration a skip that nobody agreed to is a failure."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.skips import ALLOWED

TESTS = Path(__file__).parent
MODULE = """
import pytest
def test_allowed(): pytest.skip("nothing to reach")
def test_not_allowed(): pytest.importorskip("nothing_of_that_name")
@pytest.mark.skipif(True, reason="no reason")
def test_marked(): pass
@pytest.mark.xfail(reason="known", strict=True)
def test_known(): assert False
"""


@pytest.fixture
def folder(tmp_path):
    """Tests that skip, with our rules."""
    tests = tmp_path / "tests"
    tests.mkdir()
    for name in ("conftest.py", "skips.py"):
        shutil.copy(TESTS / name, tests)
    (tests / "test_some.py").write_text(MODULE)
    (tests / "test_none.py").write_text("import pytest\npytest.importorskip('nothing_like_it')\n")
    return tmp_path


def outcome(folder: Path, **environment: str) -> str:
    """Last line of a run, and how often the rule is named."""
    command = [sys.executable, "-m", "pytest", "-q", "-c", os.devnull, "--rootdir", ".", "tests"]
    kept = {name: value for name, value in os.environ.items() if name != "CI"}
    paths = os.pathsep.join((str(folder), str(TESTS.parent)))
    done = subprocess.run(
        command,
        cwd=folder,
        env={**kept, "PYTHONPATH": paths, **environment},
        capture_output=True,
        text=True,
        check=False,
    )
    return done.stdout


def test_at_a_desk_a_skip_is_a_skip(folder):
    assert "4 skipped, 1 xfailed" in outcome(folder)


def test_in_continuous_integration_it_is_a_failure(folder):
    told = outcome(folder, CI="1")
    assert "not allowed here" in told and "nothing_like_it" in told and "1 error" in told
    (folder / "tests" / "test_none.py").unlink()
    assert "1 failed, 1 skipped, 1 xfailed, 1 error" in outcome(folder, CI="1")


def test_every_allowance_is_used_and_explained():
    sources = "".join(path.read_text("utf-8") for path in TESTS.rglob("test_*.py"))
    assert [reason for reason in ALLOWED if f'"{reason}"' not in sources] == []
    assert all(len(why) > 10 for why in ALLOWED.values())
