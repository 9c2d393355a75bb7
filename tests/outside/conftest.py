"""Files of our own in the formats of others."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

DATA = Path(__file__).with_name("data")


@pytest.fixture
def shelf(tmp_path):
    """Return a folder with two problems: an older and a newer layout of the same messages."""
    return Path(shutil.copytree(DATA / "shelf", tmp_path / "shelf"))


@pytest.fixture
def flying(tmp_path):
    """Return a function that writes a changed scene of frames."""

    def write(change=lambda scene: None):
        scene = json.loads((DATA / "flying.json").read_text())
        change(scene)
        path = tmp_path / "flying.json"
        path.write_text(json.dumps(scene))
        return path

    return write


@pytest.fixture
def balls(tmp_path):
    """Return a function that writes changed states of balls."""

    def write(change=lambda states: None):
        states = json.loads((DATA / "balls.json").read_text())
        change(states)
        path = tmp_path / "balls.json"
        path.write_text(json.dumps(states))
        return path

    return write
