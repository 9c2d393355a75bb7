"""Files of our own in the formats of others."""

import json
import shutil
from pathlib import Path

import pytest

DATA = Path(__file__).with_name("data")


@pytest.fixture
def shelf(tmp_path):
    """Return a folder with two problems: an older and a newer layout of the same messages."""
    return Path(shutil.copytree(DATA / "shelf", tmp_path / "shelf"))


def changing(folder, name):
    """Return a function that writes a file of DATA to a folder, changed by another function."""

    def write(change=lambda content: None):
        content = json.loads((DATA / name).read_text())
        change(content)
        path = folder / name
        path.write_text(json.dumps(content))
        return path

    return write


@pytest.fixture
def flying(tmp_path):
    """Return a function that writes a changed scene of frames."""
    return changing(tmp_path, "flying.json")


@pytest.fixture
def balls(tmp_path):
    """Return a function that writes changed states of balls."""
    return changing(tmp_path, "balls.json")
