"""What docs/api.md lists as public is there, and documents import nothing else."""

from __future__ import annotations

import ast
import dataclasses
import importlib
import re

import pytest

from gcm_learn import Plan
from gcm_learn.arms import CHAIN, PLANAR, SPATIAL
from gcm_learn.planners import get_planner, is_registered, takes
from tests.test_documents import BESIDE, DOCUMENTS, ROOT, blocks

PAGE = (ROOT / "docs" / "api.md").read_text("utf-8")
ROWS = re.findall(r"^\| `(gcm_learn[\w.]*)` \| (.*) \|$", PAGE, re.M)
PUBLIC = {module: set(re.findall(r"`(\w+)`", names)) for module, names in ROWS}
ARENAS = re.findall(r"^\| `(\w+-v0)` \| (\d+) \| (\d+) \|$", PAGE, re.M)


def named_in(begin: str) -> list[str]:
    """Return what is set as code in the sentence that begins so."""
    return re.findall(r"`([\w-]+)`", re.search(rf"{begin}[^.]*\.", PAGE)[0])


@pytest.mark.parametrize("module", PUBLIC)
def test_public_names_exist(module):
    found = importlib.import_module(module)
    assert [name for name in PUBLIC[module] if not hasattr(found, name)] == []


def examples():
    """Yield code of documents and notebooks with its place."""
    for path in [*DOCUMENTS, *BESIDE]:
        for code in blocks(path, "python"):
            yield path, code
    for path in sorted((ROOT / "docs" / "notebooks").glob("*.py")):
        yield path, re.sub(r"^# %.*$", "", path.read_text("utf-8"), flags=re.M)


def test_documents_import_public_names_only():
    for path, code in examples():
        for node in ast.walk(ast.parse(code)):
            if isinstance(node, ast.ImportFrom) and str(node.module).startswith("gcm_learn"):
                known = PUBLIC.get(str(node.module), set())
                for name in (one.name for one in node.names):
                    assert name in known or f"{node.module}.{name}" in PUBLIC, (path.name, name)


def test_plans_have_what_is_promised():
    assert {field.name for field in dataclasses.fields(Plan)} >= set(named_in("A `Plan` has")[1:])


def test_planners_take_the_arms_that_are_promised():
    every, plane = named_in("Planners for every arm"), named_in("Planar arms have")
    oracle, covered = named_in("Planar and spatial arms have")
    assert (len(every), plane, oracle) == (6, ["gcm", "layered"], "oracle")
    assert is_registered(covered)
    for kind in (PLANAR, SPATIAL, CHAIN):
        taken = [name for name in (*every, *plane, oracle) if takes(get_planner(name), kind)]
        others = {PLANAR: [*plane, oracle], SPATIAL: [oracle], CHAIN: []}
        assert taken == every + others[kind]


@pytest.mark.parametrize(("name", "action", "observation"), ARENAS)
def test_environments_have_the_spaces_that_are_promised(name, action, observation):
    gymnasium = pytest.importorskip("gymnasium")
    if "Physics" in name:
        pytest.importorskip("mujoco")
    env = gymnasium.make(f"gcm_learn:{name}", pool=1)
    spaces = (env.action_space, action, 1), (env.observation_space, observation, 10)
    for space, size, bound in spaces:
        assert space.shape == (int(size),) and space.dtype == "float32"
        assert (space.low == -bound).all() and (space.high == bound).all()


def test_all_environments_are_listed():
    from gcm_learn.execution.arenas import ARENAS as known

    assert len(ARENAS) == len(known) == 5
