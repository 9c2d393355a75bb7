"""The notebooks run from top to bottom, in their fast mode, and show what they say they show."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).parents[1]
NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.py"))
PICTURES = {f"{k:02}": 1 for k in range(1, 10)} | {"03": 0, "10": 2, "11": 2}
NEEDS = {
    "02": "pyarrow",
    "03": "pyarrow",
    "04": "stable_baselines3",
    "05": "gymnasium",
    "07": "mujoco",
    "09": "sklearn",
}
FAST = {**os.environ, "GCM_LEARN_FAST": "1", "PYTHONPATH": str(ROOT)}


def test_there_are_eleven():
    assert [path.stem[:2] for path in NOTEBOOKS] == list(PICTURES)


def test_notebooks_show_their_pictures():
    """All in one process, emptied of names between them."""
    jupytext, nbclient = pytest.importorskip("jupytext"), pytest.importorskip("nbclient")
    shelf = jupytext.reads("", "py:percent")
    shelf.metadata["kernelspec"] = {"name": "python3"}
    cells: dict[str, list[Any]] = {}
    for path in NOTEBOOKS:
        require(path)
        cells[path.stem[:2]] = jupytext.read(path).cells
        emptied = jupytext.reads("%reset -f", "py:percent").cells
        shelf.cells += [*emptied, *cells[path.stem[:2]]]
    place = {"metadata": {"path": str(ROOT)}}
    nbclient.NotebookClient(shelf, kernel_name="python3", resources=place).execute(env=FAST)
    assert {name: pictures(part) for name, part in cells.items()} == PICTURES


def pictures(cells: list[Any]) -> int:
    """Number of pictures that executed cells show."""
    outputs = [output for cell in cells for output in cell.get("outputs", ())]
    return sum("image/png" in output.get("data", {}) for output in outputs)


@pytest.mark.slow
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda p: p.stem)
def test_notebook_is_a_script_too(path):
    require(path)
    done = subprocess.run(
        [sys.executable, str(path)],
        env={**FAST, "MPLBACKEND": "Agg"},
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-2000:]


def require(path: Path) -> None:
    needed = NEEDS.get(path.stem[:2])
    if needed:
        pytest.importorskip(needed)
