"""The five walks of ARCHITECTURE.md: straight lists of doors, called once each, in order."""

from __future__ import annotations

import importlib
import re
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest

from gcm_learn import families, get_planner, write_situations

ROOT = Path(__file__).parents[1]
TEXT = (ROOT / "ARCHITECTURE.md").read_text("utf-8").split("## Five walks\n")[1].split("\n## ")[0]
WALKS = {
    title: re.findall(r"^\d\. `(\w+)\.(\w+)`", part, re.M)
    for title, part in re.findall(r"^\*\*(.+?)\*\*(.*?)(?=^\*\*|\Z)", TEXT, re.M | re.S)
}


SPEC = """
format = "gcm-learn/dataset-spec@1"
name = "one"
seed = 3
count = 1
shard_size = 1
map = "marching"
planners = ["marching"]
rungs = 1
[[families]]
family = "random-planar"
"""


@pytest.fixture
def called(monkeypatch) -> Callable[[list[tuple[str, str]]], list[tuple[str, str]]]:
    """Return a function that has calls of some doors written down, wherever they were taken."""

    def watch(doors: list[tuple[str, str]]) -> list[tuple[str, str]]:
        seen: list[tuple[str, str]] = []
        for folder, name in doors:
            door = importlib.import_module(f"gcm_learn.{folder}")
            assert name in door.__all__, f"{folder} does not offer {name}"
            plain = getattr(door, name)
            noted = _noting(plain, (folder, name), seen)
            for module in [m for n, m in sys.modules.items() if n.startswith("gcm_learn")]:
                for held in _names_of(module, plain):
                    monkeypatch.setattr(module, held, noted)
        return seen

    return watch


def _noting(plain: Callable[..., Any], door: tuple[str, str], seen: list) -> Callable[..., Any]:
    def noted(*given: Any, **named: Any) -> Any:
        seen.append(door)
        return plain(*given, **named)

    return noted


def _names_of(module: ModuleType, thing: object) -> list[str]:
    return [name for name, value in list(vars(module).items()) if value is thing]


def detour(planner: str) -> Any:
    """Return a situation that no straight line solves and the planner does at once."""
    for k in range(60):
        situation = families.draw("random-planar", 5, k)
        plan = get_planner(planner).plan(situation)
        if plan.caught and not get_planner("straight").plan(situation).caught:
            return situation
    raise AssertionError("no such situation")


def test_there_are_five():
    assert len(WALKS) == 5 and all(len(doors) >= 3 for doors in WALKS.values())


def test_from_json_to_a_solution(called, tmp_path):
    write_situations(tmp_path / "scene.jsonl", [detour("gcm")])
    seen = called(WALKS["From JSON to a solution"])
    from gcm_learn import planners, situation

    (read,) = situation.read_situations(tmp_path / "scene.jsonl")
    planner = planners.get_planner("gcm")
    answer = planners.plan_to_json(planner.plan(read))
    assert answer["status"] == "caught"
    assert seen == WALKS["From JSON to a solution"]


def test_from_a_specification_to_a_shard(called, tmp_path):
    spec_file = tmp_path / "one.toml"
    spec_file.write_text(SPEC)
    seen = called(WALKS["From a specification to a shard"])
    from gcm_learn import dataset

    (tmp_path / "shards").mkdir()
    dataset.make_shard(dataset.read_spec(spec_file), 0, str(tmp_path))
    assert seen == WALKS["From a specification to a shard"]


def test_from_a_situation_to_a_recalled_plan(called):
    situation = detour("recall-1")
    seen = called(WALKS["From a situation to a recalled plan"])
    from gcm_learn import planners

    assert planners.get_planner("recall").plan(situation).caught
    assert seen == WALKS["From a situation to a recalled plan"]


def test_from_an_observation_to_an_action(called):
    situations = [families.draw("gate", 5, k) for k in range(3)]
    seen = called(WALKS["From an observation to an action"])
    from gcm_learn import execution, policies

    actor = policies.shipped_actor("clone")
    pool = execution.pool_of(situations, 3, 0)
    episodes = actor.play(pool, np.arange(len(pool.situations)))
    assert len(episodes.outcomes) == len(pool.situations)
    assert seen == WALKS["From an observation to an action"]


def test_from_an_evaluation_to_a_report(called, tmp_path):
    pytest.importorskip("pyarrow")
    from gcm_learn import evaluation, plots

    seen = called(WALKS["From an evaluation to a report"])
    entries = evaluation.draw_suite("demo", 50)[:4]
    results = evaluation.compare(["straight", "marching"], entries, charge=0, workers=1)
    assert plots.write_report(results, entries, tmp_path).exists()
    assert seen == WALKS["From an evaluation to a report"]
