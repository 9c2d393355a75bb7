"""Cases: suites that ship, drawn suites, families and files."""

from __future__ import annotations

import gzip
import json
from pathlib import Path

import pytest

from gcm_learn import artifacts, families
from gcm_learn.errors import FileFormatError, SuiteError, UnknownNameError
from gcm_learn.evaluation import SHIPPED, Case, cases, check_sources, suites
from gcm_learn.evaluation.suites import DRAWN, FROZEN, draw_suite, drawn_names, hash_of
from gcm_learn.planners import solve
from gcm_learn.situation import situation_to_json
from gcm_learn.situation.canonical import canonical

ROOT = Path(__file__).parents[2]
STRATA = "LWQU"


@pytest.mark.parametrize("name", SHIPPED)
def test_shipped_suites_are_as_they_were_frozen(name):
    suite = SHIPPED[name]
    warm_up, *found = cases(name)
    assert len({case.key for case in found}) == len(found) == suite.count
    assert warm_up.stratum == "warm-up" and warm_up.key not in {case.key for case in found}
    assert {case.stratum for case in found} <= {"L", "W", "Q", "U", "open", ""}
    assert suite.licence and suite.card and {case.suite for case in found} == {name}
    assert f"| `{name}` |" in (ROOT / "docs" / "benchmark.md").read_text("utf-8")
    assert len(cases(name, count=3)) == 4


def test_a_changed_suite_is_refused(tmp_path, monkeypatch):
    suite = SHIPPED["plane"]
    content = suite.content()
    place = tmp_path / suite.file
    place.parent.mkdir()
    place.write_bytes(gzip.compress(content.replace(b'"L"', b'"W"', 1)))
    monkeypatch.setenv(artifacts.VARIABLES["data"], str(tmp_path))
    with pytest.raises(SuiteError, match="was frozen as"):
        cases("plane")


def test_suites_are_small():
    sizes = [artifacts.find("data", suite.file).stat().st_size for suite in SHIPPED.values()]
    assert sum(sizes) < 1.5e6


def test_families_and_presets_are_drawn_by_count_and_seed():
    found = cases("gate", "panda-easy", count=2, seed=5)
    wanted = [families.draw(name, 5, k) for name in ("gate", "panda-easy") for k in range(2)]
    assert [case.situation for case in found] == wanted
    assert [case.suite for case in found] == ["gate", "gate", "panda-easy", "panda-easy"]
    assert cases("panda-easy", count=1)[-1].key not in {case.key for case in found}


def test_a_file_of_an_arm_that_it_names_is_told_with_the_arm(tmp_path):
    drawn = families.draw("throw-chain", 1, 0)
    given = situation_to_json(drawn)
    model = given["arm"]["model"]
    arm = model if isinstance(model, dict) else json.loads(
        next((ROOT / "gcm_learn/arms/models").glob(f"{model}.json")).read_text("utf-8")
    )  # fmt: skip
    (tmp_path / "arm.json").write_text(json.dumps(arm), "utf-8")
    path = tmp_path / "scene.json"
    path.write_text(json.dumps(given | {"arm": given["arm"] | {"model": "arm.json"}}), "utf-8")
    (case,) = cases(path)
    assert json.loads(case.text)["arm"]["model"] == arm and solve(case.situation) is not None


@pytest.mark.parametrize(
    ("source", "error", "line"),
    [
        ("moon", UnknownNameError, "suite or family: 'moon' is not one of"),
        ("panda-esy", UnknownNameError, "panda-easy"),
        ("si-rrt", SuiteError, "gcm-learn convert si-rrt"),
        ("none.jsonl", FileFormatError, "none.jsonl: cannot be read"),
    ],
)
def test_unknown_sources_are_refused_in_one_line(source, error, line):
    for ask in (lambda: check_sources([source]), lambda: cases(source)):
        with pytest.raises(error, match=line):
            ask()


@pytest.fixture
def lines():
    """Return lines of twelve situations; their strata are made up."""
    drawn = [canonical(families.draw("moving-point", 12, k))[0] for k in range(12)]
    return [
        {"suite": "demo", "index": k, "family": "moving-point", "stratum": STRATA[k % 4],
         "earliest": 0.5, "situation": situation_to_json(situation)}
        for k, situation in enumerate(drawn)
    ]  # fmt: skip


@pytest.fixture
def kept(lines, tmp_path, monkeypatch):
    """Keep them as the suite demo, of which the first 3 and the first 8 are frozen."""
    frozen = {count: hash_of(lines[:count]) for count in (8, 3)}
    monkeypatch.setattr(suites, "FROZEN", {"demo": frozen})
    path = tmp_path / "demo.jsonl"
    path.write_text("".join(json.dumps(line) + "\n" for line in lines))
    return path


@pytest.mark.parametrize(("number", "first"), [(0, 3), (2, 3), (3, 8), (7, 8), (8, 0)])
def test_every_prefix_that_was_frozen_is_checked(kept, lines, number, first):
    changed = [dict(line) for line in lines]
    changed[number]["stratum"] = "open"
    kept.write_text("".join(json.dumps(line) + "\n" for line in changed))
    for count in (1, 5, 12):
        if first:
            with pytest.raises(SuiteError, match=f"its first {first} have hash .*frozen as"):
                draw_suite("demo", count, kept.parent)
        else:
            assert draw_suite("demo", count, kept.parent)[:8] == lines[: min(count, 8)]


def test_what_is_drawn_is_checked_before_it_is_kept(kept, lines, monkeypatch):
    kept.unlink()
    monkeypatch.setattr(suites, "_drawn", lambda *given: lines[::-1])
    with pytest.raises(SuiteError, match="its first 3 have hash"):
        draw_suite("demo", 10, kept.parent)
    assert not kept.exists()
    monkeypatch.setattr(suites, "_drawn", lambda *given: lines)
    assert draw_suite("demo", 10, kept.parent) == lines[:10] and kept.exists()


def test_when_the_oracle_catches_is_not_frozen(lines):
    assert hash_of([line | {"earliest": None} for line in lines]) == hash_of(lines)


def test_all_drawn_suites_are_frozen_but_those_in_space():
    assert set(FROZEN) == set(drawn_names()) - {"space-demo"}
    assert all(50 in frozen for frozen in FROZEN.values())


def test_the_demo_ships():
    found = cases("demo", count=50)
    assert len(found) == 50 and {case.stratum for case in found} == set("LWQU")
    assert isinstance(found[0], Case) and found[0].earliest > 0.0


@pytest.mark.slow
@pytest.mark.parametrize("name", ["held-out", "long-arm"])
def test_suites_are_drawn_as_they_were_frozen(name, tmp_path):
    pytest.importorskip("pyarrow")
    assert hash_of(draw_suite(name, 50, tmp_path)) == FROZEN[name][50] and name in DRAWN
