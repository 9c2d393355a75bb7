"""Suites: nobody compares on other situations than those that were frozen."""

from __future__ import annotations

from dataclasses import replace

import pytest

from gcm_learn import families
from gcm_learn.cli import main
from gcm_learn.errors import FileFormatError, SuiteError, UnknownNameError
from gcm_learn.evaluation import suites
from gcm_learn.evaluation.suites import FROZEN, Entry, draw_suite, hash_of
from gcm_learn.families import family_names
from gcm_learn.situation.canonical import canonical

STRATA = "LWQU"


@pytest.fixture
def entries():
    """Return twelve situations; their strata are made up."""
    drawn = [canonical(families.draw("moving-point", 12, k))[0] for k in range(12)]
    return [
        Entry("demo", k, situation, "moving-point", STRATA[k % 4], 0.5)
        for k, situation in enumerate(drawn)
    ]


@pytest.fixture
def kept(entries, tmp_path, monkeypatch):
    """Keep them as the suite demo, of which the first 3 and the first 8 are frozen."""
    frozen = {count: hash_of(entries[:count]) for count in (8, 3)}
    monkeypatch.setattr(suites, "FROZEN", {"demo": frozen})
    path = tmp_path / "demo.jsonl"
    path.write_text("".join(suites._line(entry) + "\n" for entry in entries))
    return path


def changed(path, number):
    """Give situation `number` of a file another stratum."""
    lines = path.read_text().splitlines(keepends=True)
    old, new = f'"stratum": "{STRATA[number % 4]}"', f'"stratum": "{STRATA[(number + 1) % 4]}"'
    assert old in lines[number]
    lines[number] = lines[number].replace(old, new)
    path.write_text("".join(lines))


def test_what_is_frozen_is_read(kept, entries):
    assert draw_suite("demo", 12, kept.parent) == entries
    assert draw_suite("demo", 5, kept.parent) == entries[:5]


@pytest.mark.parametrize(("number", "first"), [(0, 3), (2, 3), (3, 8), (7, 8)])
def test_every_prefix_that_was_frozen_is_checked(kept, number, first):
    changed(kept, number)
    for count in (1, 5, 12):
        with pytest.raises(SuiteError, match=f"its first {first} have hash .*frozen as"):
            draw_suite("demo", count, kept.parent)


def test_what_follows_the_frozen_ones_is_free(kept, entries):
    changed(kept, 8)
    assert draw_suite("demo", 12, kept.parent)[:8] == entries[:8]


def test_when_the_oracle_catches_is_not_frozen(kept, entries):
    text = "".join(suites._line(replace(entry, earliest=0.25)) + "\n" for entry in entries)
    kept.write_text(text)
    assert {e.earliest for e in draw_suite("demo", 12, kept.parent)} == {0.25}


def test_what_is_drawn_is_checked_before_it_is_kept(kept, entries, monkeypatch):
    kept.unlink()
    monkeypatch.setattr(suites, "_drawn", lambda *given: list(reversed(entries)))
    with pytest.raises(SuiteError, match="its first 3 have hash"):
        draw_suite("demo", 10, kept.parent)
    assert not kept.exists()
    monkeypatch.setattr(suites, "_drawn", lambda *given: entries)
    assert draw_suite("demo", 10, kept.parent) == entries[:10] and kept.exists()


def test_the_command_says_so_in_one_line(kept, tmp_path, capsys):
    changed(kept, 1)
    command = ["evaluate", "--policies", "straight", "--suites", str(kept.parent)]
    assert main([*command, "--count", "4", "--out", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err.strip().splitlines()
    assert "suite 'demo': its first 3 have hash" in said[-1]
    assert not (tmp_path / "out" / "report.html").exists()


def test_what_is_no_suite(kept):
    kept.write_text("{}\n")
    with pytest.raises(FileFormatError, match=r"demo.jsonl:1: is no entry of a suite"):
        draw_suite("demo", 1, kept.parent)
    with pytest.raises(UnknownNameError, match="suite: 'moon' is not one of"):
        draw_suite("moon", 1, kept.parent)


def test_all_suites_are_frozen():
    relabelled = {name for name, suite in suites.SUITES.items() if suite.label == "fast"}
    assert set(FROZEN) == set(suites.suite_names()) - relabelled
    several = ["sequence-space", "sequence-chain"]
    others = [*family_names("spatial"), *family_names("chain"), *several]
    assert relabelled == {"space", "space-demo", "chains", *others}
    assert all(50 in frozen for frozen in FROZEN.values())


@pytest.mark.slow
@pytest.mark.parametrize("name", ["static-clutter", "long-arm"])
def test_suites_are_drawn_as_they_were_frozen(name, tmp_path):
    pytest.importorskip("pyarrow")
    entries = draw_suite(name, 50, tmp_path)
    assert hash_of(entries) == FROZEN[name][50]
