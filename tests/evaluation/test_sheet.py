"""Sheets: the file, its columns, and measures by hand."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from gcm_learn import evaluation
from gcm_learn.errors import FileFormatError, SuiteError
from gcm_learn.evaluation.report import verdict
from tests.evaluation.worlds import boasting, failing, moving, scene

CASES = (("near", "L"), ("round", "W"), ("wait", "Q"), ("far", "U"))


def made(entrants, **more):
    """Return a sheet of four cases: by entrant, outcome, ms and catch time of each."""
    rows = [
        {
            "suite": "made", "name": name, "key": name, "family": "gate", "stratum": stratum,
            "entrant": entrant, "thinking": "0 ms", "charged": 0.0, "noise": 0.0, "limit": 60.0,
            "outcome": outcome, "ms": ms, "factor": 1.0, "catch_time": time, "wanted": 1,
            "targets": int(outcome == "caught"), "situation": json.dumps({"name": name}), **more,
        }
        for entrant, answers in entrants.items()
        for (name, stratum), (outcome, ms, time) in zip(CASES, answers, strict=True)
    ]  # fmt: skip
    return evaluation.Sheet.of(rows)


QUICK = [
    ("caught", 0.4, 0.5),
    ("caught", 6.0, 1.0),
    ("declined", 900.0, None),
    ("declined", 2, None),
]
SLOW = [("caught", 50.0, 0.75), ("broken", 1, None), ("caught", 50.0, 2.0), ("error", 70, None)]


def test_shares_count_what_can_be_caught_and_the_rest_by_stratum():
    sheet = made({"quick": QUICK, "slow": SLOW})
    found = evaluation.shares(sheet)
    assert found["caught [%]"] == [evaluation.wilson(2, 3)] * 2 and found["situations"] == [3, 3]
    assert found["broken [%]"] == pytest.approx([0.0, 1 / 3])
    assert found["median [ms]"] == pytest.approx([6.0, 50.0])
    by = {row[:2]: row[3].value for row in evaluation.shares(sheet, ("entrant", "stratum")).rows}
    assert by["quick", "U"] == 1.0 and by["slow", "U"] == 0.0 and by["slow", "W"] == 0.0
    assert "| quick | 3 | 66.7 (21–" in str(found)


def test_a_slow_machine_makes_times_shorter():
    sheet = made({"one": QUICK}, factor=0.5)
    assert evaluation.shares(sheet)["median [ms]"] == pytest.approx([3.0])
    times, up = evaluation.measures.curve(sheet.reachable)
    assert times == pytest.approx([0.2, 3.0]) and up == pytest.approx([1 / 3, 2 / 3])
    assert evaluation.measures.within(sheet.reachable)[:2] == pytest.approx([1 / 3, 2 / 3])


def test_pairs_are_exact_and_corrected():
    best, none = (
        [("caught", 1.0, 1.0)] * 3 + [("declined", 1.0, None)],
        [("declined", 1.0, None)] * 4,
    )
    sheet = made({"z": best, "b": none, "a": none})
    assert evaluation.measures.best_of(sheet) == "z"
    found = evaluation.pairs(sheet, "z")
    alone = evaluation.mcnemar(np.zeros(3, bool), np.ones(3, bool))[2]
    assert found["pair"] == ["b – z", "a – z"] and found["only second"] == [3, 3]
    assert found["p (Holm)"] == pytest.approx([2 * alone] * 2)
    (told,) = evaluation.pairs(sheet, [("z", "a")])["difference [points]"]
    assert told.value == 1.0
    with pytest.raises(SuiteError, match="'a' and 'z' have not answered the same situations"):
        evaluation.pairs(sheet.where((sheet["entrant"] != "a") | (sheet["name"] != "near")), "z")


def test_more_targets_come_before_earlier_catches():
    one, two = [("caught", 1.0, 0.1)] * 4, [("caught", 1.0, 0.9)] * 4
    sheet = evaluation.Sheet.joined(
        made({"one": one}, wanted=3), made({"two": two}, wanted=3, targets=2)
    )
    assert evaluation.measures.best_of(sheet) == "two" and evaluation.pairs(sheet, "one")[
        "only first"
    ] == [3]
    assert all(math.isnan(value) for value in evaluation.measures.ratios(sheet).values())


def test_beside_a_catch_at_once_no_ratio_counts():
    once = [("caught", 1.0, 0.0), ("caught", 1.0, 3.0), *SLOW[:2]]
    late = [("caught", 1.0, 0.5), ("caught", 1.0, 1.0), *SLOW[1:2] * 2]
    found = evaluation.measures.ratios(made({"once": once, "late": late}))
    assert found["late"] == 1.0 and found["once"] == pytest.approx((1.0 + 3.0 + 1.0) / 3)


def test_the_best_and_the_quickest_of_the_good_are_named():
    text = verdict(made({"slow": [("caught", 90.0, 1.0)] * 4, "quick": QUICK}))
    assert "slow catches most: 100 %" in text and "quick does: 67 % after 6 ms" in text
    hopeless = made({"a": QUICK}, stratum="U")
    assert verdict(hopeless) == "None of these situations can be caught."


def test_a_sheet_is_read_as_it_was_written_and_by_pandas(suite, tmp_path):
    pandas = pytest.importorskip("pandas")
    sheet = evaluation.ask(["straight", failing], str(suite))
    path = sheet.save(tmp_path / "sheet.parquet")
    again = evaluation.Sheet.load(path)
    for name, column in sheet.columns.items():
        np.testing.assert_array_equal(again[name], column, name)
    assert again.runs == sheet.runs and again.entrants == sheet.entrants
    table = pandas.read_parquet(path)
    assert table.groupby("entrant").outcome.apply(list)["straight"] == [
        "caught",
        "caught",
        "declined",
    ]
    run = sheet.runs[0]
    assert run["calibration"]["factor"] == 1.0 and run["machine"]["processor"] and run["package"]


@pytest.mark.parametrize(
    ("change", "line"),
    [
        ({"outcome": "won"}, "outcome: 'won' is not one of caught"),
        ({"ms": -1.0}, "ms: must be from 0"),
        ({"factor": 0.0 - 1.0}, "factor: must be from 0"),
        ({"factor": math.nan}, "factor: must be from 0"),
        ({"nodes": -5}, "nodes: must be from 0 on"),
    ],
)
def test_files_are_checked_and_name_the_column(tmp_path, change, line):
    pytest.importorskip("pyarrow")
    path = made({"a": QUICK}, **change).save(tmp_path / "bad.parquet")
    with pytest.raises(FileFormatError, match=line):
        evaluation.Sheet.load(path)


def test_what_is_no_sheet_is_refused(tmp_path):
    pyarrow = pytest.importorskip("pyarrow")
    from pyarrow import parquet

    (tmp_path / "text.parquet").write_text("no")
    parquet.write_table(pyarrow.table({"a": [1]}), tmp_path / "other.parquet")
    for name, line in (
        ("text", "is no sheet"),
        ("other", "format: is not"),
        ("none", "is no sheet"),
    ):
        with pytest.raises(FileFormatError, match=line):
            evaluation.Sheet.load(tmp_path / f"{name}.parquet")


def test_two_of_one_name_are_told_apart(suite, tmp_path):
    pytest.importorskip("pyarrow")
    for name, entrant in (("a", "straight"), ("b", "straight"), ("c", boasting)):
        evaluation.ask([entrant], str(suite)).save(tmp_path / f"{name}.parquet")
    sheet = evaluation.read_sheets([tmp_path])
    assert sheet.each("entrant") == ["straight", "straight (2)", "boasting"]
    assert [run["entrants"] for run in sheet.runs] == [[name] for name in sheet.each("entrant")]
    assert set(sheet.where(entrant="boasting")["outcome"]) == {"broken"}


def test_situations_of_shipped_suites_are_those_that_ship(tmp_path):
    pytest.importorskip("pyarrow")
    made({"a": QUICK}, suite="plane").save(tmp_path / "mine.parquet")
    with pytest.raises(SuiteError, match=r"mine\.parquet: 'near' is not of the suite 'plane'"):
        evaluation.read_sheets([tmp_path / "mine.parquet"])


def test_our_results_are_of_the_suites_that_ship():
    pytest.importorskip("pyarrow")
    from gcm_learn.evaluation import SHIPPED, cases
    from gcm_learn.evaluation.judging import OURS

    folder = "data/" + OURS
    from pathlib import Path

    root = Path(__file__).parents[2]
    files = sorted((root / folder).glob("*.parquet"))
    assert {"search", "straight", "recall"} <= {path.stem for path in files}
    known = {name: {case.key for case in cases(name)[1:]} for name in SHIPPED}
    for path in files:
        sheet = evaluation.Sheet.load(path)
        assert sheet.each("entrant") == [path.stem] and path.stem in sheet.entrants
        for suite in sheet.each("suite"):
            assert set(sheet.where(suite=suite)["key"]) == known[suite]


def test_the_page_shows_what_there_is(suite, tmp_path):
    rock = moving("obstacle", (1.35, 0.3), (0.0, 0.0))
    behind = scene(moving("target", (1.2, 0.6), (0.0, 0.0)), rock, name="behind")
    from gcm_learn.evaluation import Condition, cases

    conditions = [Condition(), Condition(0.02), Condition("own"), Condition(noise=0.02)]
    sheet = evaluation.ask(["straight", "search", boasting], [*cases(suite), behind], conditions)
    text = evaluation.page(sheet, tmp_path / "page").read_text("utf-8")
    for words in (
        "Standings", "Against search", "While they think", "Under inexact perception",
        "What goes wrong", "Conditions and machines", "goes straight to where",
    ):  # fmt: skip
        assert words in text
    assert text.count("data:image/png;base64,") >= 8 and 'src="' in text
    assert [path.name for path in (tmp_path / "page").iterdir()] == ["index.html"]
    alone = evaluation.ask(["straight"], cases(suite)[-1:])
    assert "None of these" in evaluation.page(alone, tmp_path / "alone").read_text("utf-8")


def test_the_page_takes_strata_of_the_readers_own(suite, tmp_path):
    from gcm_learn.evaluation import cases

    own = suite.read_text("utf-8").replace('"stratum": "L"', '"stratum": "hard"', 1)
    suite.write_text(own, "utf-8")
    text = evaluation.page(evaluation.ask(["straight"], cases(suite)), tmp_path).read_text("utf-8")
    assert text.index("L [%]") < text.index("hard [%]")
