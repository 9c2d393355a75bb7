"""What does not take spatial arms says so, in one line."""

from __future__ import annotations

import json
import pkgutil

import pytest

from gcm_learn import get_planner, solve
from gcm_learn.arms import SPATIAL as SPATIAL_KIND, kinds
from gcm_learn.cli import main
from gcm_learn.errors import ArmKindError
from gcm_learn.execution import pool_of
from gcm_learn.planners import registry
from gcm_learn.planners.plan import takes
from gcm_learn.situation import situation_from_json
from tests.chains import drawn
from tests.extras import INSTALLED
from tests.refusals import refusal
from tests.situation.scenes import NAO, PLANAR

SPATIAL = situation_from_json(NAO)


def test_every_planner_of_the_plane_refuses():
    """Those that take spatial arms have tests of their own."""
    refusing = [name for name in INSTALLED if not takes(get_planner(name), SPATIAL_KIND)]
    assert {"gcm", "layered"} <= set(refusing)
    for name in refusing:
        for ask in (get_planner(name).plan, lambda s, name=name: solve(s, name)):
            expected = f"planner '{name}' does not take spatial arms"
            assert refusal(ArmKindError, ask, SPATIAL).startswith(expected)


@pytest.mark.parametrize(("name", "instead"), [("gcm", "marching"), ("layered", "search")])
def test_the_name_of_a_planner_that_takes_the_arm_is_told(name, instead):
    for situation in (SPATIAL, situation_from_json(drawn("panda", 0))):
        for ask in (get_planner(name).plan, lambda s: solve(s, name)):
            with pytest.raises(ArmKindError, match=rf"planner '{name}' .*; '{instead}' does$"):
                ask(situation)


def test_the_arena_refuses_files_and_situations(tmp_path):
    path = tmp_path / "scenes.jsonl"
    path.write_text(json.dumps(NAO))
    for source in (SPATIAL, [SPATIAL], path, str(path)):
        with pytest.raises(ArmKindError, match="the arena does not take spatial arms"):
            pool_of(source, 1, 0)


@pytest.mark.parametrize("chosen", [[], ["--index", "1"]])
def test_solve_refuses_before_anything_is_planned_or_written(chosen, tmp_path, capsys):
    path, out = tmp_path / "scenes.jsonl", tmp_path / "out.jsonl"
    path.write_text(f"{json.dumps(PLANAR)}\n{json.dumps(NAO)}\n")
    assert main(["solve", str(path), "--planner", "gcm", "--out", str(out), *chosen]) == 2
    printed, complained = capsys.readouterr()
    assert printed == "" and not out.exists()
    assert complained == (
        "gcm-learn: planner 'gcm' does not take spatial arms (situation \"nao\"); 'marching' does\n"
    )


@pytest.mark.parametrize("name", sorted(registry._PLANNERS))
def test_factories_are_found(name):
    place = registry._PLANNERS[name]
    taken = [kind for kind in kinds() if isinstance(place, str) or place.takes(kind)]
    for one in {place if isinstance(place, str) else place.of(kind) for kind in taken}:
        assert callable(pkgutil.resolve_name(f"gcm_learn.planners.{one}"))
