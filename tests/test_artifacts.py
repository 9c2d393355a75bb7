"""Where models and suites are found: what is given, then the user's, then what is shipped."""

import pytest

from gcm_learn import artifacts
from gcm_learn.errors import EncoderError, PolicyError, RecallError
from gcm_learn.evaluation import suites
from gcm_learn.execution.arena.settings import encoder
from gcm_learn.policies.actor import actor_names, shipped_actor
from gcm_learn.recall import has_memory, shipped_memory


@pytest.fixture
def places(tmp_path, monkeypatch):
    """The three folders of models, empty: given, the user's, shipped; no checkout."""
    given, users, package = tmp_path / "given", tmp_path / "users", tmp_path / "package"
    monkeypatch.setenv("GCM_LEARN_MODELS", str(given))
    monkeypatch.delenv("GCM_LEARN_DATA", raising=False)
    monkeypatch.setattr(artifacts, "user_data", lambda name: users / name)
    monkeypatch.setattr(artifacts, "PACKAGE", package)
    return given, users / "models", package / "_shipped" / "models"


def put(folder, name, file="actor.npz"):
    (folder / name).mkdir(parents=True)
    (folder / name / file).write_text("")
    return folder / name


def test_the_first_folder_that_has_it_wins(places):
    assert artifacts.folders("models") == list(places)
    assert artifacts.model("clone", "actor.npz") is None
    for folder in reversed(places):
        here = put(folder, "clone")
        assert artifacts.model("clone", "actor.npz") == here
        assert artifacts.models("actor.npz") == {"clone": here}


def test_models_of_all_folders_are_listed(places):
    given, users, shipped = places
    for folder, name in ((given, "c"), (users, "a"), (shipped, "b")):
        put(folder, name)
    put(shipped, "encoder", "config.json")
    assert actor_names() == ["a", "b", "c"]


def test_what_lacks_the_file_is_passed_over(places):
    given, _, shipped = places
    put(given, "recall", "card.md")
    assert artifacts.model("recall", "manifest.json") is None and not has_memory()
    there = put(shipped, "recall", "manifest.json")
    assert artifacts.model("recall", "manifest.json") == there and has_memory()


def test_what_is_missing_is_said_with_every_place_and_a_way_out(places):
    encoder.cache_clear()
    for error, ask in (
        (RecallError, lambda: shipped_memory("recall")),
        (PolicyError, lambda: shipped_actor("clone")),
        (EncoderError, encoder),
    ):
        with pytest.raises(error) as caught:
            ask()
        message = str(caught.value)
        assert all(str(place) in message for place in places) and "\n" not in message
        assert "make one with 'gcm-learn" in message and "set GCM_LEARN_MODELS" in message
        assert f"--out {places[0]}" in message


def test_nothing_is_kept_in_the_package(places, tmp_path, monkeypatch):
    assert artifacts.kept("data") == tmp_path / "users" / "data"
    monkeypatch.setenv("GCM_LEARN_DATA", str(tmp_path / "mine"))
    assert artifacts.kept("data") == tmp_path / "mine"


def test_a_checkout_ships_and_keeps_its_own_folders(monkeypatch):
    monkeypatch.delenv("GCM_LEARN_DATA", raising=False)
    root = artifacts.PACKAGE.parent
    assert artifacts.shipped("models") == root / "models"
    assert artifacts.kept("data") == root / "data"


def test_a_suite_is_read_where_it_is_and_kept_where_one_may_write(places, tmp_path, monkeypatch):
    kept = tmp_path / "users" / "data" / "suites"
    entries = suites.draw_suite("L", 2, tmp_path / "drawn", 1)
    monkeypatch.setattr(suites, "_drawn", lambda name, count, *rest: entries[:count])
    suites.draw_suite("L", 1)
    assert [p.name for p in kept.iterdir()] == ["L.jsonl"]
    shipped = artifacts.shipped("data") / "suites"
    shipped.mkdir(parents=True)
    (kept / "L.jsonl").replace(shipped / "L.jsonl")
    assert suites.draw_suite("L", 1) == entries[:1] and not list(kept.iterdir())
    assert suites.draw_suite("L", 2) == entries and (kept / "L.jsonl").exists()
