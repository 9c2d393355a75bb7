"""Catches in space that the demo shows: planned and verified beforehand, kept with the templates.

To plan them takes a minute of compiling on a new machine.
``python -m gcm_learn.plots.reports.catches`` plans them anew; a test verifies what is kept.
"""

from __future__ import annotations

import json
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path

import numpy as np

from gcm_learn.arms import SpatialArm
from gcm_learn.families import paper_scene, thrown_scene
from gcm_learn.motion import Movement
from gcm_learn.planners import Plan, plan_to_json, solve
from gcm_learn.situation import Situation

NAMES = ("fig5-space", "fig8-space", "thrown-ball")
PLANNER = "layered"


def scene_of(name: str) -> Situation[SpatialArm]:
    """The situation of a catch that is shown."""
    return thrown_scene() if name == "thrown-ball" else paper_scene(name)  # type: ignore[return-value]


def kept_catches() -> list[tuple[Situation[SpatialArm], Plan]]:
    """The situations that are shown, and the plans that were kept."""
    lines = _file().read_text("utf-8").splitlines()
    return [_read(json.loads(line)) for line in lines]


def _read(told: dict[str, object]) -> tuple[Situation[SpatialArm], Plan]:
    situation = scene_of(str(told["name"]))
    columns = told.pop("trajectory")
    assert isinstance(columns, dict)
    moves = Movement(situation.arm, np.array(columns["time"]), np.array(columns["joints"]))
    told.pop("format")
    return situation, Plan(**told, trajectory=moves)  # type: ignore[arg-type]


def keep_catches() -> Path:
    """Plan the catches anew and keep them; returns where."""
    lines = []
    for name in NAMES:
        situation = scene_of(name)
        solve(situation, PLANNER)  # once for nothing: planning_ms is not to count the compiling
        plan = solve(situation, PLANNER)
        if not plan.caught:
            raise RuntimeError(f"no catch to show: {name}: {plan.message}")
        lines.append(json.dumps(plan_to_json(plan, situation)))
    path = Path(str(_file()))
    path.write_text("\n".join(lines) + "\n", "utf-8")
    return path


def _file() -> Traversable:
    return files(__package__).joinpath("templates", "catches.jsonl")


if __name__ == "__main__":
    print(keep_catches())
