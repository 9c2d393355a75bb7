"""Situation files, and planners that show the plumbing around them."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from gcm_learn.planners import registry
from gcm_learn.planners.plan import Plan


def make_scene(name: str = "ball", **changes: object) -> dict:
    """Return a situation of the exchange contract: a ball that drops past the hand."""
    target = {
        "role": "target",
        "name": "ball",
        "shape": {"kind": "disc", "radius": 0.08},
        "motion": {
            "kind": "quadratic",
            "position": [1.5, 0.6],
            "velocity": [-0.4, -0.6],
            "acceleration": [0, -1.5],
        },
    }
    return {
        "format": "gcm-learn/situation@1",
        "name": name,
        "horizon": 1.0,
        "arm": {"hand": [1.1, -0.4], "max_hand_speed": 3.1},
        "bodies": [target],
    } | changes


@pytest.fixture
def scene():
    """Return the function that makes situations."""
    return make_scene


@pytest.fixture
def scene_file(tmp_path):
    """Return a function that writes scenes to a .jsonl file and gives its path."""

    def write(*scenes: dict, name: str = "scenes.jsonl") -> Path:
        path = tmp_path / name
        path.write_text("".join(json.dumps(s) + "\n" for s in scenes))
        return path

    return write


class QuietPlanner:
    """Finds no catch, and remembers what it was asked."""

    name = "quiet"

    def __init__(self) -> None:
        self.asked: list[str] = []

    def plan(self, situation) -> Plan:
        """Return a plan that says `unreachable`."""
        self.asked.append(situation.name)
        return Plan(
            name=situation.name,
            planner=self.name,
            status="unreachable",
            message="it does not look.",
            planning_ms=0.5,
            catch_time=None,
            catch_body=None,
            clearance=None,
            trajectory=None,
            map=None,
        )


@pytest.fixture
def planner(monkeypatch):
    """Let `solve` ask a planner that costs nothing, whichever is named."""
    quiet = registry.as_ours(QuietPlanner())
    monkeypatch.setattr("gcm_learn.cli.solve.Solve._planner", lambda command: quiet)
    return quiet
