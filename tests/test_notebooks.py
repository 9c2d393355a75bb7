"""The notebooks run from top to bottom, in their fast mode."""

from __future__ import annotations

import os
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
NOTEBOOKS = sorted((ROOT / "experiments" / "notebooks").glob("*.py"))
NEEDS = {"02": "pyarrow", "03": "pyarrow", "04": "stable_baselines3"}
FAST = {**os.environ, "GCM_LEARN_FAST": "1", "MPLBACKEND": "Agg", "PYTHONPATH": str(ROOT)}


def test_there_are_five():
    assert len(NOTEBOOKS) == 5


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda p: p.stem)
def test_notebook_runs(path):
    """In percent form a notebook is a script."""
    needed = NEEDS.get(path.stem[:2])
    if needed and find_spec(needed) is None:
        pytest.skip(f"needs {needed}")
    done = subprocess.run(
        [sys.executable, str(path)], env=FAST, cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr[-2000:]


@pytest.mark.slow
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda p: p.stem)
def test_notebook_runs_in_jupyter(path, tmp_path):
    jupytext = pytest.importorskip("jupytext")
    pytest.importorskip("nbmake")
    notebook = tmp_path / f"{path.stem}.ipynb"
    jupytext.write(jupytext.read(path), notebook)
    command = [sys.executable, "-m", "pytest", "--nbmake", "-c", os.devnull, str(notebook)]
    done = subprocess.run(
        command, env=FAST, cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout[-2000:]
