"""Nobody is evaluated on draws that something was trained on."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from gcm_learn import seeding
from gcm_learn.evaluation import draw_suite, suites, turns
from gcm_learn.families import family_names
from gcm_learn.situation.canonical import canonical

DATA = Path(__file__).parents[2] / "data"


def test_suites_have_seeds_of_their_own():
    trained = {tomllib.loads(path.read_text())["seed"] for path in DATA.rglob("*.toml")}
    mixed = [suite.seed for name, suite in suites.SUITES.items() if name not in family_names()]
    seeds = [turns.SEED, *mixed, *{suites.SUITES[name].seed for name in family_names()}]
    assert len(trained) == 8 and not trained & set(seeds)
    assert len(seeds) == len(set(seeds)) == 10


def test_draws_in_turn_depend_on_their_seed(monkeypatch):
    first = turns.drawn(3)
    monkeypatch.setattr(turns, "SEED", turns.SEED + 1)
    assert turns.drawn(3)["situation"]["bodies"] != first["situation"]["bodies"]


def test_the_suite_that_ships_was_drawn_under_its_seed():
    pytest.importorskip("pyarrow")
    spec = suites.SUITES["demo"].spec("demo", 50)
    for entry in draw_suite("demo", 50, DATA / "suites")[:4]:
        assert entry.situation in draws(spec, entry.index)


def draws(spec, index, most=300):
    """What item `index` of a specification may be, in canonical form."""
    for attempt in range(most):
        source = seeding.rng(spec.seed, index, attempt)
        family = spec.choose(source)
        yield canonical(family.draw(source, f"{spec.name}-{index}"))[0]
