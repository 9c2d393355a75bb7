"""Nobody is evaluated on draws that something was trained on."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from gcm_learn import seeding
from gcm_learn.evaluation import cases, suites, turns
from gcm_learn.situation.canonical import canonical

DATA = Path(__file__).parents[2] / "data"


def test_suites_have_seeds_of_their_own():
    specs = [*DATA.glob("specs/*.toml"), *DATA.glob("*/spec.toml")]
    trained = {tomllib.loads(path.read_text())["seed"] for path in specs}
    seeds = [turns.SEED, *(draw.seed for draw in suites.DRAWN.values())]
    assert len(trained) == 10 and not trained & set(seeds)
    assert len(seeds) == len(set(seeds)) == 7


def test_draws_in_turn_depend_on_their_seed():
    first, other = turns.drawn(3), turns.drawn(3, turns.SEED + 1)
    assert other["situation"]["bodies"] != first["situation"]["bodies"]


def test_the_suite_that_ships_was_drawn_under_its_seed():
    pytest.importorskip("pyarrow")
    spec = suites.DRAWN["demo"].spec("demo", 50)
    for index, case in enumerate(cases("demo", count=50)[:4]):
        assert case.situation in draws(spec, index)


def draws(spec, index, most=300):
    """What item `index` of a specification may be, in canonical form."""
    for attempt in range(most):
        source = seeding.rng(spec.seed, index, attempt)
        family = spec.choose(source)
        yield canonical(family.draw(source, f"{spec.name}-{index}"))[0]
