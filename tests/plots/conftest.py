"""Situations and plans that several tests of the pictures look at."""

from __future__ import annotations

from pathlib import Path

import pytest
from matplotlib.figure import Figure

from gcm_learn.families.paper import PAPER_SCENES, gate_scene
from gcm_learn.planners import solve
from gcm_learn.planners.plan import Plan
from gcm_learn.plots.figures.sheets import mapped
from gcm_learn.situation import Situation

Case = tuple[Situation, Plan]


@pytest.fixture(scope="session")
def planar_case() -> Case:
    """A planar scene and a catch in it."""
    situation = PAPER_SCENES["fig4"]()
    return situation, solve(situation, "gcm")


@pytest.fixture(scope="session")
def solid_case() -> Case:
    """A 3D scene and a catch in it."""
    situation = PAPER_SCENES["fig6"]()
    return situation, solve(situation, "gcm")


@pytest.fixture(scope="session")
def waiting_case() -> Case:
    """A scene in which the hand has to wait, and its catch."""
    situation = gate_scene()
    return situation, mapped(situation, solve(situation, "layered"))


@pytest.fixture
def drawn(tmp_path: Path):
    """Save a figure and return the file; nothing may warn while it is drawn."""

    def save(figure: Figure) -> Path:
        path = tmp_path / "figure.png"
        figure.savefig(path)
        assert path.stat().st_size > 1000
        return path

    return save
