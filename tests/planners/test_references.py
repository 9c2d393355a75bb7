"""Planners and policies from outside: how they are named, found, sent and refused."""

from __future__ import annotations

import sys
import types
from importlib import metadata

import numpy as np
import pytest

from gcm_learn import get_planner, solve
from gcm_learn.errors import GcmError
from gcm_learn.evaluation import ask, get_method
from gcm_learn.families import draw
from gcm_learn.planners import Plan
from gcm_learn.processes import crew_of

SOURCE = """
from gcm_learn import get_planner
class Mine:
    def plan(self, situation):
        return get_planner("straight").plan(situation)
class Policy:
    def act(self, observations):
        import numpy as np
        return np.zeros((len(observations), 2))
class Needy:
    def __init__(self, what):
        pass
class Wrong:
    plan = 3
mine, number = Mine(), 7
def function(situation):
    return mine.plan(situation)
def factory():
    return Mine()
def failing():
    raise OSError("no disk")
class Inner:
    class Deep(Mine):
        pass
"""
SITUATION = draw("crossing-swarm", 12, 0)
CASES = [draw("crossing-swarm", 12, k) for k in range(2)]


@pytest.fixture
def file(tmp_path):
    (tmp_path / "mine.py").write_text(SOURCE)
    return tmp_path / "mine.py"


class Planned:
    """A planner in a module that other processes can import."""

    def plan(self, situation):
        return Plan(situation.name, "", "unreachable", "too tired", 0.0)


@pytest.mark.parametrize("name", ["Mine", "mine", "function", "factory", "Inner.Deep"])
def test_planners_are_found_in_files_and_modules(name, file, monkeypatch):
    wanted = solve(SITUATION, "straight")
    module = types.ModuleType("brought_along")
    exec(SOURCE, module.__dict__)
    monkeypatch.setitem(sys.modules, "brought_along", module)
    for reference in (f"{file}:{name}", f"brought_along:{name}"):
        plan = solve(SITUATION, reference)
        assert (plan.status, plan.catch_time) == (wanted.status, wanted.catch_time)
        assert plan.planner == reference


@pytest.mark.parametrize(
    ("reference", "said"),
    [
        ("{file}:Nobody", "has no 'Nobody'"),
        ("{file}:number", "has no function plan"),
        ("{file}:Needy", "cannot be made"),
        ("{file}:Wrong", "has no function plan"),
        ("{file}:failing", "OSError: no disk"),
        ("{file}", "needs the name of an object"),
        ("{file}x.py:Mine", "there is no file"),
        ("nowhere_at_all:Mine", "cannot be imported"),
        ("nowhere.zip", "there is no such file"),
        ("clone@many", "number of tries"),
    ],
)
def test_references_are_refused_in_one_line(reference, said, file):
    for resolve in (get_planner, get_method):
        with pytest.raises(GcmError) as error:
            resolve(reference.format(file=file))
        assert said in str(error.value) and "\n" not in str(error.value)


@pytest.mark.parametrize("group", ["gcm_learn.planners", "gcm_learn.policies"])
def test_installed_packages_offer_methods(group, file, monkeypatch):
    name = "Mine" if group == "gcm_learn.planners" else "Policy"
    module = types.ModuleType("installed")
    exec(SOURCE, module.__dict__)
    monkeypatch.setitem(sys.modules, "installed", module)
    entry = metadata.EntryPoint("offered", f"installed:{name}", group)
    real = metadata.entry_points
    monkeypatch.setattr(
        metadata,
        "entry_points",
        lambda **asked: (entry,) if asked == {"group": group, "name": "offered"} else real(**asked),
    )
    assert get_method("offered").answer(SITUATION).outcome != "error"
    assert get_planner("offered").plan(SITUATION).status != "error"


def test_columns_have_distinct_names(file):
    methods = ["straight", Planned(), Planned, f"{file}:Mine"]
    sheet = ask(methods, CASES)
    assert sheet.each("entrant") == ["straight", "Planned", "Planned (2)", f"{file}:Mine"]
    own, other = (sheet.where(entrant=n)["outcome"].tolist() for n in ("straight", f"{file}:Mine"))
    assert own == other


def test_methods_travel_to_other_processes(file, monkeypatch):
    monkeypatch.chdir(file.parent)
    here = ask(["mine.py:Mine", Planned()], CASES)
    with crew_of(2) as crew:
        there = ask(["mine.py:Mine", Planned()], CASES, crew=crew)
        with pytest.raises(GcmError, match=r"cannot be sent to worker processes.*path\.py:name"):
            ask([lambda situation: None, "straight"], CASES, crew=crew)
    assert there.each("entrant") == here.each("entrant") == ["mine.py:Mine", "Planned"]
    assert there["outcome"].tolist() == here["outcome"].tolist()


class Silent:
    def act(self, observations):
        return None


class Wide:
    def act(self, observations):
        return np.zeros((len(observations), 3))


class Endless:
    def act(self, observations):
        return np.full((len(observations), 2), np.nan)


@pytest.mark.parametrize("policy", [Silent, Wide, Endless])
def test_policies_that_fail_cost_their_own_rows(policy):
    mine = ask([policy(), "straight"], CASES).where(entrant=policy.__name__)
    assert mine["outcome"].tolist() == ["error"] * 2
    assert all(mine["reason"])
    assert solve(SITUATION, policy()).status == "error"


@pytest.mark.parametrize("name", ["clone", "clone@3"])
def test_solve_takes_trained_actors(name):
    plan = solve(draw("crossing-swarm", 12, 1), name)
    assert plan.planner == name and plan.status in ("caught", "unreachable")


def space(shape, low=-1.0, high=1.0):
    return types.SimpleNamespace(shape=shape, low=np.full(shape, low), high=np.full(shape, high))


@pytest.mark.parametrize(
    ("observations", "actions", "said"),
    [
        (space((3,)), space((2,)), "fit no arena"),
        (space((107,)), space((5,)), "fit no arena"),
        (space((107,)), space((2,), -2.0, 2.0), "from -1 to 1"),
        (space((107,)), types.SimpleNamespace(shape=()), "fit no arena"),
    ],
)
def test_models_whose_spaces_fit_no_arena_are_refused(observations, actions, said):
    model = types.SimpleNamespace(
        observation_space=observations, action_space=actions, predict=lambda row: (row[:2], None)
    )
    with pytest.raises(GcmError, match=said):
        get_method(model)


@pytest.mark.parametrize(("width", "commands", "kind"), [(107, 2, "planar"), (145, 4, "spatial")])
def test_models_act_in_the_arena_that_fits(width, commands, kind):
    model = types.SimpleNamespace(
        observation_space=space((width,)),
        action_space=space((commands,)),
        predict=lambda row: (row[:commands], None),
    )
    assert get_method(model).actor.kind.name == kind
