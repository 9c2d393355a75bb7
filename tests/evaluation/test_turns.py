"""Suites of one stratum: the first draws of it, whoever asks."""

from __future__ import annotations

import json

import pytest

from gcm_learn import dataset, families, planners
from gcm_learn.evaluation import suites, turns
from gcm_learn.situation import situation_from_json, situation_to_json
from gcm_learn.situation.canonical import canonical


@pytest.fixture
def asked(monkeypatch):
    """Let draws be quick, and note which were made."""
    numbers = []

    def quick(number, seed):
        numbers.append(number)
        if number % 7 == 6:
            return None
        situation, _ = canonical(families.draw("moving-point", 5, number % 5))
        return {
            "index": number, "family": "moving-point", "stratum": "LWQU"[number % 4],
            "earliest": None, "situation": situation_to_json(situation),
        }  # fmt: skip

    monkeypatch.setattr(turns, "drawn", quick)
    return numbers


def test_the_first_of_a_stratum_in_order(asked, tmp_path):
    lines = suites.draw_suite("W", 20, tmp_path)
    wanted = [k for k in range(200) if k % 4 == 1 and k % 7 != 6]
    assert [line["index"] for line in lines] == wanted[:20]
    assert {(line["suite"], line["stratum"]) for line in lines} == {("W", "W")}


def test_what_is_drawn_for_one_is_drawn_for_all(asked, tmp_path):
    many = suites.draw_suite("Q", 25, tmp_path, 1)
    seen = len(asked)
    assert seen == len(set(asked)) and seen % turns.CHUNK == 0
    suites.draw_suite("L", 20, tmp_path, 1)
    assert len(asked) == seen
    few = suites.draw_suite("Q", 10, tmp_path / "elsewhere", 1)
    assert suites.hash_of(few) == suites.hash_of(many[:10])


def test_a_seed_draws_a_mix_anew(monkeypatch, tmp_path):
    made = []
    monkeypatch.setattr(dataset, "generate", lambda spec, *at, **how: made.append((spec.seed, *at)))
    monkeypatch.setattr(dataset, "open", lambda folder: [])
    assert suites.draw_suite("natural", 25, tmp_path, 1, seed=7) == []
    assert made == [(7, tmp_path / "7" / "natural", 1)]


def test_a_cluster_draws_the_same_and_goes_on_where_another_stopped(asked, scheduler, tmp_path):
    for folder, more in (("here", {}), ("there", {"cluster": scheduler})):
        with pytest.raises(KeyboardInterrupt):
            suites.draw_suite("W", 12, tmp_path / folder, 1, progress=stop, **more)
        assert len(list((tmp_path / folder / turns.FOLDER).iterdir())) >= 1
        assert len(suites.draw_suite("W", 12, tmp_path / folder, 1, **more)) == 12
    files = [sorted(tmp_path.joinpath(f).rglob("draws_*")) for f in ("here", "there")]
    for here, there in zip(*files, strict=False):
        assert here.name == there.name and here.read_bytes() == there.read_bytes()


def stop(found):
    raise KeyboardInterrupt


def test_draws_are_functions_of_their_number():
    first, again = turns.drawn(3), turns.drawn(3)
    assert json.dumps(first) == json.dumps(again)
    situation = situation_from_json(first["situation"])
    assert situation.arm.hand[1] == 0.0 and situation.arm.elbow == "right"
    assert first["family"] == families.family_names()[3]
    caught = planners.solve(situation, "straight").caught
    assert caught == (first["stratum"] == "L")


def test_later_draws_pass_over_what_is_easy(monkeypatch):
    easy = next(k for k in range(40) if (turns.drawn(k) or {}).get("stratum") == "L")
    monkeypatch.setattr(turns, "ENOUGH", easy)
    assert turns.drawn(easy) is None


def test_a_family_that_comes_later_changes_no_suite(monkeypatch):
    """Draw k is of the same family whatever else is registered."""
    from gcm_learn.families import family_names, registry

    assert set(turns.FAMILIES) <= set(family_names()) and len(set(turns.FAMILIES)) == 19
    before = [turns.drawn(k) for k in (1, 3)]
    later = {"a-new-one": registry._FAMILIES["gate"], **registry._FAMILIES}
    monkeypatch.setattr(registry, "_FAMILIES", later)
    assert [turns.drawn(k) for k in (1, 3)] == before
