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
from gcm_learn.execution import PhysicalSettings, Settings, SpatialSettings
from gcm_learn.situation import situation_from_json
from tests.chains import drawn

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
map = "{}"
planners = ["{}"]
rungs = 1
[[families]]
family = "{}"
"""
PLANAR_ONLY = {("maps", "build_map"), ("maps", "descend"), ("planners", "attempt_of")}
DRAWN = {
    "planar": lambda planner: detour(planner),
    "spatial": lambda _: families.draw("window-space", 1, 0),
    "chain": lambda _: situation_from_json(drawn("planar-2", 0)),
}


@pytest.fixture
def called(monkeypatch) -> Callable[[list[tuple[str, str]]], list[tuple[str, str]]]:
    """Return a function that has calls of some doors written down, wherever they were taken."""

    def watch(doors: list[tuple[str, str]]) -> list[tuple[str, str]]:
        seen: list[tuple[str, str]] = []
        for folder, name in doors:
            door = importlib.import_module(f"gcm_learn.{folder}")
            assert name in dir(door), f"{folder} does not offer {name}"
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


def walk_of(title: str, kind: str) -> list[tuple[str, str]]:
    """Return the doors of a walk, but for those of maps and of hand paths where there are none."""
    return [door for door in WALKS[title] if kind == "planar" or door not in PLANAR_ONLY]


def test_there_are_five():
    assert len(WALKS) == 5 and all(len(doors) >= 3 for doors in WALKS.values())


@pytest.mark.parametrize(
    ("kind", "planner"), [("planar", "gcm"), ("spatial", "search"), ("chain", "search")]
)
def test_from_json_to_a_solution(kind, planner, called, tmp_path):
    write_situations(tmp_path / "scene.jsonl", [DRAWN[kind](planner)])
    title = "From JSON to a solution"
    seen = called(WALKS[title])
    from gcm_learn import planners, situation

    (read,) = situation.read_situations(tmp_path / "scene.jsonl")
    answer = planners.plan_to_json(planners.get_planner(planner).plan(read), read)
    assert answer["status"] == "caught"
    once = seen if kind == "planar" else list(dict.fromkeys(seen))  # a straight line is tried first
    assert once == walk_of(title, kind)


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        ("planar", ("marching", "marching", "random-planar")),
        ("spatial", ("none", "straight", "window-space")),
    ],
)
def test_from_a_specification_to_a_shard(kind, words, called, tmp_path):
    spec_file, title = tmp_path / "one.toml", "From a specification to a shard"
    spec_file.write_text(SPEC.format(*words))
    seen = called(WALKS[title])
    from gcm_learn import dataset

    (tmp_path / "shards").mkdir()
    dataset.make_shard(dataset.read_spec(spec_file), 0, str(tmp_path))
    assert seen == walk_of(title, kind)


@pytest.mark.parametrize("kind", ["planar", pytest.param("spatial", marks=pytest.mark.slow)])
def test_from_a_situation_to_a_recalled_plan(kind, called):
    situation, title = DRAWN[kind]("recall-1"), "From a situation to a recalled plan"
    seen = called(WALKS[title])
    from gcm_learn import planners

    assert planners.get_planner("recall").plan(situation).caught
    assert seen == walk_of(title, kind)


@pytest.mark.parametrize(
    ("name", "family", "settings"),
    [
        ("clone", "gate", Settings()),
        ("ppo-space", "crossing-swarm-space", SpatialSettings()),
        ("ppo-space", "crossing-swarm-space", PhysicalSettings()),
    ],
    ids=["planar", "spatial", "body"],
)
def test_from_an_observation_to_an_action(name, family, settings, called):
    title = "From an observation to an action"
    seen = called(WALKS[title])
    from gcm_learn import execution, policies

    actor = policies.shipped_actor(name)
    pool = execution.pool_of(family, 3, 0, settings)
    episodes = actor.play(pool, np.arange(len(pool.situations)))
    assert len(episodes.outcomes) == len(pool.situations)
    assert seen == WALKS[title]


@pytest.mark.parametrize(
    ("kind", "planners"),
    [
        ("planar", ["straight", "marching"]),
        ("spatial", ["straight", "search"]),
        ("chain", ["search", "straight-wait"]),
    ],
)
def test_from_a_comparison_to_its_page(kind, planners, called, tmp_path):
    pytest.importorskip("pyarrow")
    from gcm_learn import evaluation

    title = "From a comparison to its page"
    seen = called(WALKS[title])
    found = evaluation.cases(*(["demo"] if kind == "planar" else [DRAWN[kind]("")]), count=4)
    sheet = evaluation.ask(planners, found)
    assert evaluation.page(sheet, tmp_path).exists()
    assert seen == WALKS[title]
